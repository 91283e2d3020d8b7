// D07, D08, M06. NaN and infinite samples. Every comparison with NaN is false, so NaN counts as
// outside, and the data next to it seem to have a surface there (a skin). A cell with such a corner
// is absent.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(CellsWithoutData, have_no_skin_and_hide_nothing) {
  // Inside everywhere except in a ball around (8, 8, 8), with holes without data scattered
  // throughout.
  const Index3 count(17, 17, 17), cells(16, 16, 16);
  for (const float hole : {nan, std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()}) {
    const auto is_hole = [](const Index3& at) {
      const auto hash = static_cast<std::uint64_t>((at.z * 101 + at.y) * 103 + at.x) * 0x9e3779b97f4a7c15U;
      return (hash >> 40) % 150 == 0;
    };
    const auto field = distance_field({8, 8, 8});
    TracedDataset traced(volume_of<float>(count,
                                          [&](const Index3& at) {
                                            const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y),
                                                         static_cast<double>(at.z));
                                            return is_hole(at) ? hole : static_cast<float>(field(p));
                                          }),
                         {.macro_factor = 2});
    EXPECT_GT(traced.dataset().field().no_data_count, 5U);
    const auto touches_hole = [&](const Vec3& p) {
      const Index3 cell = cell_of(p, cells);
      for (int c = 0; c < 8; ++c)
        if (is_hole({cell.x + (c & 1), cell.y + (c >> 1 & 1), cell.z + (c >> 2 & 1)})) return true;
      return false;
    };
    Dice dice(1);
    int hits = 0, hidden = 0, naive_skins = 0;
    for (int trial = 0; trial < 1500; ++trial) {
      const Vec3 direction = dice.direction();
      const render::Ray ray{.origin = dice.point({6, 6, 6}, {10, 10, 10}) - 40.0 * direction, .direction = direction};
      const render::Hit hit = traced.first_crossing(ray, 4);
      EXPECT_TRUE(same_bits(hit, traced.first_crossing(ray, 4, false)));
      // A reported surface is that of the ball: the field there is the isovalue up to the sampling
      // error of the ball.
      if (!hit.is_miss()) {
        EXPECT_NEAR(field(ray.at(hit.t)), 4, 0.2);
        EXPECT_FALSE(touches_hole(ray.at(hit.t - 1e-9)) && touches_hole(ray.at(hit.t + 1e-9)));
      }
      (hit.is_miss() ? hidden : hits)++;
      // The naive method compares with NaN: it takes the first sample along the ray that is not >=
      // 4.
      const auto part = part_in_box(ray, {0, 0, 0}, {16, 16, 16});
      double naive = (*part)[0];
      while (naive < (*part)[1] && !touches_hole(ray.at(naive)) && field(ray.at(naive)) >= 4) naive += 0.05;
      naive_skins += naive < (*part)[1] && field(ray.at(naive)) > 4.5;
    }
    EXPECT_GT(hits, 1000);
    EXPECT_LT(hidden, 400);
    EXPECT_GT(naive_skins, 100) << "no ray meets a hole: is this case still the hard one?";
  }
}

// Bricks and macrocells that hold only NaN, beside others: their ranges are empty. A range
// corrupted by NaN hides what lies behind it.
TEST(CellsWithoutData, may_fill_whole_bricks) {
  const auto is_empty_brick = [](const Index3& at) { return (at.x / 4 + at.y / 4 + at.z / 4) % 3 == 0; };
  const auto samples = volume_of<float>({21, 18, 19}, [&](const Index3& at) {
    const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
    return is_empty_brick(at) ? nan : static_cast<float>(std::sin(p.x) + std::cos(0.7 * p.y) + std::sin(1.3 * p.z));
  });
  TracedDataset whole(samples, {.macro_factor = 2});
  TracedDataset sparse(samples, {.order = preprocess::SampleOrder::sparse, .brick_edge = 4, .macro_factor = 2});
  EXPECT_GT(whole.dataset().field().no_data_count, 1'000U);
  EXPECT_EQ(sparse.dataset().field().no_data_count, whole.dataset().field().no_data_count);
  int hits = 0, behind = 0;
  for (const render::Ray& ray : stressful_rays({20, 17, 18}, 1'000, 1)) {
    const render::Hit judged = whole.first_crossing(ray, 0.5, {.algorithm = render::Method::Algorithm::exact});
    const render::Hit direct = whole.first_crossing(ray, 0.5);
    EXPECT_TRUE(same_bits(direct, sparse.first_crossing(ray, 0.5)));
    const render::Hit certified = sparse.first_crossing(ray, 0.5, {.algorithm = render::Method::Algorithm::certified});
    ASSERT_EQ(certified.is_miss(), judged.is_miss());
    if (judged.is_miss()) continue;
    EXPECT_LE(std::abs(certified.t - judged.t), certified.error + judged.error);
    ++hits;
    for (double t = std::max(0.0, judged.t - 6 / ray.direction.length()); t < judged.t;
         t += 0.3 / ray.direction.length()) {
      const Vec3 p = ray.at(t);
      const bool is_in = p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= 20 && p.y <= 17 && p.z <= 18;
      if (!is_in || !is_empty_brick(cell_of(p, {20, 17, 18}))) continue;
      ++behind;
      break;
    }
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(behind, 50) << "no hit lies behind an empty brick: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests
