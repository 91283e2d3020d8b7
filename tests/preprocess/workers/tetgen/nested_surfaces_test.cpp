#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>

#include "formats/base/error.h"
#include "preprocess/inspect_surface.h"
#include "preprocess/tetrahedralize.h"
#include "tests/preprocess/workers/tetgen/surfaces.h"

namespace rhoray::tests {
namespace {

using preprocess::FacetFault;
using preprocess::tetrahedralize;
using testing::AllOf;
using testing::HasSubstr;

std::map<double, double> volume_by_region(const NeutralMesh& mesh) {
  std::map<double, double> volumes;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    volumes[mesh.cell_fields.at(0).values.at(cell)] += cell_volume(mesh, cell);
  return volumes;
}

/// The middle one of the ratios of edge length to what is wanted in the edge's middle.
double median_ratio(const NeutralMesh& mesh, double (*wanted)(const Point&)) {
  std::vector<double> ratios;
  for (const auto& cell : mesh.cells)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const Point &a = mesh.points[cell[i]], &b = mesh.points[cell[j]];
        const Point edge = minus(a, b);
        ratios.push_back(std::hypot(edge[0], edge[1], edge[2]) /
                         wanted({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}));
      }
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  return ratios[ratios.size() / 2];
}

/// Three boxes in one another and one beside them, the innermost given first.
NeutralSurface nested_boxes() {
  const std::array<NeutralSurface, 4> boxes{box({2, 2, 2}, {3, 3, 3}), box({1, 1, 1}, {4, 4, 4}),
                                            box({0, 0, 0}, {5, 5, 5}), box({6, 0, 0}, {7, 1, 2})};
  return preprocess::join(boxes);
}

TEST(NestedSurfaces, become_regions_that_are_numbered_from_outside_in) {
  const auto volumes = volume_by_region(tetrahedralize(nested_boxes()));
  ASSERT_EQ(volumes.size(), 4u);
  EXPECT_NEAR(volumes.at(1), 125 - 27, 1e-9);  // of the two outermost, the one whose points come first
  EXPECT_NEAR(volumes.at(2), 2, 1e-9);
  EXPECT_NEAR(volumes.at(3), 27 - 1, 1e-9);
  EXPECT_NEAR(volumes.at(4), 1, 1e-9);
}

TEST(NestedSurfaces, take_a_limit_of_volume_for_one_region) {
  const NeutralMesh mesh = tetrahedralize(nested_boxes(), {.region_volumes = {{.region = 4, .max_volume = 0.01}}});
  std::map<double, double> largest;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    double& most = largest[mesh.cell_fields.at(0).values[cell]];
    most = std::max(most, cell_volume(mesh, cell));
  }
  EXPECT_LE(largest.at(4), 0.01);
  EXPECT_GT(largest.at(1), 0.05);
  try {
    tetrahedralize(nested_boxes(), {.region_volumes = {{.region = 9, .max_volume = 1}}});
    ADD_FAILURE() << "region 9 was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no region 9"), HasSubstr("1 2 3 4")));
  }
}

TEST(NestedSurfaces, leave_every_second_one_empty_when_asked_to) {
  const auto volumes = volume_by_region(tetrahedralize(nested_boxes(), {.empty_cavities = true}));
  ASSERT_EQ(volumes.size(), 3u);
  EXPECT_NEAR(volumes.at(1), 125 - 27, 1e-9);
  EXPECT_NEAR(volumes.at(2), 2, 1e-9);
  EXPECT_NEAR(volumes.at(3), 1, 1e-9);
}

