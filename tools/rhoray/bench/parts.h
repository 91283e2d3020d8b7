#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "render/framebuffer.h"
#include "render/scene_spec.h"
#include "tools/analysis/measure.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

// Shared by the tables.

struct BenchOptions {
  std::filesystem::path input;
  render::ReadSpec read{};       ///< of an input that is not packed
  std::filesystem::path packed;  ///< the input, or its packed copy; empty where no table reads one
  std::vector<std::string> isovalues{"auto"};
  std::string field;
  std::string accuracy;  ///< as in render
  std::string view = "iso";
  std::string normals, color_by;       ///< as in render
  render::PictureSize size{512, 512};  ///< the paper's
  int repeat = 5;
  unsigned threads = 0;
  bool mip = false;               ///< also rows of maximum intensity projection
  std::filesystem::path scratch;  ///< folder for files that are written to be timed
  std::uint64_t memory_limit_bytes = 0;
};

/// Called with a progress message before each measurement.
using Step = std::function<void(std::string_view what)>;

/// The conditions of a measurement: machine, options and input.
Json bench_context(const BenchOptions& options);

/// seconds[row] of act(row), every row once untimed and then `repeat` times, round after round.
std::vector<std::vector<double>> interleaved(std::size_t row_count, int repeat,
                                             const std::function<double(std::size_t row)>& act);

/// The middle under a name, smallest and largest beside it.
void add_spread(Json& row, const std::string& name, const Spread& spread);

/// Of the colours, as the framebuffer holds them; 16 hexadecimal digits (XXH3).
std::string picture_hash(const render::Framebuffer& picture);

}  // namespace rhoray::tools
