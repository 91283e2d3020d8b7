#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/json.h"
#include "formats/base/pending_file.h"
#include "formats/packed_file.h"
#include "tools/analysis/table.h"

namespace rhoray::tools {

/// What rhoray-validate-worker found, as text, tables and pictures.
class ValidationReport {
 public:
  /// @param answer  what the worker handed over (tools/validate/request.h)
  explicit ValidationReport(formats::PackedFile answer);

  /// Adds what was asked.
  /// @param version  of this program
  void add_context(const Json& context, double seconds, const std::string& version);

  const Json& json() const { return json_; }
  std::string text() const;

  /// report.txt, report.json, rays.csv, errors.csv, limits.csv, disputed_rays.csv; with a picture
  /// signed_distance.png and depth_error.png. Makes the folder if it is not there. All files
  /// appear, or none and no new folder.
  void write(const std::filesystem::path& folder, bool replace_existing) const;

  /// Throws the checks that do not hold (ErrorCode::outside_limit).
  void refuse_outside_limits(const std::string& name) const;

 private:
  Table table(const char* key, const char* name, const char* title) const;
  std::vector<Table> tables() const;
  void add_files(const std::filesystem::path& folder, PendingFiles& files) const;

  formats::PackedFile answer_;
  Json json_;
};

/// Refuses a folder in which the report could not be written at the end of the work
/// (ErrorCode::usage).
void require_report_folder(const std::filesystem::path& folder, bool replace_existing);

}  // namespace rhoray::tools
