#include "tools/lab/search_field.h"

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/brick_grid.h"

namespace rhoray::study {
namespace {

constexpr float nothing = -std::numeric_limits<float>::infinity();

Level leaf_level(const Field& field) {
  Level level{1, field.samples - Index3(1), {}};
  level.largest.reserve(static_cast<std::size_t>(level.count.x * level.count.y * level.count.z));
  for (std::int64_t k = 0; k < level.count.z; ++k)
    for (std::int64_t j = 0; j < level.count.y; ++j)
      for (std::int64_t i = 0; i < level.count.x; ++i) {
        float largest = nothing;
        for (int corner = 0; corner < 8; ++corner)
          largest = std::max(largest, field.sample(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2)));
        level.largest.push_back(largest);
      }
  return level;
}

Level level_above(const Level& below) {
  Level level{below.edge * 4, {}, {}};
  for (int axis = 0; axis < 3; ++axis) level.count[axis] = (below.count[axis] + 3) / 4;
  level.largest.assign(static_cast<std::size_t>(level.count.x * level.count.y * level.count.z), nothing);
  for (std::int64_t k = 0; k < below.count.z; ++k)
    for (std::int64_t j = 0; j < below.count.y; ++j)
      for (std::int64_t i = 0; i < below.count.x; ++i) {
        float& largest = level.largest[level.at({i / 4, j / 4, k / 4})];
        largest = std::max(largest, below.largest[below.at({i, j, k})]);
      }
  return level;
}

template <class T>
Field field_of(const formats::BrickGrid& grid) {
  Field field{grid.description().layout.sample_count, {}, {}};
  const std::span<const T> stored = grid.samples<T>();
  field.values.reserve(static_cast<std::size_t>(field.samples.x * field.samples.y * field.samples.z));
  for (std::int64_t k = 0; k < field.samples.z; ++k)
    for (std::int64_t j = 0; j < field.samples.y; ++j)
      for (std::int64_t i = 0; i < field.samples.x; ++i)
        field.values.push_back(static_cast<float>(stored[grid.tables().address(i, j, k)]));
  field.levels[0] = leaf_level(field);
  field.levels[1] = level_above(field.levels[0]);
  field.levels[2] = level_above(field.levels[1]);
  return field;
}

}  // namespace

Field load_field(const std::filesystem::path& path) {
  const formats::BrickGrid grid{formats::PackedFile::open(path)};
  if (grid.description().layout.is_sparse)
    throw Error(ErrorCode::unsupported, concat(path.string(), ": a sparse grid; expected a dense one"));
  return formats::with_element_type(grid.description().fields.front().type,
                                    [&](auto of_type) { return field_of<decltype(of_type)>(grid); });
}

std::optional<std::pair<double, double>> clip(const Field& field, const Line& ray) {
  double t_in = 0, t_out = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double t0 = -ray.origin[a] / ray.direction[a];
    const double t1 = (static_cast<double>(field.samples[a] - 1) - ray.origin[a]) / ray.direction[a];
    t_in = std::max(t_in, std::min(t0, t1)), t_out = std::min(t_out, std::max(t0, t1));
  }
  if (!(t_in < t_out)) return std::nullopt;
  return std::pair(t_in, t_out);
}

}  // namespace rhoray::study
