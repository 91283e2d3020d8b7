#include "preprocess/grid/resample/quick_bounds.h"

#include <gtest/gtest.h>

#include "tests/preprocess/grid/resample/support.h"

namespace rhoray::preprocess {
namespace {

/// The quick bounds of all leaf cells, and what is found in them by brute force.
class QuickAndFound {
 public:
  QuickAndFound(const Sampled& sampled, int order) : count_(sampled.lattice.count - Index3(1, 1, 1)) {
    const auto leaf_count = static_cast<std::size_t>(volume(count_));
    quick_.assign(leaf_count, 0);
    of_blocks_.assign(leaf_count, 0);
    found_.assign(leaf_count, 0);
    bound(sampled);
    sampled.for_each_difference(order, [&](const Index3& leaf, double difference) {
      double& found = found_[place(leaf)];
      found = std::max(found, difference);
    });
  }

  double quick(const Index3& leaf) const { return quick_[place(leaf)]; }
  double of_block(const Index3& leaf) const { return of_blocks_[place(leaf)]; }
  double found(const Index3& leaf) const { return found_[place(leaf)]; }

  template <class Act>
  void for_each_leaf(Act&& act) const {
    for (std::int64_t k = 0; k < count_.z; ++k)
      for (std::int64_t j = 0; j < count_.y; ++j)
        for (std::int64_t i = 0; i < count_.x; ++i) act(Index3(i, j, k));
  }

 private:
  std::size_t place(const Index3& leaf) const {
    return static_cast<std::size_t>((leaf.z * count_.y + leaf.y) * count_.x + leaf.x);
  }

  void bound(const Sampled& sampled) {
    std::vector<Point> steps;
    for (const auto& p : sampled.mesh.points) steps.push_back(sampled.lattice.in_steps(p));
    const FieldView view =
        view_of(sampled.mesh, sampled.fields[0], steps, sampled.lattice, sampled.samples.conflicts[0]);
    const FaceNeighbors neighbors = match_faces(sampled.mesh.points, sampled.mesh.cells);
    const std::vector<std::uint8_t> open = find_open_faces(sampled.mesh, neighbors, sampled.lattice);
    BrickFaces faces(sampled.mesh, steps);
    QuickBounds quick(sampled.mesh, steps, neighbors, open);
    for (std::size_t slot = 0; slot < sampled.touched.bricks.size(); ++slot) {
      const Index3 first = sampled.touched.at(slot) * std::int64_t{8};
      const Point in_steps{static_cast<double>(first.x), static_cast<double>(first.y), static_cast<double>(first.z)};
      const auto cells = sampled.touched.lists.view().list(sampled.touched.bricks[slot]);
      faces.enter(in_steps, cells);
      quick.enter(in_steps, cells);
      quick.bound_blocks(view);
      quick.bound_cells(~std::uint64_t{0}, faces);
      for (std::size_t block = 0; block < QuickBounds::block_count; ++block)
        for (std::size_t cell = 0; cell < 8; ++cell) {
          const auto at = QuickBounds::place(block, cell);
          const Index3 leaf = first + Index3(Imath::Vec3<std::size_t>(at[0], at[1], at[2]));
          if (leaf.x >= count_.x || leaf.y >= count_.y || leaf.z >= count_.z) continue;
          quick_[place(leaf)] = quick.of_cell(block, cell) * view.unit;
          of_blocks_[place(leaf)] = quick.of_block(block) * view.unit;
        }
    }
  }

  Index3 count_;
  std::vector<double> quick_, of_blocks_, found_;
};

TEST(QuickBounds, need_the_gradients_on_both_sides_of_a_fold) {
  // Falls by half from x = 3 to 3.5 and rises again to 4, between two samples that see neither;
  // flat elsewhere.
  const tests::Field notch = [](const Vec3& p) { return std::min(0.0, std::abs(p.x - 3.5) - 0.5); };
  const Sampled sampled(tests::box_mesh({.cells = {16, 4, 4}, .box = Box3({0, 0, 0}, {8, 8, 8})}, notch),
                        {.sample_count = {9, 9, 9}});
  const QuickAndFound bounds(sampled, 8);
  for (std::int64_t k = 0; k < 8; ++k)
    for (std::int64_t j = 0; j < 8; ++j) {
      EXPECT_NEAR(bounds.found({3, j, k}), 0.5, 1e-12);
      EXPECT_GE(bounds.quick({3, j, k}), 0.5);
      EXPECT_LE(bounds.quick({3, j, k}), 0.5001) << "a quarter of the range from -1 to 1, no more";
      EXPECT_LE(bounds.quick({6, j, k}), 1e-9);
    }
  // The slopes on one side of the flat part alone, or what the worst single face bends by less one
  // side, do not reach.
  const double one_side = 0.25 * (1 - 0);
  EXPECT_LT(one_side, bounds.found({3, 4, 4}));
}

/// Counts leaf cells whose bounds are infinite; all others must hold, and the mean of bound / found
/// not exceed a factor.
std::size_t count_infinite(const Sampled& sampled, int order, double factor) {
  const QuickAndFound bounds(sampled, order);
  std::size_t infinite = 0, compared = 0;
  double sum_of_ratios = 0;
  bounds.for_each_leaf([&](const Index3& leaf) {
    const double found = bounds.found(leaf), quick = bounds.quick(leaf);
    EXPECT_LE(found, quick + 1e-12) << leaf;
    EXPECT_LE(quick, bounds.of_block(leaf)) << leaf;
    infinite += std::isinf(quick);
    if (std::isinf(quick) || found < 1e-3) return;
    ++compared;
    sum_of_ratios += quick / found;
  });
  EXPECT_GT(compared, 200U);
  EXPECT_LE(sum_of_ratios, factor * static_cast<double>(compared));
  return infinite;
}

TEST(QuickBounds, hold_in_every_leaf_cell_for_faces_that_bend_both_ways) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const Sampled sampled(with_random_values(tests::box_mesh({.cells = {3, 3, 3}, .jitter = 0.15}), seed),
                          {.longest_axis = 14});
    EXPECT_EQ(count_infinite(sampled, 24, 5), 0U) << "the mesh ends in the lattice's sides only";
  }
}

TEST(QuickBounds, are_infinite_where_the_mesh_ends_inside_a_leaf_cell) {
  NeutralMesh mesh = with_random_values(tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}), 3);
  mesh.cells.erase(mesh.cells.begin() + 130);
  EXPECT_GT(count_infinite(Sampled(mesh, {.longest_axis = 15}), 24, 5), 10U);
}

TEST(QuickBounds, are_infinite_where_a_cell_has_no_data) {
  NeutralMesh mesh = with_random_values(tests::box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}), 4);
  mesh.point_fields[0].values[62] = std::nan("");
  EXPECT_GT(count_infinite(Sampled(mesh, {.longest_axis = 15}), 24, 5), 10U);
}

}  // namespace
}  // namespace rhoray::preprocess
