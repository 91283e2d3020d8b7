#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "formats/base/vector.h"

/// A field and its hierarchy as plain arrays, and the traversal of rays through them, for the study
/// of search orders.
namespace rhoray::study {

/// Largest values of cubes of 1, 4 and 16 cells per axis, x fastest.
struct Level {
  std::int64_t edge = 1;
  Index3 count;
  std::vector<float> largest;

  std::size_t at(const Index3& cell) const {
    return static_cast<std::size_t>((cell.z * count.y + cell.y) * count.x + cell.x);
  }
};

/// Samples as floats, and their hierarchy.
struct Field {
  Index3 samples;
  std::vector<float> values;
  std::array<Level, 3> levels;

  float sample(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return values[static_cast<std::size_t>((k * samples.y + j) * samples.x + i)];
  }
};

/// Refuses sparse grids (ErrorCode::unsupported).
Field load_field(const std::filesystem::path& path);

struct Line {
  Vec3 origin, direction;
};

/// The part of a ray inside one cell of a level.
struct Passage {
  Index3 cell;
  float bound;
  double t_in, t_out;
};

/// Visits the passages through cells of one level on a part of a ray, front to back.
template <class Visit>
void walk(const Level& level, const Line& ray, double t_in, double t_out, Visit&& visit) {
  const double edge = static_cast<double>(level.edge);
  Index3 cell;
  double exits[3], per_cell[3];
  std::int64_t step[3];
  const double inside = t_in + 1e-9 * (t_out - t_in);
  for (int a = 0; a < 3; ++a) {
    const double p = (ray.origin[a] + inside * ray.direction[a]) / edge;
    cell[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(p)), 0, level.count[a] - 1);
    step[a] = ray.direction[a] > 0 ? 1 : -1;
    const double next = edge * static_cast<double>(cell[a] + (step[a] > 0));
    exits[a] = (next - ray.origin[a]) / ray.direction[a];
    per_cell[a] = std::abs(edge / ray.direction[a]);
  }
  for (double t = t_in; t < t_out;) {
    const int axis = exits[0] <= exits[1] ? (exits[0] <= exits[2] ? 0 : 2) : (exits[1] <= exits[2] ? 1 : 2);
    const double leave = std::min(exits[axis], t_out);
    if (leave > t) visit(Passage{cell, level.largest[level.at(cell)], t, leave});
    t = std::max(t, leave);
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= level.count[axis]) return;
    exits[axis] += per_cell[axis];
  }
}

/// The part of a ray inside the field, or nothing.
std::optional<std::pair<double, double>> clip(const Field& field, const Line& ray);

}  // namespace rhoray::study
