#include "render/frame/clip_region.h"

#include <gtest/gtest.h>

#include <random>

#include "render/query/batch.h"
#include "tests/render/frame/clipped_pictures.h"
#include "tests/render/support/wide_machines.h"

namespace rhoray::tests {
namespace {

using namespace clipped;
using render::Ray;

TEST(ClipRegion, finds_the_same_parts_of_rays_on_every_machine) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-2, 2);
  constexpr std::size_t count = 4 * render::RayBatch::group_size;
  render::RayBatch rays(count);
  rays.count = count;
  for (std::size_t r = 0; r < count; ++r) {
    Ray ray{.origin = {number(random), number(random), number(random)},
            .direction = Vec3(number(random), number(random), number(random)).normalized()};
    if (r % 5 == 0) ray.direction = {0, 0, 1};  // along faces
    if (r % 10 == 0) ray.origin = {0.6, 0, -2};
    rays.set(r, ray);
  }
  for (const Clip& clip : regions()) {
    render::KeptParts plain(count);
    render::ClipRegion(clip, render::Machine::scalar).find_kept(rays, plain);
    for (const render::Machine machine : wide_machines()) {
      render::KeptParts wide(count);
      render::ClipRegion(clip, machine).find_kept(rays, wide);
      for (std::size_t r = 0; r < count; ++r) {
        ASSERT_EQ(plain.t_min[r], wide.t_min[r]);
        ASSERT_EQ(plain.t_max[r], wide.t_max[r]);
        ASSERT_EQ(plain.again[r], wide.again[r]);
      }
    }
    std::size_t kept = 0, gone = 0;
    for (std::size_t r = 0; r < count; ++r)
      for (double t = 0; t < 6; t += 0.07) {
        const std::optional<bool> expected = is_kept(clip, rays[r].at(t), 1e-9);
        const bool found = (t >= plain.t_min[r] && t <= plain.t_max[r]) || t >= plain.again[r];
        if (!expected) continue;
        ASSERT_EQ(found, *expected) << r << ' ' << t;
        (found ? kept : gone) += 1;
      }
    EXPECT_GT(kept, 20);
    EXPECT_GT(gone, 20);
  }
}

TEST(ClipRegion, knows_what_it_leaves_of_boxes) {
  EXPECT_EQ(what_is_left(Clip{}, cube), cube);
  EXPECT_EQ(what_is_left(Clip{.box = Box3({0, -2, -2}, {2, 2, 0.5})}, cube), Box3({0, -1, -1}, {1, 1, 0.5}));
  EXPECT_TRUE(what_is_left(Clip{.box = Box3({2, -2, -2}, {3, 2, 0.5})}, cube).isEmpty());
  EXPECT_TRUE(what_is_left(Clip{.planes = {{{0, 0, 1.1}, {0, 0, 1}}}}, cube).isEmpty());
  EXPECT_TRUE(what_is_left(Clip{.box = Box3({-2, -2, -2}, {2, 2, 2}), .cuts_away = true}, cube).isEmpty());
  // A corner of the cube, x + y + z >= 2: a tetrahedron.
  const Box3 corner = what_is_left(Clip{.planes = {{{1, 1, 0}, {2, 2, 2}}}}, cube);
  EXPECT_NEAR((corner.min - Vec3(0, 0, 0)).length(), 0, 1e-9);
  EXPECT_EQ(corner.max, Vec3(1, 1, 1));
  // The intersection of planes that meet inside the cube has a corner of its own.
  const Box3 inner = what_is_left(
      Clip{.planes = {{{0.25, 0, 0}, {-1, 1, 0}}, {{0.25, 0, 0}, {-1, -1, 0}}, {{0, 0, 0.5}, {0, 0, -1}}}}, cube);
  EXPECT_NEAR(inner.max.x, 0.25, 1e-9);
  EXPECT_NEAR(inner.max.z, 0.5, 1e-9);
  EXPECT_TRUE(leaves_whole(Clip{.box = cube}, cube));
  EXPECT_FALSE(leaves_whole(Clip{.box = Box3({-1, -1, -1}, {1, 1, 0.999})}, cube));
  EXPECT_TRUE(leaves_whole(Clip{.box = Box3({1.1, 0, 0}, {2, 1, 1}), .cuts_away = true}, cube));
  EXPECT_FALSE(leaves_whole(Clip{.box = Box3({0.9, 0, 0}, {2, 1, 1}), .cuts_away = true}, cube));
}

}  // namespace
}  // namespace rhoray::tests
