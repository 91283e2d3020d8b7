#include "preprocess/grid/resample/locate.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_data_structure_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <gtest/gtest.h>

#include <random>

#include "preprocess/mesh/inspect/orientation.h"
#include "tests/preprocess/grid/resample/support.h"

namespace rhoray::preprocess {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::uint64_t, Kernel>;
using Cell = CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;

/// Points of the cube from 0 to 1, its corners among them, on multiples of 1 / steps; anywhere when
/// steps is 0.
std::vector<Kernel::Point_3> random_points(std::size_t count, int steps, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto number = [&] {
    const double u = unit(random);
    return steps == 0 ? u : std::round(u * steps) / steps;
  };
  std::vector<Kernel::Point_3> points;
  for (int corner = 0; corner < 8; ++corner) points.emplace_back(corner & 1, corner >> 1 & 1, corner >> 2);
  while (points.size() < count) {
    const double x = number(), y = number(), z = number();
    points.emplace_back(x, y, z);
  }
  return points;
}

NeutralMesh mesh_of(Delaunay& delaunay) {
  NeutralMesh mesh;
  for (const auto& vertex : delaunay.finite_vertex_handles()) {
    vertex->info() = mesh.points.size();
    mesh.points.push_back({vertex->point().x(), vertex->point().y(), vertex->point().z()});
  }
  for (const auto& cell : delaunay.all_cell_handles()) cell->info() = Places::outside;
  for (const auto& cell : delaunay.finite_cell_handles()) {
    cell->info() = static_cast<std::uint32_t>(mesh.cells.size());
    mesh.cells.push_back(
        {cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(), cell->vertex(3)->info()});
  }
  tests::add_point_field(mesh, "value", tests::linear_field({1, 2, 3}));
  return mesh;
}

/// The lowest cell that has the point, as CGAL sees it, and how it has it.
struct Judged {
  std::uint32_t owner = Places::outside;
  Delaunay::Locate_type type{};
};

Judged judge(const Delaunay& delaunay, const std::array<double, 3>& p) {
  Judged judged;
  int li = 0, lj = 0;
  const auto cell = delaunay.locate({p[0], p[1], p[2]}, judged.type, li, lj);
  std::vector<Delaunay::Cell_handle> all;
  switch (judged.type) {
    case Delaunay::CELL:
      all = {cell};
      break;
    case Delaunay::FACET:
      all = {cell, cell->neighbor(li)};
      break;
    case Delaunay::EDGE: {
      auto around = delaunay.incident_cells(cell, li, lj);
      const auto start = around;
      do all.push_back(around);
      while (++around != start);
      break;
    }
    case Delaunay::VERTEX:
      delaunay.incident_cells(cell->vertex(li), std::back_inserter(all));
      break;
    default:
      break;
  }
  for (const auto& c : all) judged.owner = std::min(judged.owner, c->info());
  return judged;
}

/// How many samples CGAL found in cells, on faces, edges and vertices, and outside; all must be
/// where it says.
std::map<Delaunay::Locate_type, int> compare_with_cgal(std::size_t point_count, int steps,
                                                       const LatticeRequest& request, std::uint64_t seed) {
  const std::vector<Kernel::Point_3> points = random_points(point_count, steps, seed);
  Delaunay delaunay(points.begin(), points.end());
  const Sampled sampled(mesh_of(delaunay), request);
  EXPECT_EQ(sampled.mesh.cells.size(), delaunay.number_of_finite_cells());
  const std::vector<std::uint32_t> owners = sampled.owners();
  std::map<Delaunay::Locate_type, int> types;
  std::size_t wrong = 0, s = 0;
  sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const Judged judged = judge(delaunay, sampled.place(i, j, k));
    ++types[judged.type];
    wrong += owners[s++] != judged.owner;
  });
  EXPECT_EQ(wrong, 0U) << "of " << s;
  return types;
}

