#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "rhoray/rhoray.h"

/// Small arrays with known fields, as a caller of the library has them.
namespace rhoray::tests {

/// Samples of a field on a lattice, values[k][j][i].
template <class T>
struct Samples {
  std::int64_t nx = 0, ny = 0, nz = 0;
  std::vector<T> values;

  ArrayView view() const { return {std::span<const T>(values), {nz, ny, nx}}; }
  FieldArray field(std::string name) const { return {.name = std::move(name), .values = view()}; }
};

/// @param value  of a sample (i, j, k)
template <class T, class Value>
Samples<T> samples_of(std::int64_t nx, std::int64_t ny, std::int64_t nz, const Value& value) {
  Samples<T> samples{nx, ny, nz, {}};
  for (std::int64_t k = 0; k < nz; ++k)
    for (std::int64_t j = 0; j < ny; ++j)
      for (std::int64_t i = 0; i < nx; ++i) samples.values.push_back(static_cast<T>(value(i, j, k)));
  return samples;
}

/// A field with many closed and open isosurfaces at 0.
inline double gyroid(double x, double y, double z) {
  return std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x);
}

/// 24 x 20 x 16 samples of a gyroid with a period of about 13 samples.
inline Samples<float> gyroid_samples() {
  return samples_of<float>(24, 20, 16, [](auto i, auto j, auto k) {
    return gyroid(0.5 * static_cast<double>(i), 0.5 * static_cast<double>(j), 0.5 * static_cast<double>(k));
  });
}

inline Dataset gyroid_grid(const PackOptions& options = {}) {
  const Samples<float> samples = gyroid_samples();
  return pack(GridArrays{.fields = {samples.field("gyroid")}, .spacing = {0.5, 0.5, 0.75}, .origin = {-3, 1, 2}},
              AxisOrder::zyx, options);
}

/// A mesh in arrays.
struct MadeMesh {
  std::vector<double> points;
  std::vector<std::int64_t> tetrahedra;

  std::int64_t point_count() const { return static_cast<std::int64_t>(points.size()) / 3; }
  std::int64_t cell_count() const { return static_cast<std::int64_t>(tetrahedra.size()) / 4; }
  Vec3 point(std::int64_t index) const {
    const double* const p = points.data() + 3 * index;
    return {p[0], p[1], p[2]};
  }
  /// @param value  of a point
  template <class Value>
  std::vector<double> point_values(const Value& value) const {
    std::vector<double> values;
    for (std::int64_t p = 0; p < point_count(); ++p) values.push_back(value(point(p)));
    return values;
  }
  MeshArrays arrays() const {
    return {.points = {std::span<const double>(points), {point_count(), 3}},
            .tetrahedra = {std::span<const std::int64_t>(tetrahedra), {cell_count(), 4}}};
  }
};

