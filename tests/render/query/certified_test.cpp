#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;

constexpr Method certified{.algorithm = Method::Algorithm::certified};
constexpr Method judged{.algorithm = Method::Algorithm::exact};

/// Compares a certified result with the exact one: the same decision, and both positions within
/// their bounds.
void expect_agreement(const Hit& proven, const Hit& truth, const render::Ray& ray) {
  ASSERT_EQ(proven.is_miss(), truth.is_miss()) << ray.origin << " + t " << ray.direction;
  if (truth.is_miss()) return;
  ASSERT_GE(proven.error, 0);
  EXPECT_LE(std::abs(proven.t - truth.t), proven.error + truth.error) << ray.origin << " + t " << ray.direction;
}

/// Integers, so that isovalues equal the values of many samples.
double whole_number_noise(const Index3& at) {
  const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
  return static_cast<double>((hash >> 33) % 7);
}

struct Counts {
  int hits = 0, misses = 0;
  std::uint64_t redone = 0, judged = 0;
};

Counts compare(TracedDataset& traced, const std::vector<render::Ray>& rays, double iso) {
  Counts counts;
  for (const render::Ray& ray : rays) {
    traced.scratch.counters = {};
    const Hit proven = traced.first_crossing(ray, iso, certified);
    counts.redone += traced.scratch.counters.rays_redone;
    counts.judged += traced.scratch.counters.rays_exact;
    const Hit truth = traced.first_crossing(ray, iso, judged);
    expect_agreement(proven, truth, ray);
    ++(truth.is_miss() ? counts.misses : counts.hits);
    if (testing::Test::HasFatalFailure()) return counts;
  }
  return counts;
}

std::vector<render::Ray> ordinary_rays(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<render::Ray> rays;
  while (rays.size() < count) {
    const Vec3 direction = dice.direction();
    rays.push_back({.origin = dice.point({0, 0, 0}, size) - 2 * size.length() * direction, .direction = direction});
  }
  return rays;
}

TEST(CertifiedCrossings, agree_with_the_judge_on_rays_that_stress_the_walk_through_a_grid) {
  TracedDataset traced(
      volume_of<float>({12, 10, 11}, [](const Index3& at) { return static_cast<float>(whole_number_noise(at)); }));
  for (const double iso : {3.0, 2.5, 6.0}) {
    const Counts counts = compare(traced, stressful_rays({11, 9, 10}, 4000, 1), iso);
    EXPECT_GT(counts.hits, 300);
    EXPECT_GT(counts.judged, 30U) << "hardly a ray was in doubt: are these rays still hard?";
  }
}

TEST(CertifiedCrossings, agree_with_the_judge_where_samples_are_missing) {
  TracedDataset traced(volume_of<float>({12, 10, 11}, [](const Index3& at) {
    const double value = whole_number_noise(at);
    return (at.x * 7 + at.y * 5 + at.z * 3) % 11 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                                      : static_cast<float>(value);
  }));
  const Counts counts = compare(traced, stressful_rays({11, 9, 10}, 4000, 2), 2.5);
  EXPECT_GT(counts.hits, 500);
  EXPECT_GT(counts.misses, 100);
}

TEST(CertifiedCrossings, agree_with_the_judge_on_uneven_axes) {
  preprocess::NeutralVolume volume = volume_of<double>({10, 8, 9}, [](const Index3& at) {
    return std::sin(1.3 * static_cast<double>(at.x)) + std::cos(1.1 * static_cast<double>(at.y + at.z));
  });
  for (std::size_t a = 0; a < 3; ++a) {
    double position = 0;
    const std::int64_t count = volume.sample_count[static_cast<int>(a)];
    for (std::int64_t i = 0; i < count; ++i)
      volume.axes[a].push_back(position), position += 0.1 + 0.37 * static_cast<double>((i * 5) % 4);
  }
  TracedDataset traced(volume);
  const Vec3 size = traced.dataset().bounds().max;
  const Counts counts = compare(traced, ordinary_rays(size, 3000, 3), 0.2);
  EXPECT_GT(counts.hits, 1000);
}

TEST(CertifiedCrossings, are_rarely_in_doubt_on_ordinary_rays) {
  TracedDataset traced(sampled_volume<float>({33, 33, 33}, {}, [](const Vec3& p) {
    return (p - Vec3(16, 15, 17)).length() + 0.7 * std::sin(p.x) * std::sin(0.8 * p.y);
  }));
  const Counts counts = compare(traced, ordinary_rays({32, 32, 32}, 20000, 4), 9.3);
  EXPECT_GT(counts.hits, 5000);
  EXPECT_LT(counts.redone, 200U);  // one in a hundred; single precision has seven digits
  EXPECT_LE(counts.judged, 2U);    // doubles have sixteen
}

