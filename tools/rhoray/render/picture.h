#pragma once

#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "render/accuracy.h"
#include "render/document.h"
#include "render/render.h"
#include "tools/pictures/stored_picture.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/render/command.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// Seconds of the stations on the way to a picture.
struct StageTimes {
  double open_s = 0;
  double prove_s = 0;  ///< stored ranges
  double trace_s = 0;
  double wait_for_checks_s = 0;
  double write_s = 0;
};

/// A picture on its way: its scene, and what was found in making it.
struct Drawn {
  std::filesystem::path output;
  bool to_stdout = false;
  render::ResolvedScene plan;
  render::RangeProof range_proof;  ///< before anything is traced; then a part of the statistics
  render::FrameStatistics statistics;
  StageTimes stations;
  std::vector<Json> picks;
  Interval<double> heat;
  std::string reproduce;
  std::vector<render::Choice> choices;
  std::optional<render::SelfCheck> self_check;
};

/// Checksums of all files, read beside the rendering.
class Checks {
 public:
  Checks(const RenderCommand& command, const render::ResolvedScene& plan);

  /// @return  seconds
  double wait();

 private:
  std::future<void> running_;
};

/// Removes default annotations from the plan if the file is an EXR, whose pixels are data, or if
/// they cannot be drawn, which a note says.
void settle_annotations(const render::SceneSpec& asked, const std::filesystem::path& output,
                        render::ResolvedScene& plan);

/// Whether the picture has no background.
bool keeps_alpha(const render::SceneSpec& scene_spec);

/// What is refused before anything is traced.
/// @param sheet  a picture of several frames that is kept beside the one being traced
void require_picture(const RenderCommand& command, const std::filesystem::path& output,
                     const render::ResolvedScene& plan, const DataAccess& access,
                     const render::PictureSize& sheet = {.width = 0, .height = 0});

/// Proves the stored ranges of all data, for exact arithmetic that chooses a method or checks
/// pixels: where they do not hold, nothing is traced. Those that the picture's own method relies on
/// are proven by render::render.
void prove_ranges(const RenderCommand& command, Drawn& drawn, const Progress& progress);

/// Traces the picture and draws over it.
render::Framebuffer trace(const RenderCommand& command, render::RenderContext& memory, Drawn& drawn,
                          const Progress& progress = {});

/// The texts of a picture file, with which `render` draws it again.
/// @param folder   that file names in the scene are made relative to; empty: as they are
/// @param command  that draws it again
std::vector<PictureText> texts_of_picture(const render::SceneSpec& scene, const std::filesystem::path& folder,
                                          const std::string& command, std::string_view machine);

/// Writes a picture with all that makes it again.
void write(const RenderCommand& command, const render::Framebuffer& picture, const render::SceneSpec& scene,
           Drawn& drawn);

/// Traces the picture, and writes it when the files are known to be well.
void draw(const RenderCommand& command, render::RenderContext& memory, Checks& checks, Drawn& drawn,
          const Progress& progress = {});

}  // namespace rhoray::tools
