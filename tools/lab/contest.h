#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene_spec.h"
#include "tools/analysis/table.h"
#include "tools/lab/peers/peer.h"
#include "tools/lab/rounds.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/data_choice.h"

/// Systems that show the same data from the same cameras, timed in turn and compared with the exact
/// answer.
namespace rhoray::study {

/// The user's settings of such a study.
struct ContestSettings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string field;
  std::vector<std::string> isovalues{"auto"};
  std::vector<std::string> views{"front", "from-feet", "close-up", "inside"};
  std::vector<std::string> systems;  ///< empty: all
  bool mip = false, no_isosurfaces = false;
  std::string truth = "exact";
  render::PictureSize size{512, 512};
  RoundsOptions rounds;

  bool wants(const std::string& system) const;
};

/// The rows of --help for these settings.
/// @param systems  the words that --systems accepts
std::vector<tools::Option> contest_options(ContestSettings& settings, const std::vector<std::string>& systems,
                                           const std::string& tables);

/// Refuses impossible settings (ErrorCode::usage), and sets one thread for libraries that read the
/// environment.
/// @param name  of the tables, as for run_contest
void prepare_contest(const ContestSettings& settings, const std::vector<std::string>& systems, const std::string& name);

/// The data as the systems receive them, and what is shown of them.
struct Subject {
  PeerData data;
  render::Dataset dataset;
  std::vector<double> isovalues;
  std::vector<tools::StudyView> views;
  double unit;            ///< unit of errors along the ray, in world units
  std::string unit_name;  ///< "voxel"
  Json about;             ///< for the tables' context

  /// @param data  without its bounds and range, which the packed file provides
  Subject(const ContestSettings& settings, const PeerData& data, double unit, const std::string& unit_name);
};

/// The systems that answer one query, and those that cannot run here, with the reason.
struct Contest {
  std::vector<PeerPointer> peers;
  Json left_out = Json::object();

  void add(PeerPointer peer) { peers.push_back(std::move(peer)); }
};

/// Runs the requested systems and publishes the results as tables NAME_isosurface and NAME_mip.
/// @param isosurfaces  makes the contestants for one isovalue
/// @param largest      makes the contestants for largest values
void run_contest(const ContestSettings& settings, const Subject& subject, const std::string& name,
                 const std::function<Contest()>& isosurfaces, const std::function<Contest()>& largest);

}  // namespace rhoray::study
