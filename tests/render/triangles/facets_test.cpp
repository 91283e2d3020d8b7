#include "render/triangles/facets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <stop_token>
#include <vector>

#include "formats/triangle_mesh.h"
#include "render/render.h"
#include "render/tets/active_cells.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using render::Facets;
using Corner = std::array<float, 3>;

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

struct Made {
  TracedDataset traced;
  Made(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options = {}) : traced(mesh, options) {}

  const render::TetData& view() const { return std::get<render::TetData>(traced.dataset().implementation().view); }
  Facets facets(double isovalue, unsigned threads = 1) const {
    return Facets(view(), traced.dataset().implementation().bounds_data, isovalue, threads);
  }
};

std::array<Corner, 4> corners_of(const Facets& facets, std::uint32_t f) {
  std::array<Corner, 4> corners;
  const render::FacetBlock& block = facets.blocks()[f / render::FacetBlock::size];
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t axis = 0; axis < 3; ++axis) corners[c][axis] = block.corner[c][axis][f % render::FacetBlock::size];
  return corners;
}

// A frame that was stopped keeps nothing of a preparation, and the next one prepares all of it.
TEST(Facets, of_a_preparation_that_was_stopped_are_not_kept) {
  std::stop_source source;
  source.request_stop();
  const std::stop_token stopped = source.get_token();
  for (const auto structure : {preprocess::MeshStructure::leaves, preprocess::MeshStructure::clusters}) {
    preprocess::PackMeshOptions options;
    options.structure = structure;
    const Made mesh(box_mesh({.cells = {9, 9, 9}}, waves), options);
    const render::Dataset& dataset = mesh.traced.dataset();
    const render::LoadedDataset& implementation = dataset.implementation();
    const auto kept = [&] {
      return implementation.facets->of(mesh.view(), implementation.bounds_data, 0.2, 1, stopped);
    };
    const auto expect_nothing_kept = [&] { expect_error(ErrorCode::interrupted, "interrupted", kept); };
    render::Scene scene;
    scene.camera = fit_camera(dataset.bounds(), render::named_view("iso"), 1);
    scene.layers[0].isovalue = 0.2;
    scene.layers[0].method = render::method_of(render::Accuracy::float32);
    render::Framebuffer picture;
    render::RenderContext memory;
    const render::FrameOptions frame{.width = 32, .height = 32};
    expect_nothing_kept();
    EXPECT_EQ(render::refine(dataset, scene, frame, {.first_spacing = 1, .watch = stopped}, picture, memory).rays, 0U);
    expect_nothing_kept();
    EXPECT_EQ(render::render(dataset, scene, frame, picture, memory).rays, 32U * 32);
    ASSERT_NE(kept(), nullptr);
    EXPECT_EQ(kept()->count(), mesh.facets(0.2).count());
  }
}

/// Facets of one triangle, in the frame of a box.
Facets facets_of_a_triangle(const Box3& bounds) {
  const TemporaryFolder folder;
  formats::TriangleMeshDescription description;
  description.point_type = formats::ElementType::F64;
  description.point_count = 3, description.triangle_count = 1, description.bounds = bounds;
  const std::filesystem::path path = folder / "s.rho";
  formats::PackedFileWriter writer(path, formats::describe(description), formats::triangle_mesh_arrays(description));
  const std::vector<double> points{bounds.min.x, bounds.min.y, bounds.min.z, bounds.max.x, bounds.max.y,
                                   bounds.max.z, bounds.max.x, bounds.min.y, bounds.min.z};
  const std::vector<std::uint32_t> triangle{0, 1, 2};
  writer.write_all("points", std::span<const double>(points));
  writer.write_all("triangles", std::span<const std::uint32_t>(triangle));
  writer.commit();
  const render::Dataset dataset = render::Dataset::load(path);
  return Facets(std::get<render::TriangleData>(dataset.implementation().view), bounds, 1);
}

// The exponent of half the size, plus one, once overflowed where the size did.
TEST(Facets, stand_between_minus_one_and_one_whatever_the_size_of_the_box) {
  constexpr double largest = std::numeric_limits<double>::max(), least = std::numeric_limits<double>::denorm_min();
  for (const double half : {1.0, 3.7, 1e-300, 1e300, largest, largest / 2, least, 1024 * least}) {
    const Facets facets = facets_of_a_triangle({Vec3(-half), Vec3(half)});
    int exponent = 0;
    EXPECT_EQ(std::frexp(facets.scale(), &exponent), 0.5) << half;
    EXPECT_LE(half * facets.scale(), 1) << half;
    if (half > 1e-300) {
      EXPECT_GE(half * facets.scale(), 0.25) << half;
    }
    for (const Corner& corner : corners_of(facets, 0))
      for (const float x : corner) EXPECT_LE(std::abs(x), 1) << half;
  }
}

TEST(Facets, are_one_for_each_cell_with_values_on_both_sides) {
  const auto mesh = box_mesh({.cells = {7, 8, 6}, .jitter = 0.12}, waves);
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    Made made(mesh, {.structure = structure});
    const auto& view = made.view();
    for (const double isovalue : {0.1, 0.9, -1.5, 7.0}) {
      std::set<std::uint64_t> expected, found;
      for (std::uint32_t cell = 0; cell < view.description().cell_count; ++cell) {
        const auto values = view.values_at(view.sorted_vertices(cell));
        const auto inside = std::count_if(values.begin(), values.end(), [&](double v) { return v >= isovalue; });
        if (inside != 0 && inside != 4) expected.insert(view.cell_id(cell));
      }
      const Facets facets = made.facets(isovalue);
      for (std::uint32_t f = 0; f < facets.count(); ++f) found.insert(facets.fields()[f].cell);
      EXPECT_EQ(found, expected);
      EXPECT_EQ(facets.count(), expected.size());
    }
  }
}

TEST(Facets, have_corners_where_the_field_is_the_isovalue_and_fields_of_their_cells) {
  const Vec3 slope(0.3, -0.7, 0.5);
  Made made(box_mesh({.cells = {7, 8, 6}, .jitter = 0.12}, linear_field(slope, 2)));
  const Facets facets = made.facets(2.05);
  ASSERT_GT(facets.count(), 100U);
  const Vec3 origin = made.traced.dataset().implementation().world_from_data.origin;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const render::FacetField& field = facets.fields()[f];
    EXPECT_LT((Vec3(field.gradient[0], field.gradient[1], field.gradient[2]) - slope).length(), 1e-12);
    EXPECT_LT(field.doubt, 1e-9);
    for (const Corner& corner : corners_of(facets, f)) {
      const Vec3 p = Vec3(corner[0], corner[1], corner[2]) / facets.scale() + facets.anchor() + origin;
      EXPECT_NEAR(slope.dot(p) + 2, 2.05, 1e-7);
      EXPECT_LE(std::max({std::abs(corner[0]), std::abs(corner[1]), std::abs(corner[2])}), 1.0f);
    }
  }
}

/// Returns the edges of facets, with corners ordered by their bits, and the number of facets at
/// each.
std::map<std::array<Corner, 2>, int> edges_of(const Facets& facets) {
  std::map<std::array<Corner, 2>, int> edges;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const std::array<Corner, 4> corners = corners_of(facets, f);
    for (std::size_t c = 0; c < 4; ++c) {
      const Corner &a = corners[c], &b = corners[(c + 1) % 4];
      if (a != b) ++edges[{std::min(a, b), std::max(a, b)}];
    }
  }
  return edges;
}

TEST(Facets, share_their_edges_bit_for_bit_so_that_a_closed_surface_is_closed) {
  const Field ball = [](const Vec3& p) { return 0.3 - (p - Vec3(0.5)).length() + 0.03 * std::sin(30 * p.x); };
  for (const double centre : {0.0, 1e5}) {
    Made made(box_mesh({.cells = {9, 9, 9}, .box = Box3(Vec3(centre), Vec3(centre + 1)), .jitter = 0.14},
                       [&](const Vec3& p) { return ball(p - Vec3(centre)); }));
    const Facets facets = made.facets(0);
    ASSERT_GT(facets.count(), 500U);
    for (const auto& [edge, count] : edges_of(facets)) ASSERT_EQ(count, 2) << edge[0][0] << " to " << edge[1][0];
  }
}

