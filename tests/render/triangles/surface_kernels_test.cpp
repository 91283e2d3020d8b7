#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/pack_surface.h"
#include "render/dataset/loaded_dataset.h"
#include "render/load.h"
#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/surfaces.h"
#include "tests/support/temporary_folder.h"

/// First hits of rays with the triangles of surfaces: by the scalar kernel in double precision, and
/// by the wide ones.
namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Ray;
using render::StartSide;

constexpr double infinity = std::numeric_limits<double>::infinity();

class Traced {
 public:
  explicit Traced(const preprocess::NeutralSurface& surface)
      : report_(preprocess::pack_surface(surface, folder_ / "a.rho")),
        volume_(render::Dataset::load(folder_ / "a.rho")) {}

  const render::Dataset& dataset() const { return volume_; }
  const preprocess::PackSurfaceReport& report() const { return report_; }

  std::vector<Hit> first(const std::vector<Ray>& rays, Machine machine, bool use_hierarchy = true) {
    const render::Method method =
        render::method_of(machine == Machine::scalar ? render::Accuracy::float64 : render::Accuracy::float32);
    const render::Intersectors kernels =
        render::choose_intersectors(volume_.implementation(), {.method = method}, machine);
    std::vector<Hit> hits(rays.size());
    ask(kernels.first_hit, volume_.implementation(), {.method = method, .use_hierarchy = use_hierarchy}, rays, hits,
        scratch);
    return hits;
  }
  Hit first(const Ray& ray, Machine machine) { return first(std::vector<Ray>{ray}, machine)[0]; }

  /// Returns all crossings of a ray, each traced behind the last.
  std::vector<Hit> all(Ray ray, Machine machine) {
    std::vector<Hit> hits;
    while (hits.size() < 1000) {
      const Hit hit = first(ray, machine);
      if (hit.is_miss()) break;
      hits.push_back(hit);
      ray.t_min = hit.t;
      ray.start_side = hit.gradient.dot(ray.direction) > 0 ? StartSide::inside : StartSide::outside;
    }
    return hits;
  }

  render::KernelScratch scratch;

 private:
  TemporaryFolder folder_;
  preprocess::PackSurfaceReport report_;
  render::Dataset volume_;
};

std::vector<Machine> all_machines() {
  std::vector<Machine> machines = wide_machines();
  machines.insert(machines.begin(), Machine::scalar);
  return machines;
}

double bumps(const Vec3& d) {
  return 1 + 0.3 * std::sin(5 * d.x + 1) * std::cos(4 * d.y) + 0.15 * std::sin(9 * d.z);
}

/// A closed surface and the distance of its points from a point inside.
struct Closed {
  std::string name;
  preprocess::NeutralSurface surface;
  Vec3 middle;
  double size;
};

/// A cube with one edge that has an additional point on one side only: a triangle without area is
/// between.
preprocess::NeutralSurface cube_with_flat_triangle() {
  preprocess::NeutralSurface surface = cube_surface();
  const std::uint64_t added = surface.points.size();
  // On the edge from point 0 to point 1, which belongs to triangle 0, 3, 1.
  surface.points.push_back({0.3, 0, 0});
  std::vector<std::vector<std::uint64_t>> facets;
  for (std::size_t f = 0; f + 1 < surface.facet_offsets.size(); ++f) {
    const auto* corner = surface.facet_corners.data() + surface.facet_offsets[f];
    if (corner[0] == 0 && corner[1] == 3 && corner[2] == 1) {
      facets.push_back({0, 3, added});
      facets.push_back({added, 3, 1});
      facets.push_back({0, added, 1});
    } else {
      facets.push_back({corner[0], corner[1], corner[2]});
    }
  }
  std::vector<Vec3> points;
  for (const auto& p : surface.points) points.push_back(to_vec3(p));
  return surface_of(points, facets);
}

std::vector<Closed> closed_surfaces() {
  return {{"cube", cube_surface(), Vec3(0.5), 1},
          {"squares", cube_surface(false), Vec3(0.5), 1},
          {"ball", round_surface(4), Vec3(0), 1},
          {"bumps", round_surface(4, bumps), Vec3(0), 1},
          {"far away", moved(round_surface(3, bumps), Vec3(1e6, -3e6, 2e6)), Vec3(1e6, -3e6, 2e6), 1},
          {"tiny", moved(round_surface(3, bumps), Vec3(0), 1e-9), Vec3(0), 1e-9},
          {"large", moved(round_surface(3, bumps), Vec3(0), 4e8), Vec3(0), 4e8},
          {"flat triangle", cube_with_flat_triangle(), Vec3(0.5), 1}};
}