TEST(Locate, agrees_with_cgal_where_samples_lie_in_cells) {
  const auto types = compare_with_cgal(400, 0, {.longest_axis = 50}, 1);
  EXPECT_GT(types.at(Delaunay::CELL), 100'000);
}

TEST(Locate, agrees_with_cgal_on_faces_edges_and_vertices) {
  auto types = compare_with_cgal(300, 16, {.sample_count = {33, 33, 33}}, 2);
  EXPECT_GT(types[Delaunay::FACET], 1000);
  EXPECT_GT(types[Delaunay::EDGE], 1000);
  EXPECT_GT(types[Delaunay::VERTEX], 250);
}

TEST(Locate, agrees_with_cgal_on_faces_that_only_exact_arithmetic_finds) {
  // Thirds and sevenths are rounded: samples lie next to faces, by less than a double's determinant
  // can tell.
  auto types = compare_with_cgal(200, 21, {.sample_count = {22, 43, 8}}, 3);
  EXPECT_GT(types[Delaunay::FACET] + types[Delaunay::EDGE] + types[Delaunay::VERTEX], 100);
}

TEST(Locate, agrees_with_cgal_outside) {
  auto types = compare_with_cgal(100, 8, {.spacing = {0.03125, 0.07, 0.9}}, 4);
  EXPECT_GT(types[Delaunay::OUTSIDE_CONVEX_HULL], 100);
}

/// Cell by cell, sample by sample.
std::vector<std::uint32_t> owners_by_force(const Sampled& sampled) {
  std::vector<std::uint32_t> owners;
  const CleanMesh& mesh = sampled.mesh;
  sampled.for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
    std::uint32_t owner = Places::outside;
    for (std::uint32_t c = 0; c < mesh.cells.size() && owner == Places::outside; ++c) {
      std::array<std::array<double, 3>, 4> p;
      for (std::size_t v = 0; v < 4; ++v) p[v] = mesh.points[mesh.cells[c][v]];
      bool holds = orientation(p[0], p[1], p[2], p[3]) > 0;
      for (std::size_t v = 0; v < 4 && holds; ++v) {
        auto moved = p;
        moved[v] = sampled.place(i, j, k);
        holds = orientation(moved[0], moved[1], moved[2], moved[3]) >= 0;
      }
      if (holds) owner = c;
    }
    owners.push_back(owner);
  });
  return owners;
}

TEST(Locate, decides_slivers_and_flat_cells_as_exact_arithmetic_does) {
  for (const double flatness : {1e-3, 1e-9, 0.0}) {
    NeutralMesh mesh = tests::strewn_mesh(60, 0.4, flatness, 5);
    tests::add_point_field(mesh, "value", tests::product_field());
    const Sampled sampled(mesh, {.longest_axis = 22});
    EXPECT_EQ(sampled.owners(), owners_by_force(sampled)) << flatness;
  }
}

TEST(Locate, gives_no_sample_to_a_flat_cell_and_shares_none_out_twice) {
  // All vertices are samples, and the flat cells lie in planes of samples.
  NeutralMesh mesh = tests::box_mesh({.cells = {4, 4, 4}});
  mesh.cells.insert(mesh.cells.begin(), {0, 1, 5, 6});
  tests::add_point_field(mesh, "value", tests::linear_field({1, 1, 1}));
  const Sampled sampled(mesh, {.sample_count = {17, 17, 17}});
  ASSERT_EQ(sampled.mesh.flat_cell_count, 1U);
  const std::vector<std::uint32_t> owners = sampled.owners();
  EXPECT_EQ(owners, owners_by_force(sampled));
  EXPECT_EQ(std::count(owners.begin(), owners.end(), 0U), 0);
  EXPECT_EQ(std::count(owners.begin(), owners.end(), Places::outside), 0);
  EXPECT_EQ(sampled.samples.inside_count, 17U * 17 * 17);
  EXPECT_EQ(sampled.samples.overlap_count, 0U);
}

TEST(Locate, is_exact_far_from_the_origin) {
  NeutralMesh mesh =
      tests::box_mesh({.cells = {5, 5, 5}, .box = Box3({8.5e6, -3e5, 1e3}, {8.5e6 + 2, -3e5 + 1, 1e3 + 3})});
  tests::add_point_field(mesh, "value", tests::linear_field({1, 1, 1}));
  const Sampled sampled(mesh, {.longest_axis = 31});
  EXPECT_EQ(sampled.owners(), owners_by_force(sampled));
  EXPECT_EQ(sampled.samples.inside_count, static_cast<std::uint64_t>(volume(sampled.lattice.count)));
}

TEST(Locate, weighs_a_sample_in_a_sliver_as_it_lies) {
  // So flat that plane equations in double have few digits left; the value is the height over a
  // base of 1e-9.
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.25, 0x1p-44}};
  mesh.cells = {{0, 1, 2, 3}};
  mesh.point_fields = {
      {.name = "value", .unit = {}, .component_count = 1, .was_single_precision = false, .values = {0, 0, 0, 1}}};
  const Sampled sampled(mesh, {.sample_count = {5, 5, 9}});
  EXPECT_EQ(sampled.sample(1, 1, 4), 0.5);
  EXPECT_EQ(sampled.sample(1, 1, 8), 1.0);
}

}  // namespace
}  // namespace rhoray::preprocess
