// All crossings of rays.
#include <gtest/gtest.h>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"

namespace rhoray::tests {
namespace {

TEST(AllHits, of_a_gyroid_rise_alternate_and_begin_with_the_first_hit) {
  const Dataset grid = gyroid_grid();
  const MadeRays rays = random_rays(grid.bounds(), 300);
  const RayCaster caster(grid, Isosurface{0.1}, Accuracy::exact);
  AllHits all;
  RayScratch scratch;
  caster.all_hits(rays.rays(), all, scratch);
  std::vector<double> t(300), error(300);
  std::vector<std::uint64_t> cell(300);
  caster.first_hits(rays.rays(), {.t = t, .error = error, .cell = cell}, scratch);
  ASSERT_EQ(all.first.size(), 301U);
  ASSERT_EQ(all.first.back(), all.t.size());
  ASSERT_EQ(all.truncated, std::vector<std::uint8_t>(300, 0));
  ASSERT_TRUE(all.error.size() == all.t.size() && all.cell.size() == all.t.size() && all.enters.size() == all.t.size());
  std::size_t most = 0;
  for (std::size_t ray = 0; ray < 300; ++ray) {
    const std::size_t first = all.first[ray], end = all.first[ray + 1];
    most = std::max(most, end - first);
    ASSERT_EQ(first == end, std::isinf(t[ray])) << ray;
    if (first == end) continue;
    EXPECT_EQ(all.t[first], t[ray]);
    EXPECT_EQ(all.error[first], error[ray]);
    EXPECT_EQ(all.cell[first], cell[ray]);
    for (std::size_t hit = first + 1; hit < end; ++hit) {
      EXPECT_GE(all.t[hit], all.t[hit - 1]);
      EXPECT_NE(all.enters[hit], all.enters[hit - 1]);
    }
  }
  EXPECT_GT(most, 4U);
  // The side before and behind each crossing is that of the field there.
  const FieldSampler sampler(grid);
  const double step = 1e-7;
  std::size_t compared = 0;
  for (std::size_t ray = 0; ray < 300; ++ray)
    for (std::size_t hit = all.first[ray]; hit < all.first[ray + 1]; ++hit) {
      std::vector<double> points, values(2);
      for (const double at : {all.t[hit] - step, all.t[hit] + step}) {
        const Vec3 p = rays.at(ray, at);
        points.insert(points.end(), {p.x, p.y, p.z});
      }
      sampler.at({std::span<const double>(points), {2, 3}}, values);
      if (!(std::abs(values[0] - values[1]) > 1e-9)) continue;  // along the surface, or at the border
      ++compared;
      EXPECT_EQ(all.enters[hit] == 1, values[1] > values[0]);
    }
  EXPECT_GT(compared, all.t.size() * 9 / 10);
}

TEST(AllHits, do_not_depend_on_method_context_or_threads) {
  const Dataset mesh = ball_mesh();
  const MadeRays rays = random_rays(mesh.bounds(), 1500);
  RayScratch scratch;
  AllHits expected, found;
  RayCaster(mesh, Isosurface{0.6}, Accuracy::float32, "radius").all_hits(rays.rays(), expected, scratch);
  EXPECT_GT(expected.t.size(), 500U);
  for (const unsigned threads : {1U, 2U, 8U}) {
    RenderContext context({.threads = threads});
    RayCaster(mesh, Isosurface{0.6}, Accuracy::certified, "radius").all_hits(rays.rays(), found, context);
    EXPECT_EQ(found.t, expected.t);
    EXPECT_EQ(found.first, expected.first);
    EXPECT_EQ(found.cell, expected.cell);
    EXPECT_EQ(found.enters, expected.enters);
    EXPECT_EQ(found.error, expected.error);
  }
}

/// Values 0, 1, 0, 1, ... along x: a ray along x crosses 0.5 in the middle of each cell.
TEST(AllHits, are_as_many_as_the_field_has_and_say_where_they_end) {
  const Samples<std::uint8_t> samples = samples_of<std::uint8_t>(21, 3, 3, [](auto i, auto, auto) { return i % 2; });
  const Dataset grid = pack({.fields = {samples.field("stripes")}}, AxisOrder::zyx);
  const RayCaster caster(grid, Isosurface{0.5}, Accuracy::exact);
  MadeRays rays;
  rays.add({-1, 0.6, 1.4}, {1, 0, 0});
  rays.add({10, 0.6, 1.4}, {-2, 0, 0});
  rays.add({10, 5, 1.4}, {-2, 0, 0});
  RayScratch scratch;
  AllHits all;
  caster.all_hits(rays.rays(), all, scratch);
  EXPECT_EQ(all.first, (std::vector<std::uint64_t>{0, 20, 30, 30}));
  for (std::size_t hit = 0; hit < 20; ++hit) {
    EXPECT_EQ(all.t[hit], 1.5 + static_cast<double>(hit));
    EXPECT_EQ(all.enters[hit], hit % 2 == 0 ? 1 : 0);
    EXPECT_EQ(all.cell[hit] % 20, hit);
  }
  EXPECT_EQ(all.t[20], 0.25);
  const std::vector<double> all_t = all.t;
  caster.all_hits(rays.rays(), all, scratch, 7);
  EXPECT_EQ(all.first, (std::vector<std::uint64_t>{0, 7, 14, 14}));
  EXPECT_EQ(all.truncated, (std::vector<std::uint8_t>{1, 1, 0}));
  EXPECT_TRUE(std::equal(all.t.begin(), all.t.begin() + 7, all_t.begin()));
  caster.all_hits(rays.rays(), all, scratch, 20);
  EXPECT_EQ(all.truncated, (std::vector<std::uint8_t>{0, 0, 0}));
  EXPECT_EQ(all.t, all_t);
  caster.all_hits(rays.rays(), all, scratch, std::numeric_limits<std::size_t>::max());
  EXPECT_EQ(all.t, all_t);
}

TEST(AllHits, of_triangles_are_not_there) {
  MadeRays rays;
  rays.add({5, 0, 0}, {-1, 0, 0});
  AllHits all;
  RayScratch scratch;
  const RayCaster caster(octahedron(), Triangles{}, Accuracy::float32);
  expect_refused(ErrorCode::unsupported, "triangles have no list of all hits",
                 [&] { caster.all_hits(rays.rays(), all, scratch); });
}

}  // namespace
}  // namespace rhoray::tests
