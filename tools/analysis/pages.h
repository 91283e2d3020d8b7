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

/// Refuses a folder that cannot be created, and a folder that is not empty unless may_replace is
/// set (ErrorCode::usage). Creates nothing.
void require_results_folder(const std::filesystem::path& folder, bool may_replace);

/// Writes the results of a study so far into a folder, repeatedly. Every file is complete at any
/// time: results.csv, results.json, report.html, and for each layer plots (.svg) and pictures
/// (.png).
class ResultsFolder {
 public:
  /// Creates the folder if it does not exist, and removes it again if it stays empty. Refuses as
  /// require_results_folder does.
  ResultsFolder(std::filesystem::path folder, bool may_replace);
  ResultsFolder(const ResultsFolder&) = delete;
  ResultsFolder& operator=(const ResultsFolder&) = delete;
  ~ResultsFolder();

  /// The files of one call appear together or not at all. If gnuplot fails, adds a note and writes
  /// tables and page without plots.
  void write(const std::vector<const LayerStudy*>& layers, StudyContext& context);

 private:
  // For the template of the page (report.html).
  Json plots(const LayerStudy& layer, const std::string& prefix, StudyContext& context);
  Json galleries(const LayerStudy& layer, const std::string& prefix);
  Json picture(const render::Framebuffer& pixels, const std::string& name, const std::string& description);
  void add_layer(const LayerStudy& layer, const std::string& prefix, StudyContext& context, Json& section);

  std::filesystem::path folder_;
  std::string version_;  ///< of this program
  bool is_made_ = false;
  std::optional<PendingFiles> files_;  ///< of the current call of `write`
  bool has_gnuplot_ = true;            ///< false once it turns out to be missing
  /// Pictures of a layer.
  struct Pictures {
    /// Kept alive, so that no later pass has its address; null: belongs to no pass.
    std::shared_ptr<const TruePicture> of_pass{};
    Json shown{};
  };
  std::map<std::string, Pictures> pictures_;  ///< by layer
};

}  // namespace rhoray::tools