/// A box of n^3 cubes, each cut into six tetrahedra around its diagonal.
inline MadeMesh box_mesh(std::int64_t n, const Box3& box = {{0, 0, 0}, {1, 1, 1}}) {
  MadeMesh mesh;
  const auto along = [&](std::int64_t i, double low, double high) {
    return low + (high - low) * static_cast<double>(i) / static_cast<double>(n);
  };
  for (std::int64_t k = 0; k <= n; ++k)
    for (std::int64_t j = 0; j <= n; ++j)
      for (std::int64_t i = 0; i <= n; ++i)
        for (const double component :
             {along(i, box.min.x, box.max.x), along(j, box.min.y, box.max.y), along(k, box.min.z, box.max.z)})
          mesh.points.push_back(component);
  constexpr int paths[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (std::int64_t cube = 0; cube < n * n * n; ++cube)
    for (const auto& path : paths) {
      std::array<std::int64_t, 3> at{cube % n, cube / n % n, cube / n / n};
      const auto add = [&] { mesh.tetrahedra.push_back((at[2] * (n + 1) + at[1]) * (n + 1) + at[0]); };
      add();
      for (const int axis : path) ++at[static_cast<std::size_t>(axis)], add();
    }
  return mesh;
}

inline double distance(const Vec3& p, const Vec3& from = {}) {
  return std::hypot(p.x - from.x, p.y - from.y, p.z - from.z);
}

/// A mesh of [-1, 1]^3 with the distance from its middle ("radius"), the field "x", and the cell
/// field "part" (1 where x < 0, else 2).
inline Dataset ball_mesh(std::int64_t n = 6, const PackOptions& options = {}) {
  const MadeMesh mesh = box_mesh(n, {{-1, -1, -1}, {1, 1, 1}});
  const std::vector<double> radius = mesh.point_values([](const Vec3& p) { return distance(p); });
  const std::vector<double> x = mesh.point_values([](const Vec3& p) { return p.x; });
  std::vector<std::int32_t> part;
  for (std::int64_t cell = 0; cell < mesh.cell_count(); ++cell) {
    double sum = 0;
    for (std::int64_t corner = 0; corner < 4; ++corner)
      sum += mesh.point(mesh.tetrahedra[static_cast<std::size_t>(4 * cell + corner)]).x;
    part.push_back(sum < 0 ? 1 : 2);
  }
  MeshArrays arrays = mesh.arrays();
  arrays.point_fields = {{.name = "radius", .values = std::span<const double>(radius)},
                         {.name = "x", .values = std::span<const double>(x)}};
  arrays.cell_fields = {
      {.name = "part", .values = std::span<const std::int32_t>(part), .label_names = {{1, "left"}, {2, "right"}}}};
  arrays.length_unit = "mm";
  return pack(arrays, options);
}

/// An octahedron.
inline Dataset octahedron(const PackOptions& options = {}) {
  const std::vector<float> points{1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  const std::vector<std::uint8_t> triangles{0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  return pack(SurfaceArrays{.points = {std::span<const float>(points), {6, 3}},
                            .triangles = {std::span<const std::uint8_t>(triangles), {8, 3}}},
              options);
}

/// Rays in arrays of doubles.
struct MadeRays {
  std::vector<double> origins, directions;

  void add(const Vec3& origin, const Vec3& direction) {
    origins.insert(origins.end(), {origin.x, origin.y, origin.z});
    directions.insert(directions.end(), {direction.x, direction.y, direction.z});
  }
  std::int64_t count() const { return static_cast<std::int64_t>(origins.size()) / 3; }
  std::size_t size() const { return origins.size() / 3; }
  Rays rays() const {
    return {.origins = {std::span<const double>(origins), {count(), 3}},
            .directions = {std::span<const double>(directions), {count(), 3}}};
  }
  Vec3 at(std::size_t ray, double t) const {
    const double *const o = origins.data() + 3 * ray, *const d = directions.data() + 3 * ray;
    return {o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]};
  }
};

/// Rays between random points on a ball around a box. Directions have various lengths.
inline MadeRays random_rays(const Box3& box, std::size_t count, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const Vec3 middle{(box.min.x + box.max.x) / 2, (box.min.y + box.max.y) / 2, (box.min.z + box.max.z) / 2};
  const double radius = distance(box.min, box.max);
  const auto point = [&] {
    const Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
    const double scale = radius / distance(p);
    return Vec3{middle.x + scale * p.x, middle.y + scale * p.y, middle.z + scale * p.z};
  };
  MadeRays rays;
  for (std::size_t ray = 0; ray < count; ++ray) {
    const Vec3 from = point(),
               to{middle.x + radius / 3 * coordinate(random), middle.y + radius / 3 * coordinate(random),
                  middle.z + radius / 3 * coordinate(random)};
    const double length = 1 + coordinate(random) / 2;
    rays.add(from, {(to.x - from.x) * length, (to.y - from.y) * length, (to.z - from.z) * length});
  }
  return rays;
}

}  // namespace rhoray::tests