TEST(Facets, meet_in_points_whose_value_is_the_isovalue) {
  // Integer values at integer positions: many points are on the surface, and facets shrink to edges
  // and points.
  Made made(box_mesh({.cells = {6, 6, 6}, .box = Box3(Vec3(0), Vec3(6))},
                     [](const Vec3& p) { return 2 - std::floor((p - Vec3(3)).length()); }));
  const Facets facets = made.facets(0);
  int points = 0;
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    const auto corners = corners_of(facets, f);
    points += corners[0] == corners[1] && corners[1] == corners[2] && corners[2] == corners[3];
  }
  EXPECT_GT(points, 0) << "is this case still the hard one?";
  for (const auto& [edge, count] : edges_of(facets)) ASSERT_EQ(count % 2, 0);
}

TEST(Facets, of_cells_without_volume_have_fields_in_doubt) {
  auto mesh = box_mesh({.cells = {3, 3, 3}, .box = Box3(Vec3(0), Vec3(3))}, linear_field({1, 2, 3}));
  const std::uint64_t first = mesh.points.size();
  const std::array<std::array<double, 3>, 4> square{{{5, 0, 0}, {6, 0, 0}, {6, 1, 0}, {5, 1, 0}}};
  for (std::size_t i = 0; i < 4; ++i) {
    mesh.points.push_back(square[i]);
    mesh.point_fields[0].values.push_back(i < 2 ? 0.0 : 10.0);
  }
  mesh.cells.push_back({first, first + 1, first + 2, first + 3});
  Made made(mesh);
  const Facets facets = made.facets(5);
  int in_doubt = 0;
  for (std::uint32_t f = 0; f < facets.count(); ++f) in_doubt += std::isinf(facets.fields()[f].doubt);
  EXPECT_EQ(in_doubt, 1);
}

TEST(Facets, stand_in_boxes_that_hold_them) {
  Made made(box_mesh({.cells = {16, 15, 14}, .jitter = 0.12}, waves));
  const Facets facets = made.facets(0.1);
  ASSERT_GE(facets.level_count(), 2);
  for (std::uint32_t f = 0; f < facets.count(); ++f) {
    std::uint32_t child = f / 16;
    for (int level = 0; level < facets.level_count(); ++level, child /= 16)
      for (const Corner& corner : corners_of(facets, f))
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const render::FacetNode& node = facets.level(level)[child / 16];
          ASSERT_LE(node.low[axis][child % 16], corner[axis]);
          ASSERT_GE(node.high[axis][child % 16], corner[axis]);
        }
    ASSERT_EQ(child, 0U);
  }
}

TEST(Facets, are_the_same_bytes_for_any_number_of_threads_and_either_structure) {
  const auto mesh = box_mesh({.cells = {24, 24, 24}, .jitter = 0.12}, waves);
  Made made(mesh);
  const Facets one = made.facets(0.1);
  ASSERT_GT(one.count(), 256U * 16);
  const auto is_same = [&](const Facets& other) {
    return one.count() == other.count() &&
           std::memcmp(one.blocks(), other.blocks(), one.count() / 16 * sizeof(render::FacetBlock)) == 0 &&
           std::memcmp(one.fields(), other.fields(), one.count() * sizeof(render::FacetField)) == 0 &&
           one.size_bytes() == other.size_bytes();
  };
  for (const unsigned threads : {2U, 3U, 8U}) EXPECT_TRUE(is_same(made.facets(0.1, threads))) << threads;
  using enum preprocess::MeshStructure;
  EXPECT_TRUE(is_same(Made(mesh, {.cluster_size = 8}).facets(0.1)));
  EXPECT_TRUE(is_same(Made(mesh, {.structure = leaves}).facets(0.1)));
  EXPECT_TRUE(
      is_same(Made(mesh, {.structure = leaves, .leaf_cells_per_tetrahedron = 5, .macro_factor = 3}).facets(0.1)));
}

}  // namespace
}  // namespace rhoray::tests
