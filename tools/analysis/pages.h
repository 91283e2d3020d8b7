#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/pending_file.h"
#include "tools/analysis/results.h"

namespace rhoray::tools {

/// Refuses a folder that cannot be made, and one with anything in it unless told to go ahead (ErrorCode::usage). Makes
/// nothing.
void require_results_folder(const std::filesystem::path& folder, bool may_replace);

/// Writes what a study has found out so far into a folder, again and again; every file is whole at any time:
/// results.csv, results.json, report.html, and for each layer plots (.svg) and pictures (.png).
class ResultsFolder {
 public:
  /// Makes the folder where it is not there, and removes it again if nothing comes into it. Refuses as
  /// require_results_folder.
  ResultsFolder(std::filesystem::path folder, bool may_replace);
  ResultsFolder(const ResultsFolder&) = delete;
  ResultsFolder& operator=(const ResultsFolder&) = delete;
  ~ResultsFolder();

  /// The files of one call appear together or not at all. Adds a note where gnuplot fails; then the tables and the page
  /// are there without plots.
  void write(const std::vector<const LayerStudy*>& layers, StudyContext& context);

 private:
  struct Figure {
    std::string title, caption, body;  ///< HTML
  };
  std::vector<Figure> plots(const LayerStudy& layer, const std::string& prefix, StudyContext& context);
  std::string pictures(const LayerStudy& layer, const std::string& prefix);
  std::string picture(const render::Framebuffer& pixels, const std::string& name, const std::string& description);
  std::string layer_section(const LayerStudy& layer, const std::string& prefix, StudyContext& context);

  std::filesystem::path folder_;
  bool is_made_ = false;
  std::optional<PendingFiles> files_;  ///< of the call of `write`
  bool has_gnuplot_ = true;            ///< until it turns out not to
  /// Of a layer, as HTML.
  struct Pictures {
    std::shared_ptr<const TruePicture> of_pass{};  ///< held, so that no later pass has its address; null: of none
    std::string shown{};
  };
  std::map<std::string, Pictures> pictures_;  ///< by layer
};

}  // namespace rhoray::tools