std::vector<Ray> rays_at(const Closed& closed, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  for (std::size_t r = 0; r < count; ++r) {
    const Vec3 origin = closed.middle + 4 * closed.size * dice.direction();
    const Vec3 target = closed.middle + closed.size * dice.point(Vec3(-1), Vec3(1));
    rays.push_back({.origin = origin, .direction = (target - origin).normalized()});
  }
  return rays;
}

TEST(SurfaceKernels, meet_a_cube_where_its_planes_are) {
  Traced cube(cube_surface());
  std::vector<Ray> rays = rays_at({"cube", {}, Vec3(0.5), 1}, 3000, 1);
  for (const Machine machine : all_machines()) {
    const std::vector<Hit> hits = cube.first(rays, machine);
    std::size_t hit_count = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
      double t_in = -infinity, t_out = infinity;
      int axis_in = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = -rays[r].origin[axis] / rays[r].direction[axis];
        const double b = (1 - rays[r].origin[axis]) / rays[r].direction[axis];
        if (std::min(a, b) > t_in) t_in = std::min(a, b), axis_in = axis;
        t_out = std::min(t_out, std::max(a, b));
      }
      // So near to an edge that single precision may be wrong.
      if (std::abs(t_in - t_out) < 1e-5) continue;
      ASSERT_EQ(hits[r].is_miss(), t_in > t_out) << name_of(machine) << " ray " << r;
      if (hits[r].is_miss()) continue;
      ++hit_count;
      ASSERT_NEAR(hits[r].t, t_in, 1e-13 * 5) << name_of(machine) << " ray " << r;
      Vec3 normal(0, 0, 0);
      normal[axis_in] = rays[r].direction[axis_in] > 0 ? -1 : 1;
      EXPECT_EQ(hits[r].gradient, normal);
      EXPECT_TRUE(std::isnan(hits[r].value));
      EXPECT_TRUE(std::isnan(hits[r].error));
    }
    EXPECT_GT(hit_count, 800U);
  }
}

TEST(SurfaceKernels, agree_wherever_a_ray_nearby_does) {
  for (const Closed& closed : closed_surfaces()) {
    Traced traced(closed.surface);
    const std::vector<Ray> rays = rays_at(closed, 2000, 7);
    const std::vector<Hit> exact = traced.first(rays, Machine::scalar);
    for (const Machine machine : wide_machines()) {
      const std::vector<Hit> found = traced.first(rays, machine);
      std::size_t others = 0;
      for (std::size_t r = 0; r < rays.size(); ++r) {
        const auto agree = [&](const Hit& a, const Hit& b, double share) {
          return a.t == b.t || std::abs(a.t - b.t) <= share * closed.size;
        };
        // Positions are those of the planes in double precision; for distant origins, to their
        // rounding.
        if (agree(found[r], exact[r], 1e-8)) continue;
        ++others;
        bool is_explained = false;
        Dice dice(r);
        for (int i = 0; i < 200 && !is_explained; ++i) {
          Ray nearby = rays[r];
          nearby.origin += 3e-6 * closed.size * dice.direction();
          is_explained = agree(found[r], traced.first(nearby, Machine::scalar), 1e-4);
        }
        EXPECT_TRUE(is_explained) << closed.name << ", " << name_of(machine) << ", ray " << r << ": " << found[r].t
                                  << " and " << exact[r].t;
      }
      EXPECT_LE(others, 6U) << closed.name;
    }
  }
}

TEST(SurfaceKernels, pass_through_closed_surfaces_an_even_number_of_times) {
  for (const Closed& closed : closed_surfaces()) {
    Traced traced(closed.surface);
    for (const Machine machine : all_machines()) {
      std::size_t crossed = 0;
      for (const Ray& ray : rays_at(closed, 400, 5)) {
        const std::size_t count = traced.all(ray, machine).size();
        EXPECT_EQ(count % 2, 0U) << closed.name << ", " << name_of(machine);
        crossed += count > 0 ? 1 : 0;
      }
      EXPECT_GT(crossed, 100U);
    }
  }
}

/// Rays from inside through positions where triangles meet, and others beside them by less than any
/// number can resolve.
std::vector<Ray> rays_from_inside(const Closed& closed) {
  const preprocess::NeutralSurface& s = closed.surface;
  std::vector<Ray> rays;
  const auto point = [&](std::uint64_t p) { return to_vec3(s.points[p]); };
  const auto aim = [&](const Vec3& target) {
    for (const Vec3& shift : {Vec3(0), Vec3(0.1, 0.02, -0.05)}) {
      const Vec3 origin = closed.middle + closed.size * shift;
      rays.push_back({.origin = origin, .direction = target - origin});
    }
  };
  for (std::size_t f = 0; f + 1 < s.facet_offsets.size() && f < 300; ++f) {
    const std::uint64_t first = s.facet_offsets[f], end = s.facet_offsets[f + 1];
    for (std::uint64_t c = first; c < end; ++c) {
      const Vec3 a = point(s.facet_corners[c]), b = point(s.facet_corners[c + 1 < end ? c + 1 : first]);
      aim(a);
      aim(0.5 * (a + b));
      aim(a + 0.3 * (b - a));
    }
  }
  return rays;
}

TEST(SurfaceKernels, leave_no_hole_at_shared_edges_and_corners) {
  for (const Closed& closed : closed_surfaces()) {
    Traced traced(closed.surface);
    const std::vector<Ray> rays = rays_from_inside(closed);
    for (const Machine machine : all_machines()) {
      const std::vector<Hit> hits = traced.first(rays, machine);
      std::size_t missed = 0;
      for (const Hit& hit : hits) missed += hit.is_miss() ? 1 : 0;
      EXPECT_EQ(missed, 0U) << closed.name << ", " << name_of(machine) << " of " << rays.size();
    }
  }
}

TEST(SurfaceKernels, leave_no_hole_for_rays_along_axes_in_faces_edges_and_diagonals) {
  Traced cube(cube_surface());
  for (const Machine machine : all_machines())
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0})
        for (const double u : {0.0, 0.25, 0.5, 0.75})
          for (const double v : {0.25, 0.5}) {
            Vec3 direction(0, 0, 0), origin;
            direction[axis] = sign;
            origin[axis] = 0.5, origin[(axis + 1) % 3] = u == 0 ? 0.5 : u, origin[(axis + 2) % 3] = v;
            const Hit hit = cube.first({.origin = origin, .direction = direction}, machine);
            EXPECT_EQ(hit.t, 0.5) << name_of(machine);
          }
}

/// Triangles at random positions with random orientations.
preprocess::NeutralSurface strewn_triangles(std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Vec3> points;
  std::vector<std::vector<std::uint64_t>> facets;
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3 middle = dice.point(Vec3(-1), Vec3(1));
    for (int c = 0; c < 3; ++c) points.push_back(middle + 0.4 * dice.direction());
    facets.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return surface_of(points, facets);
}

/// By Cramer's rule in long double, one triangle after the other.
std::vector<std::uint64_t> ids_on(const preprocess::NeutralSurface& surface, const Ray& ray, bool& is_close) {
  std::vector<std::pair<long double, std::uint64_t>> met;
  using Wide = Imath::Vec3<long double>;
  const auto wide = [](const Vec3& v) { return Wide(v.x, v.y, v.z); };
  for (std::uint64_t f = 0; f + 1 < surface.facet_offsets.size(); ++f) {
    const auto corner = [&](std::size_t c) {
      return wide(to_vec3(surface.points[surface.facet_corners[surface.facet_offsets[f] + c]]));
    };
    const Wide e1 = corner(1) - corner(0), e2 = corner(2) - corner(0), s = wide(ray.origin) - corner(0);
    const Wide d = wide(ray.direction), p = d.cross(e2), q = s.cross(e1);
    const long double det = e1.dot(p), u = s.dot(p) / det, v = d.dot(q) / det;
    const long double inside = std::min({u, v, 1 - u - v});
    if (std::abs(inside) < 1e-4L) is_close = true;
    if (inside > 0) met.emplace_back(e2.dot(q) / det, f);
  }
  std::sort(met.begin(), met.end());
  std::vector<std::uint64_t> ids;
  for (std::size_t i = 0; i < met.size(); ++i) {
    if (i > 0 && met[i].first - met[i - 1].first < 1e-4L) is_close = true;
    if (met[i].first > 0) ids.push_back(met[i].second);
  }
  return ids;
}

TEST(SurfaceKernels, meet_every_triangle_on_the_way_whatever_way_it_faces) {
  const preprocess::NeutralSurface surface = strewn_triangles(300, 3);
  Traced traced(surface);
  Dice dice(11);
  std::size_t compared = 0, skipped = 0, crossings = 0;
  for (int r = 0; r < 300; ++r) {
    const Vec3 origin = dice.point(Vec3(-2), Vec3(2)), target = dice.point(Vec3(-1), Vec3(1));
    const Ray ray{.origin = origin, .direction = (target - origin).normalized()};
    bool is_close = false;
    const std::vector<std::uint64_t> expected = ids_on(surface, ray, is_close);
    if (is_close) {
      ++skipped;
      continue;
    }
    ++compared;
    crossings += expected.size();
    for (const Machine machine : all_machines()) {
      std::vector<std::uint64_t> found;
      for (const Hit& hit : traced.all(ray, machine)) found.push_back(hit.cell);
      EXPECT_EQ(found, expected) << name_of(machine) << ", ray " << r;
    }
  }
  EXPECT_GT(compared, 200U) << skipped;
  EXPECT_GT(crossings, 1000U);
}

