// T13-T17, R05, R12, R13, R19, R20, D13. Values and isovalue are whole numbers: vertices, edges,
// faces, cells and layers lie in the surface. For tests by the product of signs, zero is then a
// third state. Here zero is inside, and a crossing is a change of one bit.
#include <gtest/gtest.h>

#include "tests/hard_cases/mesh_crossings.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"

namespace rhoray::tests {
namespace {

TEST(ValuesEqualToIsovalue, in_a_mesh_change_the_side_in_pairs) {
  // 0 on the box, 0, 1 or 2 inside: the surface at 1 is closed.
  const BoxMesh shape{.cells = {5, 5, 5}, .box = Box3({0, 0, 0}, {5, 5, 5})};
  Dice values(1);
  auto mesh = box_mesh(shape, [&](const Vec3& p) {
    const bool on_box = p.x == 0 || p.y == 0 || p.z == 0 || p.x == 5 || p.y == 5 || p.z == 5;
    return on_box ? 0.0 : static_cast<double>(values.below(3));
  });
  TracedDataset traced(mesh);
  Dice dice(2);
  int odd = 0, hits = 0, wrong = 0, wrong_by_product = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Vec3 target = dice.point({0.5, 0.5, 0.5}, {4.5, 4.5, 4.5}), direction = dice.direction();
    if (dice.coin()) target = {std::round(target.x), std::round(target.y), std::round(target.z)};
    if (dice.below(4) == 0) direction = {1, static_cast<double>(dice.below(3) - 1), 0};
    const render::Ray ray{.origin = target - 20.0 * direction, .direction = direction};
    const MeshCrossings found = crossings(mesh, 1, ray);
    odd += found.ours.size() % 2 != 0;
    hits += !found.ours.empty();
    const render::Hit hit = traced.first_crossing(ray, 1);
    wrong += hit.is_miss() != found.ours.empty();

    const render::RayShear shear(ray);
    int by_product = 0;
    for (auto cell : mesh.cells) {
      std::sort(cell.begin(), cell.end());
      render::SeenTet tet;
      for (std::size_t i = 0; i < 4; ++i) {
        tet.vertex[i] = shear.see(mesh.points[cell[i]]);
        tet.value[i] = mesh.point_fields[0].values[cell[i]];
      }
      if (const auto passage = pass_through(tet, 1)) by_product += passage->in.value * passage->out.value < 0;
    }
    wrong_by_product += (by_product > 0) != !found.ours.empty();
  }
  EXPECT_EQ(odd, 0);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(hits, 1500);
  EXPECT_GT(wrong_by_product, 20) << "signs by product no longer fail here: is this case still the hard one?";
}

TEST(ValuesEqualToIsovalue, in_a_whole_face_or_cell_give_one_hit_where_the_ray_gets_in) {
  // Layers of a mesh at x = 0..6: 0 0 1 1 1 0 0.
  const auto mesh = box_mesh({.cells = {6, 2, 2}, .box = Box3({0, 0, 0}, {6, 2, 2})},
                             [](const Vec3& p) { return p.x >= 2 && p.x <= 4 ? 1.0 : 0.0; });
  TracedDataset traced(mesh);
  Dice dice(3);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 target = dice.point({3, 0.6, 0.6}, {3, 1.4, 1.4});
    const Vec3 direction(1, dice.between(-0.1, 0.1), dice.between(-0.1, 0.1));
    const render::Ray ray{.origin = target - 5.0 * direction, .direction = direction};
    EXPECT_NEAR(traced.first_crossing(ray, 1).t, 4, 1e-12) << "at x = 2";
    EXPECT_EQ(crossings(mesh, 1, ray).ours.size(), 2U) << "in at x = 2, out at x = 4";
  }
}

TEST(ValuesEqualToIsovalue, in_a_plateau_of_a_grid_give_one_hit_where_the_ray_gets_in) {
  TracedDataset traced(
      volume_of<std::uint8_t>({7, 5, 5}, [](const Index3& at) { return at.x >= 2 && at.x <= 4 ? 1 : 0; }));
  Dice dice(4);
  int lost_by_product = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 target = dice.point({3, 1.6, 1.6}, {3, 2.4, 2.4});
    const Vec3 direction(1, dice.between(-0.1, 0.1), dice.between(-0.1, 0.1));
    const render::Ray ray{.origin = target - 5.0 * direction, .direction = direction};
    const render::Hit hit = traced.first_crossing(ray, 1);
    EXPECT_NEAR(hit.t, 4, 1e-12);
    EXPECT_NEAR(traced.first_crossing({.origin = target, .direction = direction}, 1).t, 1, 1e-12) << "out at x = 4";
    EXPECT_NEAR(traced.first_crossing({.origin = target, .direction = -direction}, 1).t, 1, 1e-12) << "out at x = 2";
    lost_by_product += !((0.0 - 1.0) * (1.0 - 1.0) < 0);
  }
  EXPECT_EQ(lost_by_product, 500);
}

TEST(ValuesEqualToIsovalue, in_noise_of_whole_numbers_hit_exactly_when_a_value_reaches_it) {
  const Index3 cells(6, 6, 6);
  const Samples samples = [](const Index3& at) {
    if (at.x == 0 || at.y == 0 || at.z == 0 || at.x == 6 || at.y == 6 || at.z == 6) return 0.0;
    const auto hash = static_cast<std::uint64_t>((at.z * 31 + at.y) * 37 + at.x) * 0x9e3779b97f4a7c15U;
    return static_cast<double>((hash >> 40) % 3);
  };
  TracedDataset traced(
      volume_of<std::uint8_t>({7, 7, 7}, [&](const Index3& at) { return static_cast<std::uint8_t>(samples(at)); }));
  Dice dice(5);
  int hits = 0, misses = 0, too_close = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Vec3 target = dice.point({0.2, 0.2, 0.2}, {5.8, 5.8, 5.8}), direction = dice.direction();
    if (dice.coin()) target = {std::round(target.x), std::round(target.y), std::round(target.z)};
    const render::Ray ray{.origin = target - 20.0 * direction, .direction = direction};
    const auto largest = largest_by_brute_force(samples, cells, ray);
    if (!largest || std::abs(*largest - 1) < 1e-9) {
      ++too_close;
      continue;
    }
    const render::Hit hit = traced.first_crossing(ray, 1);
    EXPECT_EQ(!hit.is_miss(), *largest > 1);
    (hit.is_miss() ? misses : hits)++;
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 50);
  EXPECT_LT(too_close, 1000);
}

}  // namespace
}  // namespace rhoray::tests
