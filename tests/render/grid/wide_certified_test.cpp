#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

#include "render/grid/reference/resumed.h"
#include "render/method.h"
#include "render/query/kernels.h"
#include "tests/render/support/crossings.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"

/// Certified crossings of wide kernels: rays for which rounding leaves open which cells they pass,
/// and those that are continued where they are in doubt.
namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;

constexpr Method certified = render::method_of(render::Accuracy::certified),
                 judged = render::method_of(render::Accuracy::exact);

const Index3 samples(53, 46, 61);
const Vec3 size(52, 45, 60);

/// Hills and hollows around 10, and a little noise.
preprocess::NeutralVolume hills() {
  Dice dice(1);
  return volume_of<float>(samples, [&](const Index3& i) {
    const double x = static_cast<double>(i.x), y = static_cast<double>(i.y), z = static_cast<double>(i.z);
    return static_cast<float>(10 + std::sin(0.4 * x) + std::sin(0.5 * y) * std::cos(0.3 * z) +
                              dice.between(-0.05, 0.05));
  });
}

/// Squares of 8 x 8 rays from one point to points of the lattice, or to points on its edges. There
/// they graze cells, and some of them graze blocks.
std::vector<Ray> squares_of_rays_to_edges(std::size_t count, std::uint64_t seed) {
  constexpr double steps[] = {1, 1, 2, 4};
  Dice dice(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const int across = static_cast<int>(dice.below(3)), u = (across + 1) % 3, v = (across + 2) % 3;
    const double step = steps[dice.below(4)], depth = std::floor(dice.between(8, 30));
    const bool to_points = dice.coin();
    const Vec3 eye = 0.5 * size + dice.between(1, 3) * size.length() * dice.direction();
    const double u_first = std::floor(dice.between(0, size[u] - 7 * step)),
                 v_first = std::floor(dice.between(0, size[v] - 7 * step));
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 8; ++i) {
        Vec3 target(0);
        target[across] = to_points ? depth : depth + dice.between(-0.5, 0.5);
        target[u] = u_first + step * i, target[v] = v_first + step * j;
        // With a direction that is not rounded once more: target - eye would be.
        rays.push_back({.origin = eye, .direction = (target - eye).normalized()});
      }
  }
  return rays;
}

/// Each square of 64 becomes 64 rays that are far apart.
std::vector<Ray> mixed(const std::vector<Ray>& squares) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < 64; ++i)
    for (std::size_t square = 0; square < squares.size(); square += 64) rays.push_back(squares[square + i]);
  return rays;
}

TEST(WideCertified, answers_rays_that_pass_edges_and_corners_far_from_the_surface_by_itself) {
  TracedDataset traced(hills());
  const std::vector<Ray> squares = squares_of_rays_to_edges(6400, 2), apart = mixed(squares);
  const std::vector<Hit> truth = answers(traced, judged, Machine::scalar, squares, 10.3);
  for (const Machine machine : wide_machines()) {
    traced.scratch.counters = {};
    const std::vector<Hit> together = answers(traced, certified, machine, squares, 10.3);
    const std::uint64_t redone = traced.scratch.counters.rays_redone;
    const std::vector<Hit> alone = answers(traced, certified, machine, apart, 10.3);
    EXPECT_EQ(traced.scratch.counters.rays_redone, 2 * redone) << name_of(machine);
    EXPECT_LT(redone, squares.size() / 20) << name_of(machine);
    std::size_t hits = 0, place = 0;
    for (std::size_t i = 0; i < 64; ++i)
      for (std::size_t square = 0; square < squares.size(); square += 64, ++place) {
        const Hit &hit = together[square + i], &exact = truth[square + i];
        ASSERT_TRUE(same_bits(hit, alone[place])) << name_of(machine) << ", ray " << square + i;
        ASSERT_EQ(hit.cost, alone[place].cost) << name_of(machine) << ", ray " << square + i;
        ASSERT_EQ(hit.is_miss(), exact.is_miss()) << name_of(machine) << ", ray " << square + i;
        if (hit.is_miss()) continue;
        ++hits;
        ASSERT_LE(std::abs(hit.t - exact.t), hit.error + exact.error) << name_of(machine) << ", ray " << square + i;
      }
    EXPECT_GT(hits, squares.size() / 2);
  }
}

