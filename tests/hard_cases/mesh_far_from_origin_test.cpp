// T18. Coordinates of ten million with cells of a hundredth. In single precision all points
// coincide; in double precision every difference has to be taken before it is used.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

TEST(MeshFarFromOrigin, is_hit_where_the_same_mesh_is_hit_at_the_origin) {
  // Powers of two, so that the far points are exactly the near points, translated.
  const Vec3 far(0x1p23, -0x1p24, 0x1p23);
  const double size = 0x1p-4;
  const auto field = [=](const Vec3& p) { return (p - Vec3(size / 2, size / 2, size / 2)).length() / size; };
  const auto near_mesh = box_mesh({.cells = {4, 4, 4}, .box = Box3({0, 0, 0}, {size, size, size})}, field);
  auto far_mesh = near_mesh;
  std::set<std::array<float, 3>> in_single_precision;
  for (auto& p : far_mesh.points) {
    p = to_array(to_vec3(p) + far);
    in_single_precision.insert({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  TracedDataset near(near_mesh), moved(far_mesh);
  Dice dice(1);
  int hits = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec3 direction = dice.direction();
    Vec3 origin = dice.point({0, 0, 0}, {size, size, size}) - 0.5 * direction;
    for (int axis = 0; axis < 3; ++axis) origin[axis] = std::ldexp(std::round(std::ldexp(origin[axis], 26)), -26);
    const render::Hit a = near.first_crossing({.origin = origin, .direction = direction}, 0.4);
    const render::Hit b = moved.first_crossing({.origin = origin + far, .direction = direction}, 0.4);
    ASSERT_EQ(a.is_miss(), b.is_miss());
    if (a.is_miss()) continue;
    EXPECT_NEAR(a.t, b.t, 1e-13);
    EXPECT_LT((a.gradient - b.gradient).length(), 1e-10 * a.gradient.length());
    ++hits;
  }
  EXPECT_GT(hits, 800);
  EXPECT_LT(in_single_precision.size(), far_mesh.points.size() / 10) << "is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests
