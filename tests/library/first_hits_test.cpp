// First hits, largest values and all hits of rays, compared with fields whose answers are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/equal_bytes.h"

namespace rhoray::tests {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Memory for all answers of some rays.
struct Answers {
  explicit Answers(std::size_t rays) : t(rays), error(rays), value(rays), gradient(3 * rays), cell(rays) {}

  Hits hits(bool with_error = true) {
    return {.t = t,
            .error = with_error ? std::span<double>(error) : std::span<double>(),
            .value = value,
            .gradient = gradient,
            .cell = cell};
  }
  friend bool operator==(const Answers& a, const Answers& b) {
    return equal_bytes(a.t, b.t) && equal_bytes(a.error, b.error) && equal_bytes(a.value, b.value) &&
           equal_bytes(a.gradient, b.gradient) && equal_bytes(a.cell, b.cell);
  }

  std::vector<double> t, error, value, gradient;
  std::vector<std::uint64_t> cell;
};

/// A field x + 2 y + 4 z of samples at whole numbers.
Dataset ramp_grid() {
  const Samples<std::int32_t> samples =
      samples_of<std::int32_t>(9, 8, 7, [](auto i, auto j, auto k) { return i + 2 * j + 4 * k; });
  return pack({.fields = {samples.field("ramp")}}, AxisOrder::zyx);
}

bool is_within(const Vec3& p, const Box3& box) {
  return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y && p.z >= box.min.z &&
         p.z <= box.max.z;
}

TEST(FirstHits, of_a_ramp_are_where_it_has_the_isovalue) {
  const Dataset grid = ramp_grid();
  const MadeRays rays = random_rays(grid.bounds(), 400);
  for (const Accuracy accuracy : {Accuracy::certified, Accuracy::exact}) {
    Answers found(rays.size());
    RayScratch scratch;
    RayCaster(grid, Isosurface{20}, accuracy).first_hits(rays.rays(), found.hits(), scratch);
    std::size_t hits = 0;
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
      // The plane x + 2 y + 4 z = 20, and the point on it.
      const double* const o = rays.origins.data() + 3 * ray;
      const double* const d = rays.directions.data() + 3 * ray;
      const double t = (20 - (o[0] + 2 * o[1] + 4 * o[2])) / (d[0] + 2 * d[1] + 4 * d[2]);
      const Vec3 p = rays.at(ray, t);
      if (!(t >= 0 && is_within(p, grid.bounds()))) {
        EXPECT_EQ(found.t[ray], infinite);
        EXPECT_EQ(found.cell[ray], no_cell);
        EXPECT_TRUE(std::isnan(found.value[ray]) && std::isnan(found.error[ray]));
        EXPECT_EQ(found.gradient[3 * ray], 0);
        continue;
      }
      ++hits;
      constexpr double rounding = 1e-13;  // of this test's own t
      EXPECT_LE(std::abs(found.t[ray] - t), found.error[ray] + rounding) << ray;
      EXPECT_LE(found.error[ray], accuracy == Accuracy::exact ? 1e-12 : 1e-4);
      EXPECT_NEAR(found.value[ray], 20, 1e-3);
      EXPECT_NEAR(found.gradient[3 * ray], 1, 1e-9);
      EXPECT_NEAR(found.gradient[3 * ray + 1], 2, 1e-9);
      EXPECT_NEAR(found.gradient[3 * ray + 2], 4, 1e-9);
      const std::uint64_t i = found.cell[ray] % 8, j = found.cell[ray] / 8 % 7, k = found.cell[ray] / 56;
      const Vec3 low{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
      EXPECT_TRUE(is_within(
          p, {{low.x - 1e-9, low.y - 1e-9, low.z - 1e-9}, {low.x + 1 + 1e-9, low.y + 1 + 1e-9, low.z + 1 + 1e-9}}));
    }
    EXPECT_GT(hits, 100U);
    EXPECT_LT(hits, 399U);
  }
}

/// A distance field around the middle of a cube of 15^3 cells.
Dataset ball_grid(double spacing) {
  const Samples<double> samples = samples_of<double>(16, 16, 16, [](auto i, auto j, auto k) {
    const auto from_middle = [](auto index) { return static_cast<double>(index) - 7.5; };
    return std::hypot(from_middle(i), from_middle(j), from_middle(k));
  });
  return pack({.fields = {samples.field("radius")}, .spacing = {spacing, spacing, spacing}}, AxisOrder::zyx);
}

TEST(FirstHits, are_found_at_both_ends_of_the_range_of_rays) {
  for (const double spacing : {1.0, 1e90, 1e-90}) {
    const Dataset grid = ball_grid(spacing);
    const RayCaster certified(grid, Isosurface{5}, Accuracy::certified), exact(grid, Isosurface{5}, Accuracy::exact);
    RayScratch scratch;
    for (const double length : {1e-109, 1e-50, 1.0, 1e50, 1e109})
      for (const double distance : {5.0, 1e10, 1e100, 0.9e150}) {
        MadeRays rays;
        for (int axis = 0; axis < 3; ++axis)
          for (const double way : {1.0, -1.0}) {
            std::array<double, 3> from{7.4 * spacing, 7.4 * spacing, 7.4 * spacing}, direction{};
            from[static_cast<std::size_t>(axis)] = -way * distance * spacing + (way < 0 ? 15 * spacing : 0);
            direction[static_cast<std::size_t>(axis)] = way * length * spacing;
            rays.add({from[0], from[1], from[2]}, {direction[0], direction[1], direction[2]});
          }
        Answers found(rays.size()), expected(rays.size());
        certified.first_hits(rays.rays(), found.hits(), scratch);
        exact.first_hits(rays.rays(), expected.hits(), scratch);
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
          EXPECT_LT(expected.t[ray], infinite) << spacing << ' ' << length << ' ' << distance << ' ' << ray;
          EXPECT_LE(std::abs(found.t[ray] - expected.t[ray]), found.error[ray] + expected.error[ray])
              << spacing << ' ' << length << ' ' << distance << ' ' << ray;
        }
      }
  }
}

