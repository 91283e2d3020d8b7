// Many rays at once at closed surfaces of every size and position: random rays, and rays aimed at
// edges and vertices. tools/lab traces such rays by the hundred million, this test by the ten
// thousand.
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "tools/lab/ray_tally.h"

namespace rhoray::tests {
namespace {

using study::RayTally;

RayTally tally_of(study::SceneKind kind, const study::Placement& placement, std::uint64_t rays_of_each_aim) {
  const TemporaryFolder folder;
  const study::ClosedScene scene = closed_scene(kind, placement, 12, folder.path());
  RayTally whole;
  for (const study::Aim aim : study::aims) {
    const std::uint64_t seed = 1 + static_cast<std::uint64_t>(kind) * 16 + static_cast<std::uint64_t>(aim);
    whole.add(tally_rays(scene, aim, rays_of_each_aim, seed, 50));
  }
  return whole;
}

std::uint64_t wrong(const RayTally::OfMethod& method) {
  return method.missed + method.extra + method.elsewhere;
}

constexpr std::uint64_t rays_of_each_aim = 800;

TEST(ManyRays, are_all_answered_rightly_by_the_certified_method) {
  const study::Placement placements[] = {{Vec3(0), 1},
                                         {Vec3(1e3), 1e-6},
                                         {Vec3(1e5), 1e6},
                                         {Vec3(148376, 1234, -223423), 1},
                                         {Vec3(148376, 1234, -223423), 1e-6}};
  RayTally whole;
  for (const study::SceneKind kind : study::scene_kinds)
    for (const study::Placement& placement : placements) whole.add(tally_of(kind, placement, rays_of_each_aim));

  for (const std::string& complaint : whole.complaints) ADD_FAILURE() << complaint;
  EXPECT_EQ(wrong(whole.certified), 0U);
  EXPECT_EQ(whole.bound_broken, 0U);
  EXPECT_EQ(whole.miscounted, 0U);
  EXPECT_EQ(whole.rays, 4 * 5 * 3 * rays_of_each_aim);
  EXPECT_GT(whole.hits, whole.rays / 4);
  EXPECT_LT(whole.hits, whole.rays - 1000);
  EXPECT_GT(whole.redecided, whole.rays / 100);
  EXPECT_GT(whole.judged, 500U) << "few rays in doubt: are these still hard?";
  EXPECT_GT(wrong(whole.float64), 100U) << "double precision is right too: are these rays still hard?";
}

TEST(ManyRays, are_counted_the_same_twice) {
  const RayTally once = tally_of(study::SceneKind::grid, {}, 300), twice = tally_of(study::SceneKind::grid, {}, 300);
  EXPECT_EQ(once.hits, twice.hits);
  EXPECT_EQ(once.redone, twice.redone);
  EXPECT_EQ(once.redecided, twice.redecided);
}

}  // namespace
}  // namespace rhoray::tests
