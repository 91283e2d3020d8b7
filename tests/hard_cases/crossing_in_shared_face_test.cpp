// T15. The isosurface lies in the face that two tetrahedra share. Each computes the crossing for
// itself, and rounding may put it just outside of both: the ray slips between them. With the
// paper's strict test (Appendix B: no barycentric coordinate is negative), one in five of these
// rays is lost in double precision.
#include <gtest/gtest.h>

#include "tests/hard_cases/mesh_crossings.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

TEST(CrossingInSharedFace, is_never_lost) {
  Dice dice(1999);
  constexpr int rays = 10000;
  int missed = 0, twice = 0, missed_strict = 0;
  double largest_error = 0;
  for (int trial = 0; trial < rays; ++trial) {
    preprocess::NeutralMesh mesh;
    for (int corner = 0; corner < 3; ++corner) mesh.points.push_back(to_array(dice.point({-1, -1, -1}, {1, 1, 1})));
    const Vec3 a = to_vec3(mesh.points[0]), b = to_vec3(mesh.points[1]), c = to_vec3(mesh.points[2]);
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.length() < 0.05) continue;
    mesh.points.push_back(to_array((a + b + c) / 3.0 + dice.between(0.2, 1) * normal.normalized()));
    mesh.points.push_back(to_array((a + b + c) / 3.0 - dice.between(0.2, 1) * normal.normalized()));
    mesh.cells = {{0, 1, 2, 3}, {0, 1, 2, 4}};
    // Inside above the face and in it, outside below: one change of side, at the face.
    const double iso = dice.between(-10, 10);
    mesh.point_fields.emplace_back();
    mesh.point_fields[0].values = {iso, iso, iso, iso + dice.between(0.1, 5), iso - dice.between(0.1, 5)};

    double wa = dice.between(0.01, 1), wb = dice.between(0.01, 1), wc = dice.between(0.01, 1);
    const Vec3 target = (wa * a + wb * b + wc * c) / (wa + wb + wc);
    const Vec3 direction = (0.3 * dice.direction() + (dice.coin() ? 1.0 : -1.0) * normal.normalized()).normalized();
    const render::Ray ray{.origin = target - 5.0 * direction, .direction = direction};
    const MeshCrossings found = crossings(mesh, iso, ray);
    missed += found.ours.empty();
    twice += found.ours.size() > 1;
    missed_strict += found.strict.empty();
    if (!found.ours.empty()) largest_error = std::max(largest_error, std::abs(found.ours[0] - 5));
  }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(twice, 0);
  EXPECT_LT(largest_error, 1e-12);
  EXPECT_GT(missed_strict, rays / 10) << "the strict test no longer fails here: is this case still the hard one?";
  RecordProperty("missed_strict", missed_strict);
}

}  // namespace
}  // namespace rhoray::tests
