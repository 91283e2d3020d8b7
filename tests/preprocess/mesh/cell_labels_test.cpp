#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "preprocess/labels.h"
#include "preprocess/pack_mesh.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::TemporaryFolder;
using tests::to_vec3;

/// The cube from 0 to 8 with one value in each cell, by the cell's middle.
std::optional<std::vector<CellLabel>> labels_of(const std::function<double(const Vec3&)>& value,
                                                bool single_precision = true) {
  NeutralMesh mesh = tests::box_mesh({.cells = {8, 8, 8}, .box = {{0, 0, 0}, {8, 8, 8}}});
  NeutralField field{.name = "part", .unit = {}, .was_single_precision = single_precision, .values = {}};
  for (const auto& cell : mesh.cells) {
    Vec3 middle(0, 0, 0);
    for (const std::uint64_t v : cell) middle += 0.25 * to_vec3(mesh.points[v]);
    field.values.push_back(value(middle));
  }
  mesh.cell_fields.push_back(field);
  tests::add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  const TemporaryFolder folder;
  pack_mesh(mesh, folder / "m.rho");
  return find_labels(formats::TetMesh(formats::PackedFile::open(folder / "m.rho")), 0);
}

/// Pairs of labels and what they hide.
std::vector<std::pair<int, unsigned>> pairs_of(const std::optional<std::vector<CellLabel>>& labels) {
  std::vector<std::pair<int, unsigned>> pairs;
  for (const CellLabel& label : labels.value()) pairs.emplace_back(label.value, label.hidden_count);
  return pairs;
}

/// The distance from the cube's middle, of the farthest coordinate.
double farthest(const Vec3& p) {
  return std::max({std::abs(p.x - 4), std::abs(p.y - 4), std::abs(p.z - 4)});
}

TEST(CellLabels, are_the_values_in_order_with_zero) {
  using testing::ElementsAre;
  using testing::Pair;
  const auto stacked = [](const Vec3& p) { return p.x < 2 ? 7 : p.x < 4 ? -3 : 0; };
  EXPECT_THAT(pairs_of(labels_of(stacked)), ElementsAre(Pair(-3, 0), Pair(0, 0), Pair(7, 0)));
  EXPECT_THAT(pairs_of(labels_of(stacked, false)), ElementsAre(Pair(-3, 0), Pair(0, 0), Pair(7, 0)));
}

TEST(CellLabels, hide_those_inside_them) {
  using testing::ElementsAre;
  using testing::Pair;
  EXPECT_THAT(pairs_of(labels_of([](const Vec3& p) { return farthest(p) > 3   ? 5
                                                            : farthest(p) > 2 ? 1
                                                                              : 9; })),
              ElementsAre(Pair(1, 1), Pair(5, 2), Pair(9, 0)))
      << "one inside the other";
  EXPECT_THAT(pairs_of(labels_of([](const Vec3& p) { return farthest(p) < 1 ? 3
                                                            : p.x < 7       ? 1
                                                                            : 2; })),
              ElementsAre(Pair(1, 1), Pair(2, 0), Pair(3, 0)))
      << "2 does not touch what is inside 1";
}

TEST(CellLabels, are_not_found_in_other_fields) {
  EXPECT_FALSE(labels_of([](const Vec3& p) { return p.x < 4 ? 1 : 1.5; })) << "a fraction";
  EXPECT_FALSE(labels_of([](const Vec3&) { return 4; })) << "one value";
  EXPECT_FALSE(labels_of([](const Vec3& p) { return p.x < 4 ? 1 : std::nan(""); })) << "cells without data";
  EXPECT_FALSE(labels_of([](const Vec3& p) { return p.x < 4 ? 1 : 1e10; })) << "a value beyond int";
  const auto many = [](int count) {
    return labels_of([=](const Vec3& p) { return static_cast<int>(std::floor(p.x) + 8 * std::floor(p.y)) % count; });
  };
  EXPECT_EQ(many(32).value().size(), 32U);
  EXPECT_FALSE(many(33));
}

}  // namespace
}  // namespace rhoray::preprocess