TEST(CertifiedCrossings, agree_with_the_judge_in_tetrahedra) {
  TracedDataset traced(box_mesh({.cells = {6, 5, 7}}, distance_field({0.5, 0.45, 0.55})));
  const Box3 box = traced.dataset().bounds();
  std::vector<render::Ray> rays = stressful_rays(box.max, 3000, 5);
  const Counts counts = compare(traced, rays, 0.31);
  EXPECT_GT(counts.hits, 300);
}

TEST(CertifiedCrossings, in_tetrahedra_are_rarely_in_doubt_on_ordinary_rays) {
  TracedDataset traced(box_mesh({.cells = {12, 11, 13}, .jitter = 0.15}, distance_field({0.5, 0.45, 0.55})));
  const Counts counts = compare(traced, ordinary_rays({1, 1, 1}, 5000, 6), 0.37);
  EXPECT_GT(counts.hits, 1000);
  EXPECT_LE(counts.judged, 5U);
}

/// Rays aimed at points and at the middles between two of them, from all sides.
std::vector<render::Ray> rays_aimed_at(const std::vector<Vec3>& points, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<render::Ray> rays;
  const auto any = [&] {
    return points[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(points.size())))];
  };
  while (rays.size() < count) {
    const Vec3 target = any(), direction = dice.direction();
    rays.push_back({.origin = target - dice.between(1, 30) * direction, .direction = direction});
  }
  return rays;
}

/// Rounding decides through which cells such a ray passes. That does not matter where the surface
/// is far away.
TEST(CertifiedCrossings, of_rays_through_lattice_points_are_judged_only_near_the_surface) {
  TracedDataset traced(sampled_volume<float>({17, 17, 17}, {}, [](const Vec3& p) {
    return (p - Vec3(8, 7, 9)).length() + 0.7 * std::sin(p.x) * std::sin(0.8 * p.y);
  }));
  std::vector<Vec3> points;
  for (int i = 0; i <= 32; ++i)
    for (int j = 0; j <= 16; ++j)
      for (int k = 0; k <= 16; ++k) points.push_back(Vec3(0.5 * i, j, k));
  const Counts counts = compare(traced, rays_aimed_at(points, 8000, 10), 5.3);
  EXPECT_GT(counts.hits, 2500);
  EXPECT_LE(counts.judged, 80U);  // the points near the surface
}

TEST(CertifiedCrossings, of_rays_through_vertices_and_edges_of_tetrahedra_are_judged_only_near_the_surface) {
  const preprocess::NeutralMesh mesh =
      box_mesh({.cells = {6, 5, 7}, .jitter = 0.15}, distance_field({0.5, 0.45, 0.55}));
  std::vector<Vec3> points;
  for (const auto& cell : mesh.cells)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        const auto &p = mesh.points[cell[a]], &q = mesh.points[cell[b]];
        points.push_back(0.5 * (Vec3(p[0], p[1], p[2]) + Vec3(q[0], q[1], q[2])));
      }
  TracedDataset traced(mesh);
  const Counts counts = compare(traced, rays_aimed_at(points, 8000, 11), 0.37);
  EXPECT_GT(counts.hits, 3000);
  EXPECT_LE(counts.judged, 20U);
}

/// Which arithmetic decided a hit, and how accurate its position is.
struct Placed {
  int by_float = 0, by_double = 0, by_judge = 0;

  void trace(TracedDataset& traced, const render::Ray& ray, double iso) {
    traced.scratch.counters = {};
    const Hit proven = traced.first_crossing(ray, iso, certified);
    const bool is_redone = traced.scratch.counters.rays_redone > 0, is_judged = traced.scratch.counters.rays_exact > 0;
    const Hit truth = traced.first_crossing(ray, iso, judged);
    expect_agreement(proven, truth, ray);
    if (truth.is_miss()) return;
    ++(is_judged ? by_judge : is_redone ? by_double : by_float);
    constexpr double rounding_of_t = 1e-14;
    EXPECT_LE(proven.error, (is_judged   ? 1e-12
                             : is_redone ? 1e-6
                                         : 1e-3) +
                                rounding_of_t)
        << ray.origin << ", isovalue " << iso;
  }
};