/// Interpolated linearly, the distance from the middle is at least the distance, and at most by the
/// square of a cell's diameter over 8 radii above it.
TEST(FirstHits, of_a_ball_in_a_mesh_are_near_the_ball) {
  constexpr double radius = 0.7;
  const Dataset mesh = ball_mesh(12);
  const MadeRays rays = random_rays(mesh.bounds(), 300);
  Answers certified(rays.size()), exact(rays.size());
  RayScratch scratch;
  RayCaster(mesh, Isosurface{radius}, Accuracy::certified, "radius").first_hits(rays.rays(), certified.hits(), scratch);
  RayCaster(mesh, Isosurface{radius}, Accuracy::exact, "radius").first_hits(rays.rays(), exact.hits(), scratch);
  std::size_t hits = 0;
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    EXPECT_EQ(std::isinf(certified.t[ray]), std::isinf(exact.t[ray]));
    if (std::isinf(exact.t[ray])) continue;
    ++hits;
    EXPECT_LE(std::abs(certified.t[ray] - exact.t[ray]), certified.error[ray] + exact.error[ray]);
    EXPECT_LE(exact.error[ray], 1e-14);
    const double found = distance(rays.at(ray, exact.t[ray]));
    EXPECT_LE(found, radius + 1e-12);
    constexpr double diameter_squared = 3.0 / 36;
    EXPECT_GE(found, radius - diameter_squared / 8 / (radius - 0.1));
    const double* const g = exact.gradient.data() + 3 * ray;
    EXPECT_NEAR(distance({g[0], g[1], g[2]}), 1, 0.2);
  }
  EXPECT_GT(hits, 100U);
}

TEST(FirstHits, do_not_depend_on_scratch_context_threads_or_order) {
  const Dataset data[] = {gyroid_grid(), ball_mesh()};
  for (const Dataset& each : data) {
    const double isovalue = each.kind() == DataKind::grid ? 0.1 : 0.8;
    const MadeRays rays = random_rays(each.bounds(), 2500, 5);
    const std::size_t n = rays.size();
    for (const Accuracy accuracy : {Accuracy::float32, Accuracy::certified}) {
      const bool proves = accuracy == Accuracy::certified;
      const RayCaster caster(each, Isosurface{isovalue}, accuracy);
      Answers expected(n);
      RayScratch scratch;
      caster.first_hits(rays.rays(), expected.hits(proves), scratch);
      for (const unsigned threads : {1U, 2U, 8U}) {
        RenderContext context({.threads = threads});
        Answers found(n);
        caster.first_hits(rays.rays(), found.hits(proves), context);
        EXPECT_TRUE(found == expected) << threads;
      }
      std::vector<std::size_t> order(n);
      std::iota(order.begin(), order.end(), 0);
      std::shuffle(order.begin(), order.end(), std::mt19937(3));
      MadeRays shuffled;
      for (const std::size_t ray : order) {
        const double* const d = rays.directions.data() + 3 * ray;
        shuffled.add(rays.at(ray, 0), {d[0], d[1], d[2]});
      }
      Answers in_order(n), found(n);
      const RayCaster copy = caster;
      copy.first_hits(shuffled.rays(), found.hits(proves), scratch);
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_EQ(found.t[i], expected.t[order[i]]);
        EXPECT_EQ(found.cell[i], expected.cell[order[i]]);
      }
      std::vector<std::uint8_t> is_hit(n);
      caster.any_hits(rays.rays(), is_hit, scratch);
      RenderContext context;
      std::vector<std::uint8_t> again(n, 7);
      caster.any_hits(rays.rays(), again, context);
      EXPECT_EQ(is_hit, again);
      for (std::size_t ray = 0; ray < n; ++ray) EXPECT_EQ(is_hit[ray] == 1, std::isfinite(expected.t[ray]));
    }
  }
}

TEST(FirstHits, take_floats_and_any_strides) {
  const Dataset grid = gyroid_grid();
  MadeRays rays = random_rays(grid.bounds(), 200);
  for (double& number : rays.origins) number = static_cast<float>(number);
  for (double& number : rays.directions) number = static_cast<float>(number);
  const RayCaster caster(grid, Isosurface{0}, Accuracy::certified);
  Answers expected(200), found(200);
  RayScratch scratch;
  caster.first_hits(rays.rays(), expected.hits(), scratch);
  // Records of a ray tracer: origin, a number, direction, a number.
  std::vector<float> records;
  for (std::size_t ray = 0; ray < 200; ++ray) {
    for (std::size_t axis = 0; axis < 3; ++axis) records.push_back(static_cast<float>(rays.origins[3 * ray + axis]));
    records.push_back(0);
    for (std::size_t axis = 0; axis < 3; ++axis) records.push_back(static_cast<float>(rays.directions[3 * ray + axis]));
    records.push_back(1e30F);
  }
  const std::array<std::int64_t, 2> shape{200, 3}, strides{32, 4};
  const std::array<std::int64_t, 1> count{200}, stride{32};
  caster.first_hits({.origins = ArrayView(records.data(), ElementType::F32, shape, strides),
                     .directions = ArrayView(records.data() + 4, ElementType::F32, shape, strides),
                     .t_min = ArrayView(records.data() + 3, ElementType::F32, count, stride),
                     .t_max = ArrayView(records.data() + 7, ElementType::F32, count, stride)},
                    found.hits(), scratch);
  EXPECT_TRUE(found == expected);
  // The last ray first, components apart, one direction for all.
  std::vector<double> components(600);
  for (std::size_t ray = 0; ray < 200; ++ray)
    for (std::size_t axis = 0; axis < 3; ++axis) components[axis * 200 + ray] = rays.origins[3 * ray + axis];
  const std::array<double, 3> direction{0.3, -1, 0.2};
  const std::array<std::int64_t, 2> backwards{-8, 1600}, same{0, 8};
  caster.first_hits({.origins = ArrayView(components.data() + 199, ElementType::F64, shape, backwards),
                     .directions = ArrayView(direction.data(), ElementType::F64, shape, same)},
                    found.hits(), scratch);
  MadeRays plain;
  for (std::size_t ray = 200; ray-- > 0;) plain.add(rays.at(ray, 0), {0.3, -1, 0.2});
  caster.first_hits(plain.rays(), expected.hits(), scratch);
  EXPECT_TRUE(found == expected);
}

TEST(FirstHits, lie_between_the_ends_of_their_rays) {
  const Dataset grid = ramp_grid();
  const RayCaster caster(grid, Isosurface{20}, Accuracy::exact);
  MadeRays rays;
  for (int i = 0; i < 5; ++i) rays.add({-1, 4, 2}, {2, 0, 0});  // x + 8 + 8 = 20 at x = 4, t = 2.5
  const std::vector<double> low{0, 2.5, 2.6, 0, 3}, high{infinite, 2.5, 9, 2.4, 1};
  Rays limited = rays.rays();
  limited.t_min = std::span<const double>(low);
  limited.t_max = std::span<const double>(high);
  Answers found(5);
  RayScratch scratch;
  caster.first_hits(limited, found.hits(), scratch);
  EXPECT_EQ(found.t[0], 2.5);
  EXPECT_EQ(found.t[2], infinite);
  EXPECT_EQ(found.t[3], infinite);
  EXPECT_EQ(found.t[4], infinite) << "an empty interval";
  limited.t_max = {};
  caster.first_hits(limited, found.hits(), scratch);
  EXPECT_EQ(found.t[0], 2.5);
  EXPECT_EQ(found.t[2], infinite);
}

