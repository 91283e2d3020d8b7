#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "render/method.h"
#include "render/query/kernels.h"
#include "tests/render/support/crossings.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;
using render::StartSide;

constexpr Method float64 = render::method_of(render::Accuracy::float64);
constexpr Method single = render::method_of(render::Accuracy::float32);

/// A method and a machine with which secondary rays may be traced.
struct Road {
  Method method;
  Machine machine;
};
std::vector<Road> roads() {
  std::vector<Road> all{{float64, Machine::scalar}};
  for (const Machine machine : wide_machines()) all.push_back({single, machine});
  return all;
}

struct Shown {
  std::string name;
  std::unique_ptr<TracedDataset> traced;
  double length;   ///< of a cell, in the data's frame
  Vec3 low, high;  ///< bounds of the data, in the data's frame
};

/// Returns a field on [-1, 1]^3, as a grid and as a mesh, with cells of edge 2 / cells.
std::vector<Shown> both_kinds(const Field& field, std::int64_t cells) {
  std::vector<Shown> all;
  const Box3 box{{-1, -1, -1}, {1, 1, 1}};
  const Index3 samples(cells + 1, cells + 1, cells + 1);
  const double n = static_cast<double>(cells);
  all.push_back({"grid",
                 std::make_unique<TracedDataset>(sampled_volume<double>(samples, lattice_over(box, samples), field)),
                 1.0,
                 {0, 0, 0},
                 {n, n, n}});
  preprocess::NeutralMesh mesh = box_mesh({.cells = {cells, cells, cells}, .box = box});
  add_point_field(mesh, "value", field);
  all.push_back({"mesh", std::make_unique<TracedDataset>(mesh), 2 / n, {}, {}});
  const Box3 bounds = all.back().traced->dataset().implementation().bounds_data;
  all.back().low = bounds.min, all.back().high = bounds.max;
  return all;
}

/// Rays through the data from outside.
std::vector<Ray> rays_through(const Shown& shown, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  const Vec3 middle = 0.5 * (shown.low + shown.high), size = shown.high - shown.low;
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 through = dice.point(shown.low, shown.high), from = middle + 2 * size.length() * dice.direction();
    rays.push_back({.origin = from, .direction = (through - from).normalized()});
  }
  return rays;
}

/// Returns a ray that starts at a hit, on the side given by the gradient.
Ray ray_from(const Ray& ray, const Hit& hit, const Vec3& direction) {
  return {.origin = ray.at(hit.t),
          .direction = direction,
          .start_side = hit.gradient.dot(direction) > 0 ? StartSide::inside : StartSide::outside};
}