TEST(SurfaceKernels, do_not_meet_the_triangle_that_a_ray_starts_on) {
  const Closed closed{"bumps", round_surface(4, bumps), Vec3(0), 1};
  Traced traced(closed.surface);
  Dice dice(4);
  for (const Machine machine : all_machines()) {
    std::size_t started = 0, met_again = 0, met_unknown = 0;
    for (const Ray& ray : rays_at(closed, 1500, 9)) {
      const Hit hit = traced.first(ray, machine);
      if (hit.is_miss()) continue;
      // On the side from which the ray comes, nearly parallel to the triangle or steep.
      const Vec3 normal = hit.gradient.normalized();
      Vec3 direction = dice.direction();
      direction -= normal * direction.dot(normal);
      direction = direction.normalized() + dice.one_of(std::array{1e-3, 0.1, 3.0}) * normal;
      Ray away{.origin = ray.at(hit.t), .direction = direction.normalized(), .start_side = StartSide::inside};
      const Hit next = traced.first(away, machine);
      ++started;
      met_again += !next.is_miss() && next.t < 1e-5 && next.tet == hit.tet ? 1 : 0;
      away.start_side = StartSide::unknown;
      const Hit unknown = traced.first(away, machine);
      met_unknown += !unknown.is_miss() && unknown.t < 1e-5 ? 1 : 0;
    }
    EXPECT_GT(started, 500U);
    EXPECT_EQ(met_again, 0U) << name_of(machine);
    EXPECT_GT(met_unknown, 50U) << "rays no longer start in the triangle: is this case still the hard one?";
  }
}

TEST(SurfaceKernels, say_the_same_with_and_without_the_tree) {
  for (const Closed& closed : closed_surfaces()) {
    Traced traced(closed.surface);
    std::vector<Ray> rays = rays_at(closed, 200, 3);
    for (std::size_t r = 0; r < rays.size(); r += 3) rays[r].t_max = 4.1 * closed.size;
    const std::vector<Hit> with = traced.first(rays, Machine::scalar);
    const std::uint64_t solved = traced.scratch.counters.cells_solved;
    const std::vector<Hit> without = traced.first(rays, Machine::scalar, false);
    for (std::size_t r = 0; r < rays.size(); ++r) {
      EXPECT_EQ(with[r].t, without[r].t) << closed.name;
      EXPECT_EQ(with[r].cell, without[r].cell);
      EXPECT_EQ(with[r].gradient, without[r].gradient);
    }
    if (closed.name == "ball") {
      EXPECT_LT(solved, 200 * 2048 / 20);
    }
  }
}

TEST(SurfaceKernels, end_where_the_ray_ends) {
  Traced cube(cube_surface());
  for (const Machine machine : all_machines()) {
    Ray ray{.origin = {0.4, 0.3, -1}, .direction = {0, 0, 1}};
    EXPECT_EQ(cube.first(ray, machine).t, 1);
    ray.t_max = 0.9;
    EXPECT_TRUE(cube.first(ray, machine).is_miss());
    ray.t_min = 1.5, ray.t_max = infinity;
    EXPECT_EQ(cube.first(ray, machine).t, 2);
    ray.t_min = 2.5;
    EXPECT_TRUE(cube.first(ray, machine).is_miss());
  }
}

TEST(SurfaceKernels, answer_rays_that_are_none_by_a_miss) {
  Traced cube(cube_surface());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Machine machine : all_machines())
    for (const Ray& ray : {Ray{{0.5, 0.5, 0.5}, {0, 0, 0}}, Ray{{nan, 0.5, 0.5}, {1, 0, 0}},
                           Ray{{0.5, 0.5, 0.5}, {nan, 0, 0}}, Ray{{0.5, 0.5, 0.5}, {1, 0, 0}, 3, 2}})
      EXPECT_TRUE(cube.first(ray, machine).is_miss()) << name_of(machine);
}

TEST(SurfaceKernels, name_the_facet_of_the_source) {
  Traced cube(cube_surface(false));
  EXPECT_EQ(cube.report().description.triangle_count, 12U);
  for (const Machine machine : all_machines()) {
    EXPECT_EQ(cube.first({{0.4, 0.3, -1}, {0, 0, 1}}, machine).cell, 0U);
    EXPECT_EQ(cube.first({{0.4, 0.3, 2}, {0, 0, -1}}, machine).cell, 1U);
    EXPECT_EQ(cube.first({{2, 0.3, 0.6}, {-1, 0, 0}}, machine).cell, 5U);
  }
}

}  // namespace
}  // namespace rhoray::tests
