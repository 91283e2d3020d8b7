#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <stop_token>
#include <string>

#include "formats/base/error.h"
#include "formats/base/progress.h"
#include "preprocess/neutral.h"
#include "render/load.h"
#include "tools/analysis/border.h"
#include "tools/analysis/variant.h"

namespace rhoray::tools {

/// A form of the data, ready to be rendered: own value = scale * (value - offset).
struct FormedData {
  render::Dataset dataset;
  double scale = 1, offset = 0;
  double preprocess_s = 0;
  std::uint64_t file_bytes = 0;
  std::shared_ptr<const ResampledBorder> border{};  ///< for a mesh that was resampled, else null

  double own(double value) const { return scale * (value - offset); }
  double original(double own_value) const { return own_value / scale + offset; }
};

struct FormOptions {
  std::filesystem::path folder;          ///< for the copies
  std::uint64_t memory_limit_bytes = 0;  ///< 0: half of the machine's memory
  double seconds = 0;                    ///< limit; a copy that would take longer is not made
  Progress progress{};
};

/// The forms of one volume. Each is made at the first request and kept.
class DataForms {
 public:
  explicit DataForms(render::Dataset dataset) : dataset_(std::move(dataset)) {}

  /// Refuses a form that does not apply or does not fit, with an Error that gives the reason
  /// (ErrorCode::unsupported or resource). If progress throws to interrupt the work, its exception
  /// passes through.
  const FormedData& get(const DataForm& form, const FormOptions& options);

 private:
  FormedData make(const DataForm& form, const FormOptions& options);
  FormedData quantize_grid(int bits, const FormOptions& options) const;
  FormedData quantize_mesh(int bits, const FormOptions& options);
  const preprocess::NeutralMesh& mesh();
  FormedData resample(const DataForm& form, const FormOptions& options);
  double foreseen_s(const DataForm& form) const;

  render::Dataset dataset_;
  /// The volume, if it is a mesh and copies were requested.
  std::unique_ptr<preprocess::NeutralMesh> mesh_;
  std::map<std::string, FormedData> made_;
  std::map<std::string, Error> refused_;
  DataForm last_;      ///< the last one sampled to a grid
  double last_s_ = 0;  ///< its sampling time
};

}  // namespace rhoray::tools