TEST(StartSide, keeps_a_plane_from_meeting_itself) {
  std::size_t asked = 0;
  for (const Vec3& slope : {Vec3(0, 0, 1), Vec3(0, -1, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(0.3, -0.7, 0.2)})
    for (const double isovalue : {0.0, 0.25, 0.1234567})  // on planes of cells and between them
      for (const double scale : {1.0, 1e-30, 1e20})
        for (Shown& shown : both_kinds(linear_field(scale * slope), 8))
          for (const Road& road : roads()) {
            const std::vector<Ray> rays = rays_through(shown, 300, 5);
            const std::vector<Hit> hits = answers(*shown.traced, road.method, road.machine, rays, scale * isovalue);
            std::vector<Ray> away;
            Dice dice(6);
            for (std::size_t r = 0; r < rays.size(); ++r)
              for (int i = 0; i < 4 && !hits[r].is_miss(); ++i)
                away.push_back(ray_from(rays[r], hits[r], dice.direction()));
            const std::vector<Hit> again = answers(*shown.traced, road.method, road.machine, away, scale * isovalue);
            for (std::size_t r = 0; r < away.size(); ++r)
              ASSERT_TRUE(again[r].is_miss())
                  << shown.name << " slope " << slope << " isovalue " << isovalue << " scale " << scale << " ray "
                  << away[r].origin << " " << away[r].direction;
            asked += away.size();
          }
  EXPECT_GT(asked, 100'000);
}

/// Alternates along z between -0.5 and 0.5 from one plane of points to the next.
double zigzag(double z) {
  return std::abs(std::remainder(z, 2.0)) - 0.5;  // -0.5 at even numbers, 0.5 at odd ones
}

TEST(StartSide, loses_no_sheet_of_many) {
  std::size_t asked = 0;
  constexpr std::int64_t cells = 12;
  // The last two: sheets close to each other.
  for (const double isovalue : {0.0, 0.3, -0.4999, 0.4999})
    for (Shown& shown : both_kinds([](const Vec3& p) { return zigzag((p.z + 1) * cells / 2); }, cells))
      for (const Road& road : roads()) {
        Dice dice(9);
        // The sheets are at distances a and 2 - a alternately, in cells.
        std::vector<Ray> rays;
        for (int i = 0; i < 500; ++i) {
          const Vec3 size = shown.high - shown.low;
          const Vec3 at = shown.low + dice.point({0.3 * size.x, 0.3 * size.y, -0.5 * size.z},
                                                 {0.7 * size.x, 0.7 * size.y, -0.1 * size.z});
          rays.push_back(
              {.origin = at, .direction = Vec3(dice.between(-0.2, 0.2), dice.between(-0.2, 0.2), 1).normalized()});
        }
        std::vector<int> met(rays.size(), 0);
        std::vector<Ray> going = rays;
        for (int step = 0; step <= cells; ++step) {
          const std::vector<Hit> hits = answers(*shown.traced, road.method, road.machine, going, isovalue);
          std::vector<Ray> next;
          for (std::size_t r = 0; r < going.size(); ++r) {
            if (hits[r].is_miss()) {
              next.push_back({.origin = {0, 0, 1e6}, .direction = {0, 0, 1}});
              continue;
            }
            ++met[r];
            next.push_back(ray_from(going[r], hits[r], going[r].direction));
          }
          going = next;
        }
        // One sheet in each layer of cells.
        for (std::size_t r = 0; r < rays.size(); ++r)
          ASSERT_EQ(met[r], cells) << shown.name << " isovalue " << isovalue << " ray " << r;
        asked += rays.size();
      }
  EXPECT_GE(asked, 4000);
}

TEST(StartSide, agrees_with_rays_that_start_beside_the_surface) {
  const auto ball = [](const Vec3& p) { return 0.7 - p.length(); };
  const auto saddle = [](const Vec3& p) { return p.x * p.x - p.y * p.y + 0.3 * p.z; };
  const auto waves = [](const Vec3& p) { return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z); };
  std::size_t asked = 0, skipped = 0, shadowed = 0;
  for (const Field& field : {Field(ball), Field(saddle), Field(waves)})
    for (Shown& shown : both_kinds(field, 16))
      for (const Road& road : roads()) {
        const double isovalue = 0.0123;
        const std::vector<Ray> rays = rays_through(shown, 2000, 11);
        const std::vector<Hit> hits = answers(*shown.traced, road.method, road.machine, rays, isovalue);
        Dice dice(12);
        std::vector<Ray> sided, beside;
        for (std::size_t r = 0; r < rays.size(); ++r) {
          if (hits[r].is_miss()) continue;
          const Ray ray = ray_from(rays[r], hits[r], dice.direction());
          const double steepness = std::abs(ray.direction.dot(hits[r].gradient)) / hits[r].gradient.length();
          // Start beside the surface, so that the side is certain despite rounding. Rays that are
          // nearly tangent to the surface are skipped.
          if (steepness < 0.05) {
            ++skipped;
            continue;
          }
          sided.push_back(ray);
          beside.push_back(ray);
          beside.back().t_min = 1e-3 * shown.length;
          beside.back().start_side = StartSide::unknown;
        }
        const std::vector<Hit> a = answers(*shown.traced, road.method, road.machine, sided, isovalue);
        const std::vector<Hit> b = answers(*shown.traced, float64, Machine::scalar, beside, isovalue);
        for (std::size_t r = 0; r < sided.size(); ++r) {
          ++asked;
          if (!a[r].is_miss() && a[r].t < 2e-3 * shown.length) {
            ++skipped;
            continue;
          }
          // Rounding decides whether a grazed surface is hit.
          const double t = a[r].is_miss() ? b[r].t : a[r].t;
          if (a[r].is_miss() != b[r].is_miss() || std::abs(a[r].t - b[r].t) > 1e-3 * shown.length) {
            const Vec3 g = (a[r].is_miss() ? b[r] : a[r]).gradient;
            ASSERT_LT(std::abs(g.dot(sided[r].direction)) / g.length(), 2e-3)
                << shown.name << " ray " << r << " t " << a[r].t << " " << b[r].t << " of " << t;
            ++skipped;
          }
          shadowed += !a[r].is_miss();
        }
      }
  EXPECT_GT(asked, 15'000);
  EXPECT_LT(static_cast<double>(skipped), 0.07 * static_cast<double>(asked));
  EXPECT_GT(shadowed, 1000);
}

/// Steep values, with many samples without data.
double with_gaps(const Index3& s) {
  const bool is_missing = (s.x * s.x + 3 * s.y + s.z) % 11 == 0 || (s.x > 12 && s.x < 25);
  return is_missing ? std::numeric_limits<double>::quiet_NaN()
                    : static_cast<double>((s.x * 7 + s.y * 5 + s.z * 3) % 32);
}

TEST(StartSide, beside_samples_without_data_is_heeded_on_every_machine_as_by_the_scalar_kernel) {
  TracedDataset traced(volume_of<float>({40, 33, 29}, with_gaps));
  const Shown shown{"gaps", nullptr, 1, {0, 0, 0}, {39, 32, 28}};
  const std::vector<Ray> rays = rays_through(shown, 4000, 3);
  const std::vector<Hit> hits = answers(traced, float64, Machine::scalar, rays, 16);
  std::vector<Ray> away;
  Dice dice(4);
  for (std::size_t r = 0; r < rays.size(); ++r)
    for (int i = 0; i < 8 && !hits[r].is_miss(); ++i) away.push_back(ray_from(rays[r], hits[r], dice.direction()));
  ASSERT_GT(away.size(), 20'000U);
  const std::vector<Hit> expected = answers(traced, float64, Machine::scalar, away, 16);
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> found = answers(traced, single, machine, away, 16);
    std::size_t differing = 0;
    for (std::size_t r = 0; r < away.size(); ++r)
      differing += found[r].is_miss() != expected[r].is_miss() ||
                   (!found[r].is_miss() && std::abs(found[r].t - expected[r].t) > 1e-3);
    // Rays that pass so close to an edge between cells that rounding takes them through other
    // cells.
    EXPECT_LE(differing, away.size() / 5000);
  }
}

TEST(StartSide, does_not_lift_a_field_that_is_on_that_side_already) {
  // Samples of a CT. Along the ray the field falls from 500 to 499.9985 at the border of its first
  // cell, which is nearer to the surface than a start may be. In the second cell it rises once
  // more, to 499.9991, before it finally falls. If it had been set back to 500 at that border, it
  // would have risen above.
  constexpr int samples[2][3][4] = {{{21, 0, 0, 0}, {487, 218, 46, 0}, {1003, 742, 392, 121}},
                                    {{547, 305, 129, 15}, {1012, 846, 576, 302}, {1136, 1100, 973, 778}}};
  TracedDataset traced(volume_of<std::uint16_t>({4, 3, 2}, [&](const Index3& s) { return samples[s.z][s.y][s.x]; }));
  const std::vector<Ray> rays(20, {.origin = {1.55266037629275, 1.01039396752617, 0.650460289458863},
                                   .direction = {0.50945904138751452, -0.76418856208127173, 0.69652603314699235},
                                   .start_side = StartSide::outside});
  for (const Road& road : roads())
    for (const Hit& hit : answers(traced, road.method, road.machine, rays, 500))
      EXPECT_TRUE(hit.is_miss()) << name_of(road.machine) << " at " << hit.t;
}

TEST(StartSide, is_forgotten_beyond_samples_without_data) {
  // Along z: rises to the isovalue at 2, no data at 3, below it again at 4, and through it at 4.5.
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN(), along[] = {-2, -1, 0, nothing, -1, 1, 2, 3};
  TracedDataset traced(volume_of<float>({8, 8, 8}, [&](const Index3& s) { return along[s.z]; }));
  std::vector<Ray> rays;
  for (int i = 0; i < 40; ++i)
    rays.push_back({.origin = {1.3 + 0.1 * i, 2.7, 2}, .direction = {0.01, 0.02, 1}, .start_side = StartSide::inside});
  for (const Road& road : roads())
    for (const Hit& hit : answers(traced, road.method, road.machine, rays, 0)) ASSERT_NEAR(hit.t, 2.5, 1e-6);
}

}  // namespace
}  // namespace rhoray::tests
