#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/brick_grid.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"

/// Grids with all features of version 1.1, array by array, so that a test can also corrupt one.
namespace rhoray::tests {

template <class T>
std::string bytes_of_all(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

struct MadeField {
  std::string name;
  std::function<float(std::int64_t, std::int64_t, std::int64_t)> value;
  bool is_certified = false;
};

struct MadeGridChoice {
  Index3 sample_count{9, 6, 5};
  std::int64_t brick_edge = 4;
  bool is_sparse = false;
  std::array<std::vector<double>, 3> axes{};
  MacroChoice macro{};
};

struct MadeGrid {
  formats::GridDescription description;
  std::map<std::string, std::string> arrays;  ///< bytes by name

  std::string file() const {
    const MemoryFile memory;
    formats::PackedFileWriter writer(memory.descriptor(), formats::describe(description),
                                     formats::grid_arrays(description));
    for (const auto& [name, bytes] : arrays) writer.write(name, 0, std::as_bytes(std::span(bytes)));
    writer.commit();
    return memory.content();
  }
};

inline formats::BrickGrid opened(const std::string& file) {
  const MemoryFile memory(file);
  return formats::BrickGrid(formats::PackedFile::from_descriptor(memory.descriptor(), "g.rho"));
}

/// Extracts brick b of `samples`, which are stored brick by brick, with NaN as padding. True if it
/// holds data.
inline bool take_brick(const MadeGridChoice& choice, const std::vector<float>& samples, std::int64_t b,
                       std::vector<float>& brick) {
  const std::int64_t n = choice.brick_edge;
  const Index3 count = formats::BrickLayout::sparse(choice.sample_count, 0, n).brick_count();
  const Index3 low = Index3(b % count.x, b / count.x % count.y, b / count.x / count.y) * n;
  bool holds_data = false;
  for (std::int64_t at = 0; at < n * n * n; ++at) {
    const Index3 p = low + Index3(at % n, at / n % n, at / n / n);
    const bool is_padding =
        p.x >= choice.sample_count.x || p.y >= choice.sample_count.y || p.z >= choice.sample_count.z;
    brick.push_back(is_padding ? std::numeric_limits<float>::quiet_NaN()
                               : samples[static_cast<std::size_t>(b * n * n * n + at)]);
    holds_data = holds_data || std::isfinite(brick.back());
  }
  return holds_data;
}

/// Fields of F32 in bricks without superbricks. A sparse grid keeps the bricks in which a field has
/// data, last one first.
inline MadeGrid made_grid(const MadeGridChoice& choice, const std::vector<MadeField>& fields) {
  MadeGrid made;
  formats::GridDescription& d = made.description;
  const formats::BrickLayout dense = formats::BrickLayout::bricked(choice.sample_count, choice.brick_edge, 1);
  const std::int64_t brick_count = volume(dense.brick_count());
  std::vector<std::vector<float>> samples;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const GridSample<float> sample = sample_grid<float>(dense, fields[f].value, choice.macro);
    if (f == 0) d = sample.description;
    if (f > 0) d.fields.push_back(sample.description.fields[0]);
    d.fields[f].name = fields[f].name;
    for (std::size_t l = 0; l < sample.levels.size(); ++l)
      made.arrays[concat(formats::macro_prefix(f), l + 1)] = bytes_of_all(sample.levels[l]);
    samples.push_back(sample.samples);
    if (!fields[f].is_certified) continue;
    std::vector<float> largest, mean;
    for (std::int64_t b = 0; b < brick_count; ++b) {
      largest.push_back(b == 1 ? 0.5F : 0.25F);
      mean.push_back(b == 1 ? 0.125F : 0.0625F);
    }
    d.certificates[f] = {.max_error = 0.5, .rms_error = 0.1, .max_at = {1, 2, 3}, .point_count = 12345};
    made.arrays[formats::error_array(f, "max")] = bytes_of_all(largest);
    made.arrays[formats::error_array(f, "rms")] = bytes_of_all(mean);
  }
  d.axes = choice.axes;
  for (int axis = 0; axis < 3; ++axis)
    if (const auto& table = d.axes[static_cast<std::size_t>(axis)]; !table.empty())
      made.arrays[formats::axis_array(axis)] = bytes_of_all(table);

  std::vector<std::vector<float>> stored(fields.size());
  std::vector<std::uint32_t> slots(static_cast<std::size_t>(brick_count), formats::BrickGrid::no_brick);
  std::uint32_t used = 0;
  for (std::int64_t b = brick_count - 1; b >= 0; --b) {
    std::vector<std::vector<float>> bricks(fields.size());
    bool holds_data = false;
    for (std::size_t f = 0; f < fields.size(); ++f) holds_data |= take_brick(choice, samples[f], b, bricks[f]);
    if (!holds_data) continue;
    for (std::size_t f = 0; f < fields.size(); ++f)
      stored[f].insert(stored[f].end(), bricks[f].begin(), bricks[f].end());
    slots[static_cast<std::size_t>(b)] = used++;
  }
  for (std::size_t f = 0; f < fields.size(); ++f)
    made.arrays[formats::samples_array(f)] = bytes_of_all(choice.is_sparse ? stored[f] : samples[f]);
  if (choice.is_sparse) {
    d.layout = formats::BrickLayout::sparse(choice.sample_count, used, choice.brick_edge);
    made.arrays["bricks"] = bytes_of_all(slots);
  }
  return made;
}

}  // namespace rhoray::tests
