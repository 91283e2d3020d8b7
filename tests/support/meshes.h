#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <utility>

#include "preprocess/neutral.h"
#include "tests/support/fields.h"

namespace rhoray::tests {

inline Vec3 to_vec3(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}
inline std::array<double, 3> to_array(const Vec3& p) {
  return {p.x, p.y, p.z};
}

/// Adds a scalar point field that samples `field` at the points.
inline void add_point_field(preprocess::NeutralMesh& mesh, const std::string& name, const Field& field,
                            bool single_precision = false) {
  preprocess::NeutralField added;
  added.name = name;
  added.was_single_precision = single_precision;
  for (const auto& point : mesh.points) {
    const double value = field(to_vec3(point));
    added.values.push_back(single_precision ? static_cast<double>(static_cast<float>(value)) : value);
  }
  mesh.point_fields.push_back(std::move(added));
}

struct BoxMesh {
  Index3 cells{4, 4, 4};  ///< cubes per axis; each becomes six tetrahedra
  Box3 box{{0, 0, 0}, {1, 1, 1}};
  /// inner points move by up to this share of a cube's edge; up to 0.15 no cell is inverted
  double jitter = 0;
  /// last cube's edge over the first one's on every axis; volumes differ by its third power
  double grading = 1;
  std::uint64_t seed = 1;
};

/// A conforming mesh of a box: every cube is cut into six tetrahedra around its diagonal (Kuhn).
/// All cells are positive.
inline preprocess::NeutralMesh box_mesh(const BoxMesh& wanted) {
  preprocess::NeutralMesh mesh;
  const Index3 n = wanted.cells;
  std::mt19937_64 random(wanted.seed);
  std::uniform_real_distribution<double> shift(-wanted.jitter, wanted.jitter);

  // Along an axis the cubes' edges form a geometric series.
  const auto place = [&](double t, double low, double high) {
    const double share = wanted.grading == 1 ? t : (std::pow(wanted.grading, t) - 1) / (wanted.grading - 1);
    return t == 1 ? high : low + share * (high - low);
  };
  for (std::int64_t k = 0; k <= n.z; ++k)
    for (std::int64_t j = 0; j <= n.y; ++j)
      for (std::int64_t i = 0; i <= n.x; ++i) {
        double u = static_cast<double>(i), v = static_cast<double>(j), w = static_cast<double>(k);
        const bool inside = i > 0 && j > 0 && k > 0 && i < n.x && j < n.y && k < n.z;
        if (inside && wanted.jitter > 0) {
          u += shift(random);
          v += shift(random);
          w += shift(random);
        }
        mesh.points.push_back({place(u / static_cast<double>(n.x), wanted.box.min.x, wanted.box.max.x),
                               place(v / static_cast<double>(n.y), wanted.box.min.y, wanted.box.max.y),
                               place(w / static_cast<double>(n.z), wanted.box.min.z, wanted.box.max.z)});
      }

  const auto point_at = [&](const std::array<std::int64_t, 3>& at) {
    return static_cast<std::uint64_t>((at[2] * (n.y + 1) + at[1]) * (n.x + 1) + at[0]);
  };
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i) {
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {  // one tetrahedron for each path from corner 000 to corner 111 along the cube's edges
          std::array<std::int64_t, 3> at{i, j, k};
          std::array<std::uint64_t, 4> cell{point_at(at)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[axes[step]];
            cell[step + 1] = point_at(at);
          }
          const bool is_even = (axes[0] < axes[1]) ^ (axes[0] < axes[2]) ^ (axes[1] < axes[2]);
          if (!is_even) std::swap(cell[1], cell[2]);
          mesh.cells.push_back(cell);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return mesh;
}

/// The same with a point field "value" that samples `field`.
inline preprocess::NeutralMesh box_mesh(const BoxMesh& wanted, const Field& field, bool single_precision = false) {
  preprocess::NeutralMesh mesh = box_mesh(wanted);
  add_point_field(mesh, "value", field, single_precision);
  return mesh;
}

/// Disconnected tetrahedra scattered over the unit cube. Their vertices are within `size` of a
/// random position. They are squeezed to `flatness` of that along a random direction (1 = round,
/// 1e-9 = slivers, 0 = flat up to rounding).
inline preprocess::NeutralMesh strewn_mesh(std::size_t count, double size, double flatness, std::uint64_t seed) {
  preprocess::NeutralMesh mesh;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1), both(-1, 1);
  for (std::size_t c = 0; c < count; ++c) {
    const Vec3 place(unit(random), unit(random), unit(random));
    const Vec3 squeezed = Vec3(both(random), both(random), both(random)).normalized();
    std::array<std::uint64_t, 4> cell{};
    for (std::uint64_t& vertex : cell) {
      Vec3 offset(both(random), both(random), both(random));
      offset -= (1 - flatness) * offset.dot(squeezed) * squeezed;
      vertex = mesh.points.size();
      mesh.points.push_back(to_array(place + size * offset));
    }
    mesh.cells.push_back(cell);
  }
  return mesh;
}

}  // namespace rhoray::tests