TEST(SizeFields, by_distance_are_followed) {
  preprocess::SizeByDistance sizes{.surface = box({-1, 0, 0}, {0, 1, 1}), .near = 0.08, .far = 0.5, .growth = 0.2};
  const NeutralMesh mesh = tetrahedralize(
      box({0, 0, 0}, {2, 1, 1}), {.size_field = std::make_shared<const preprocess::SizeField>(std::move(sizes))});
  const double ratio = median_ratio(mesh, [](const Point& p) { return 0.08 + 0.2 * p[0]; });
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

// The triangles of a fan filled the corner that the facets leave free.
TEST(SizeFields, by_distance_to_facets_that_are_not_convex_are_followed) {
  preprocess::SizeByDistance sizes{.surface = prism(l_outline(2)), .near = 0.02, .far = 0.5, .growth = 0.1};
  const NeutralMesh mesh =
      tetrahedralize(box({1.3, 1.3, 0}, {1.6, 1.6, 0.3}),
                     {.size_field = std::make_shared<const preprocess::SizeField>(std::move(sizes))});
  const double ratio = median_ratio(mesh, [](const Point& p) { return 0.02 + 0.1 * std::min(p[0] - 1, p[1] - 1); });
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

TEST(SizeFields, by_distance_to_a_face_with_an_opening_are_followed) {
  preprocess::SizeByDistance sizes{.surface = tunnel(), .near = 0.02, .far = 0.5, .growth = 0.1};
  const NeutralMesh mesh =
      tetrahedralize(box({1.3, 1.3, 0}, {1.7, 1.7, 0.2}),
                     {.size_field = std::make_shared<const preprocess::SizeField>(std::move(sizes))});
  const double ratio = median_ratio(mesh, [](const Point& p) {
    return 0.02 + 0.1 * std::min(std::min(p[0] - 1, 2 - p[0]), std::min(p[1] - 1, 2 - p[1]));
  });
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

double rising(const Point& p) {
  return 0.1 + 0.1 * p[0];
}

TEST(SizeFields, of_volumes_are_followed) {
  preprocess::NeutralVolume volume;
  volume.sample_count = {5, 2, 2};
  volume.type = formats::ElementType::F64;
  volume.world_from_grid.x_axis = {0.5, 0, 0};
  std::vector<double> samples;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 5; ++i) samples.push_back(rising({0.5 * i, 0, 0}));
  volume.owned_samples.resize(samples.size() * sizeof(double));
  std::memcpy(volume.owned_samples.data(), samples.data(), volume.owned_samples.size());
  volume.samples = volume.owned_samples;
  auto field = std::make_shared<preprocess::SizeField>(std::move(volume));
  auto& kept = std::get<preprocess::NeutralVolume>(*field);
  kept.samples = kept.owned_samples;
  const double ratio = median_ratio(tetrahedralize(box({0, 0, 0}, {2, 1, 1}), {.size_field = field}), rising);
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

TEST(SizeFields, of_meshes_are_followed) {
  NeutralMesh background = tetrahedralize(box({-1, -1, -1}, {3, 2, 2}), {.quality = 0});
  preprocess::NeutralField field{.name = "size", .unit = {}, .values = {}};
  for (const Point& p : background.points) field.values.push_back(rising(p) + 0.1);
  background.point_fields.push_back(field);
  const double ratio =
      median_ratio(tetrahedralize(box({0, 0, 0}, {2, 1, 1}),
                                  {.size_field = std::make_shared<const preprocess::SizeField>(background)}),
                   [](const Point& p) { return rising(p) + 0.1; });
  EXPECT_GT(ratio, 0.7);
  EXPECT_LT(ratio, 1.2);
}

TEST(SizeFields, without_a_use_are_refused) {
  const auto refusal = [](preprocess::SizeByDistance sizes) -> std::string {
    try {
      tetrahedralize(box({0, 0, 0}, {1, 1, 1}),
                     {.size_field = std::make_shared<const preprocess::SizeField>(std::move(sizes))});
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal({.surface = box({0, 0, 0}, {1, 1, 1}), .near = 2, .far = 1, .growth = 0}),
              HasSubstr("expected 0 < near <= far"));
  NeutralMesh elsewhere = tetrahedralize(box({10, 10, 10}, {11, 11, 11}));
  elsewhere.point_fields.push_back(
      {.name = "size", .unit = {}, .values = preprocess::Array<double>(elsewhere.points.size(), 0.1)});
  try {
    tetrahedralize(box({0, 0, 0}, {1, 1, 1}), {.size_field = std::make_shared<const preprocess::SizeField>(elsewhere)});
    ADD_FAILURE() << "was accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("has no value anywhere in the surface"));
  }
}

TEST(TetgenSwitches, of_our_own_are_refused_by_name) {
  const auto refusal = [](const char* switches) -> std::string {
    try {
      tetrahedralize(box({0, 0, 0}, {1, 1, 1}), {.tetgen = switches});
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal("YO2/7S100T1e-9M"), "accepted");
  EXPECT_THAT(refusal("Yq1.2"), HasSubstr("'q' is --quality"));
  EXPECT_THAT(refusal("a0.1"), HasSubstr("--max-volume"));
  EXPECT_THAT(refusal("f"), HasSubstr("changes what TetGen writes"));
  EXPECT_THAT(refusal("r"), HasSubstr("refines a mesh"));
}

TEST(TetgenSwitches, reach_tetgen) {
  const NeutralSurface cube = box({0, 0, 0}, {1, 1, 1});
  const NeutralMesh free = tetrahedralize(cube, {.max_volume = 0.001});
  const NeutralMesh bound = tetrahedralize(cube, {.max_volume = 0.001, .tetgen = "S5"});  // at most five new points
  EXPECT_LE(bound.points.size(), 13u);
  EXPECT_GT(free.points.size(), 100u);
}

TEST(FindFaults, names_every_faulty_facet_with_its_kind) {
  NeutralSurface faulty = box({0, 0, 0}, {1, 1, 1});
  add_box(faulty, {0.5, 0.5, 0.25}, {2, 2, 0.75});
  faulty.points.push_back({2, 0, 0});
  add_facet(faulty, {0, 1, 16});  // 24: on a line
  add_facet(faulty, {0, 3, 2});   // 25: as facet 0, which is 0 2 3
  const auto faults = preprocess::find_faults(faulty);
  const auto count = [&](FacetFault fault) {
    return std::count_if(faults.begin(), faults.end(), [&](const auto& f) { return f.fault == fault; });
  };
  EXPECT_EQ(count(FacetFault::flat), 1);
  EXPECT_EQ(count(FacetFault::twin), 1);
  EXPECT_GT(count(FacetFault::crossing), 4);
  EXPECT_EQ(count(FacetFault::at_open_edge), 0);
  EXPECT_EQ(preprocess::find_faults(box({0, 0, 0}, {1, 1, 1})).size(), 0u);

  NeutralSurface open = box({0, 0, 0}, {1, 1, 1});
  open.facet_corners.resize(33);
  open.facet_offsets.pop_back();
  EXPECT_EQ(preprocess::find_faults(open).size(), 3u);  // the missing triangle's neighbours
}

TEST(HardSurfaces, keep_their_digits_or_are_refused) {
  // 8.5e6 from the origin the box of edge 1 still has its volume.
  const double far = 8.5e6;
  const NeutralMesh mesh = tetrahedralize(box({far, far, far}, {far + 1, far + 1, far + 1}));
  double volume = 0;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) volume += cell_volume(mesh, cell);
  EXPECT_NEAR(volume, 1, 1e-7);

  NeutralSurface one;
  one.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const auto& f : {std::array<std::uint64_t, 3>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}})
    add_facet(one, {f[0], f[1], f[2]});
  EXPECT_EQ(tetrahedralize(one, {.quality = 0}).cells.size(), 1u);

  const double huge = 1e38;
  try {
    const NeutralMesh filled = tetrahedralize(box({-huge, -huge, -huge}, {huge, huge, huge}), {.quality = 0});
    double sum = 0;
    for (std::size_t cell = 0; cell < filled.cells.size(); ++cell) sum += cell_volume(filled, cell);
    EXPECT_NEAR(sum / (8 * huge * huge * huge), 1, 1e-12);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid) << error.what();
  }
}

}  // namespace
}  // namespace rhoray::tests
