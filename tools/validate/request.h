#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace rhoray::tools::validate {

/// Parameters that `rhoray validate` passes to its worker.
struct Request {
  std::string file;   ///< a packed file
  std::string field;  ///< name
  double isovalue = 0;
  std::uint64_t samples = 100'000;
  std::uint64_t seed = 1;
  unsigned threads = 0;        ///< 0: all cores
  double max_depth_error = 0;  ///< 0: the default of the kind
  /// Numbered as in render::Method; the next three belong to it.
  int algorithm = 0, precision = 1;
  double step = 0.5, slack = 0;
  bool bisect = false;
  int picture_width = 0, picture_height = 0;  ///< 0: no picture
};

std::string text_of(const Request& request);
/// Refuses text that text_of would not have written (ErrorCode::usage).
Request request_from(std::string_view text);

// The worker sends a packed file of this kind. It contains the report as JSON and, if there is a
// picture, three arrays [height, width].
inline constexpr const char* report_kind = "validation";
inline constexpr const char* report_array = "report";  ///< U8: the text
/// F32, cells: from the reference; positive above it
inline constexpr const char* distance_array = "distance";
/// F32, cells: along the ray; both NaN where there is none
inline constexpr const char* depth_array = "depth";
inline constexpr const char* verdict_array = "verdict";  ///< U8: a Verdict, or no_verdict
inline constexpr std::uint8_t no_verdict = 255;          ///< correctly no hit

}  // namespace rhoray::tools::validate