TEST(WideCertified, of_rays_that_begin_or_end_beside_the_surface_are_the_judges) {
  TracedDataset traced(hills());
  const std::vector<Ray> rays = squares_of_rays_to_edges(1280, 4);
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> whole = answers(traced, certified, machine, rays, 10.3);
    std::vector<Ray> cut;  // cut as near to the surface as the position of the hit is known
    for (std::size_t r = 0; r < rays.size(); ++r) {
      if (whole[r].is_miss()) continue;
      for (const double errors : {-1.5, -0.5, 0.5, 1.5}) {
        const double end = whole[r].t + errors * whole[r].error;
        cut.push_back(rays[r]), cut.back().t_max = end;
        cut.push_back(rays[r]), cut.back().t_min = end;
      }
    }
    const std::vector<Hit> truth = answers(traced, judged, Machine::scalar, cut, 10.3),
                           found = answers(traced, certified, machine, cut, 10.3);
    std::size_t met_before_the_end = 0, not_met = 0;
    for (std::size_t r = 0; r < cut.size(); ++r) {
      ASSERT_EQ(found[r].is_miss(), truth[r].is_miss()) << name_of(machine) << ", ray " << r;
      not_met += found[r].is_miss();
      if (found[r].is_miss()) continue;
      ASSERT_LE(std::abs(found[r].t - truth[r].t), found[r].error + truth[r].error)
          << name_of(machine) << ", ray " << r;
      met_before_the_end += r % 2 == 0;
    }
    EXPECT_GT(met_before_the_end, 1000U) << name_of(machine);
    EXPECT_GT(not_met, 1000U) << name_of(machine);
  }
}

/// Returns the times at which a ray passes planes between blocks, before `until`.
std::vector<double> times_of_planes(const Ray& ray, double until) {
  std::vector<double> times;
  const render::PlaneTimes planes(ray);
  for (int a = 0; a < 3; ++a)
    for (std::int64_t k = 0; k < samples[a]; k += 4)
      if (planes.step(a) != 0 && planes.at(a, k) > ray.t_min && planes.at(a, k) < until)
        times.push_back(planes.at(a, k));
  return times;
}

TEST(WideCertified, of_a_ray_taken_up_at_a_plane_before_its_hit_is_that_of_the_whole_ray) {
  TracedDataset traced(hills());
  const auto& view = std::get<render::UniformGrid>(traced.dataset().implementation().view);
  const render::RayQuery query{.isovalue = 10.3, .method = certified};
  Dice dice(3);
  render::RayBatch rays(64);
  render::HitBatch hits(64);
  int asked = 0;
  std::uint64_t visits = 0, visits_of_whole = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Vec3 direction = dice.direction();
    const Ray ray{.origin = dice.point({0, 0, 0}, size) - 80.0 * direction, .direction = direction};
    rays.count = 1;
    rays.set(0, ray);
    const auto resumed = [&](const render::ResumedAt& from) {
      const std::uint64_t before = traced.scratch.counters.visits();
      resume_certified(view, query, rays, std::span(&from, 1), hits, traced.scratch);
      EXPECT_EQ(hits[0].cost, traced.scratch.counters.visits() - before);
      return hits[0];
    };
    const Hit whole = resumed({});
    const double until = whole.is_miss() ? 200 : whole.t - whole.error;
    const std::vector<double> times = times_of_planes(ray, until);
    if (times.empty()) continue;
    const double t = times[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(times.size())))];
    render::ResumedAt from{.t = t};
    if (!whole.is_miss() && dice.coin())
      from.side = whole.gradient.dot(direction) > 0 ? render::StartSide::outside : render::StartSide::inside;
    const Hit from_plane = resumed(from);
    ASSERT_TRUE(same_bits(from_plane, whole)) << "ray " << trial;
    visits += from_plane.cost, visits_of_whole += whole.cost;
    ++asked;
  }
  EXPECT_GT(asked, 500);
  EXPECT_LT(visits, visits_of_whole - visits_of_whole / 8);
}

}  // namespace
}  // namespace rhoray::tests