TEST(FirstHits, of_no_rays_are_none) {
  const std::span<const double> none;
  RayScratch scratch;
  RenderContext context;
  const RayCaster caster(gyroid_grid(), Isosurface{0}, Accuracy::float64);
  const Rays rays{.origins = {none, {0, 3}}, .directions = {none, {0, 3}}};
  caster.first_hits(rays, {}, scratch);
  caster.first_hits(rays, {}, context);
  AllHits all;
  caster.all_hits(rays, all, context);
  EXPECT_EQ(all.first, std::vector<std::uint64_t>{0});
}

TEST(FirstHits, are_those_of_the_picture) {
  constexpr Size size{40, 30};
  Scene scene = certified_scene(gyroid_grid(), 0.1, size);
  scene.camera->orthographic_height = 20;
  const Picture picture = rendered(scene, {.size = size, .channels = all_channels});
  // The ray through the middle of a pixel of an orthographic camera.
  const Camera& camera = *scene.camera;
  const auto minus = [](const Vec3& a, const Vec3& b) { return Vec3{a.x - b.x, a.y - b.y, a.z - b.z}; };
  const auto cross = [](const Vec3& a, const Vec3& b) {
    return Vec3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const auto unit = [](const Vec3& v) { return Vec3{v.x / distance(v), v.y / distance(v), v.z / distance(v)}; };
  const Vec3 ahead = unit(minus(camera.target, camera.position)), right = unit(cross(ahead, camera.up)),
             up = cross(right, ahead);
  MadeRays rays;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      const double a = (x + 0.5 - 20) * 20 / 30, b = (15 - y - 0.5) * 20 / 30;
      rays.add({camera.position.x + a * right.x + b * up.x, camera.position.y + a * right.y + b * up.y,
                camera.position.z + a * right.z + b * up.z},
               ahead);
    }
  Answers found(rays.size());
  RayScratch scratch;
  RayCaster(scene.layers[0].data, Isosurface{0.1}, Accuracy::certified).first_hits(rays.rays(), found.hits(), scratch);
  std::size_t same = 0, shown = 0;
  for (std::size_t pixel = 0; pixel < rays.size(); ++pixel) {
    if (picture.cell()[pixel] == no_cell) continue;
    ++shown;
    same +=
        picture.cell()[pixel] == found.cell[pixel] && std::abs(picture.depth()[pixel] - found.t[pixel]) < 1e-4 ? 1 : 0;
  }
  EXPECT_GT(shown, 300U);
  EXPECT_GE(same + 2, shown) << "all but rays that pass within a rounding of an edge";
}

TEST(Gradients, of_a_rotated_and_stretched_grid_are_in_world_axes) {
  // f(i, j, k) = i + 2 j + 4 k; sample (i, j, k) is at (5 - 3 j, 2 i, k / 2).
  const Samples<float> samples = samples_of<float>(6, 6, 6, [](auto i, auto j, auto k) { return i + 2 * j + 4 * k; });
  const Affine map{.x_axis = {0, 2, 0}, .y_axis = {-3, 0, 0}, .z_axis = {0, 0, 0.5}, .origin = {5, 0, 0}};
  const Dataset grid = pack({.fields = {samples.field("f")}, .world_from_grid = map}, AxisOrder::zyx);
  const MadeRays rays = random_rays(grid.bounds(), 60);
  Answers found(60);
  RayScratch scratch;
  RayCaster(grid, Isosurface{17}, Accuracy::certified).first_hits(rays.rays(), found.hits(), scratch);
  std::size_t hits = 0;
  for (std::size_t ray = 0; ray < 60; ++ray) {
    if (std::isinf(found.t[ray])) continue;
    ++hits;
    EXPECT_NEAR(found.gradient[3 * ray], -2.0 / 3, 1e-6);
    EXPECT_NEAR(found.gradient[3 * ray + 1], 0.5, 1e-6);
    EXPECT_NEAR(found.gradient[3 * ray + 2], 8, 1e-6);
    const Vec3 p = rays.at(ray, found.t[ray]);
    EXPECT_NEAR(-2.0 / 3 * (p.x - 5) + p.y / 2 + 8 * p.z, 17, 1e-6);
  }
  EXPECT_GT(hits, 10U);
}

}  // namespace
}  // namespace rhoray::tests