/// (x - 1/2) (y - 1/2) seen nearly along x = y, at values close to its smallest there: the surface
/// is grazed at every angle.
TEST(CertifiedCrossings, are_placed_to_a_thousandth_of_a_cell_by_float_and_1e12_by_the_judge_where_they_graze) {
  TracedDataset traced(volume_of<double>({2, 2, 2}, [](const Index3& at) { return at.x == at.y ? 0.25 : -0.25; }));
  Dice dice(12);
  Placed placed;
  for (int trial = 0; trial < 2000; ++trial) {
    const double aside = dice.between(0.01, 0.02), smallest = -0.25 * aside * aside;
    const Vec3 direction = Vec3(1, 1, dice.between(-0.1, 0.1)).normalized();
    placed.trace(traced, {.origin = Vec3(0.5, 0.5 + aside, 0.5) - 2.0 * direction, .direction = direction},
                 smallest + std::pow(10, dice.between(-16, -2)));
  }
  EXPECT_GT(placed.by_float, 300);
  EXPECT_GT(placed.by_judge, 100) << "double is sure of all: do these rays still graze the surface?";
}

/// For hits where float cannot tell on which side of the face they are.
TEST(CertifiedCrossings, are_placed_to_a_millionth_of_a_cell_by_double_where_they_lie_next_to_a_face) {
  TracedDataset traced(volume_of<double>({3, 2, 2}, [](const Index3& at) {
    return static_cast<double>(at.x) * (1 + 0.1 * static_cast<double>(at.y)) + 0.2 * static_cast<double>(at.z);
  }));
  Dice dice(13);
  Placed placed;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec3 direction = Vec3(1, dice.between(-0.1, 0.1), dice.between(-0.1, 0.1)).normalized();
    const Vec3 target(1 + (dice.coin() ? 1 : -1) * std::pow(10, dice.between(-15, -2)), 0.5, 0.5);
    placed.trace(traced, {.origin = target - 2.0 * direction, .direction = direction}, target.x * 1.05 + 0.1);
  }
  EXPECT_GT(placed.by_float, 300);
  EXPECT_GT(placed.by_double, 300);
}

TEST(CertifiedLargestValues, enclose_the_judges) {
  TracedDataset traced(volume_of<float>(
      {12, 10, 11}, [](const Index3& at) { return static_cast<float>(whole_number_noise(at) * 1.7); }));
  int values = 0;
  for (const render::Ray& ray : stressful_rays({11, 9, 10}, 3000, 8)) {
    const Hit proven = traced.largest_value(ray, certified), truth = traced.largest_value(ray, judged);
    ASSERT_EQ(proven.is_miss(), truth.is_miss()) << ray.origin << " + t " << ray.direction;
    if (truth.is_miss()) continue;
    EXPECT_LE(std::abs(proven.value - truth.value), proven.error + truth.error)
        << ray.origin << " + t " << ray.direction;
    if (ray.origin.length() < 1e4) {
      EXPECT_LT(proven.error, 1e-9);  // the position is known to 1e-12 cells
    }
    ++values;
  }
  EXPECT_GT(values, 1500);
}

TEST(SampledCrossings, come_close_with_smaller_steps_and_miss_what_lies_between_them) {
  // One layer of one cell, seen from the front.
  TracedDataset traced(volume_of<float>({20, 20, 20}, [](const Index3& at) { return at.x == 10 ? 1.0F : 0.0F; }));
  int missed_at_2 = 0, hits = 0;
  double worst_linear = 0, worst_bisect = 0;
  for (const render::Ray& ray : ordinary_rays({19, 19, 19}, 2000, 9)) {
    const Hit truth = traced.first_crossing(ray, 0.9);
    if (truth.is_miss()) continue;
    const auto sampled = [&](double step, bool bisect) {
      return traced.first_crossing(ray, 0.9,
                                   Method{.algorithm = Method::Algorithm::sampled, .step = step, .bisect = bisect});
    };
    ++hits;
    missed_at_2 += sampled(2, false).is_miss();
    const Hit linear = sampled(1.0 / 64, false), bisected = sampled(1.0 / 64, true);
    if (!linear.is_miss() && std::abs(ray.direction.x) > 0.2) {
      worst_linear = std::max(worst_linear, std::abs(linear.t - truth.t));
      worst_bisect = std::max(worst_bisect, std::abs(bisected.t - truth.t));
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(missed_at_2, hits / 4);
  EXPECT_LT(worst_linear, 1.0 / 64);         // between the two samples around the crossing
  EXPECT_LT(worst_bisect, 1.0 / 64 / 1024);  // ten bisections
}

}  // namespace
}  // namespace rhoray::tests
