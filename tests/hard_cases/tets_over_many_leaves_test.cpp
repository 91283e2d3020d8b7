// T19, T24. A tetrahedron that extends over many leaf cells is in the lists of all of them. The
// first leaf cell on a ray may give a crossing far behind it, while the next leaf holds a nearer
// one.
#include <gtest/gtest.h>

#include <cmath>

#include "render/traverse/lattice_walk.h"
#include "render/traverse/ray_box.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

/// The nearest crossing among the tetrahedra of the first leaf cell that has any. This is wrong: it
/// may lie beyond that leaf.
double from_the_first_leaf(const render::TetData& view, const render::Ray& ray, double iso) {
  const render::Ray on_lattice = view.on_lattice(ray);
  const render::PlaneTimes planes(on_lattice);
  const render::WalkLattice lattice = view.lattice();
  double first = HUGE_VAL;
  const auto part = clip_to_lattice(on_lattice, planes, lattice.leaf_count);
  if (!part) return first;
  const render::RayShear shear(ray);
  walk_level(on_lattice, planes, lattice, 1, whole_level(lattice, 1), part->t_in, part->t_out,
             [&](const render::CellVisit& visit) {
               for (const std::uint32_t cell : view.tetrahedra_at(visit.cell)) {
                 const auto vertices = view.sorted_vertices(cell);
                 const auto points = view.points_at(vertices);
                 const render::SeenTet tet{
                     {shear.see(points[0]), shear.see(points[1]), shear.see(points[2]), shear.see(points[3])},
                     view.values_at(vertices)};
                 if (const auto passage = pass_through(tet, iso))
                   if (const auto t = first_crossing(*passage)) first = std::min(first, *t);
               }
               return first == HUGE_VAL;
             });
  return first;
}

TEST(TetsOverManyLeaves, do_not_hide_a_nearer_crossing) {
  const Field field = [](const Vec3& p) { return std::sin(31 * p.x) + std::sin(27 * p.y + 1) + std::sin(29 * p.z); };
  // Cells graded 40 : 1 on every axis, 64,000 : 1 in volume; and large cells scattered over one
  // another (T21).
  const auto graded = box_mesh({.cells = {6, 6, 6}, .jitter = 0.1, .grading = 40}, field);
  auto strewn = strewn_mesh(150, 0.5, 1, 5);
  add_point_field(strewn, "value", field);
  int hits = 0, hidden_by_the_first_leaf = 0;
  for (const auto& [mesh, leaves_per_cell] :
       {std::pair(&graded, 0.01), {&graded, 1.0}, {&graded, 50.0}, {&strewn, 1.0}, {&strewn, 50.0}}) {
    TracedDataset traced(
        *mesh, {.structure = preprocess::MeshStructure::leaves, .leaf_cells_per_tetrahedron = leaves_per_cell});
    const auto& view = std::get<render::TetData>(traced.dataset().implementation().view);
    Dice dice(1);
    for (int trial = 0; trial < 400; ++trial) {
      const Vec3 direction = dice.direction();
      const render::Ray ray{.origin = dice.point({0, 0, 0}, {1, 1, 1}) - 3.0 * direction, .direction = direction};
      const render::Ray in_data = traced.ray_data(ray);
      const render::RayShear shear(in_data);
      double truth = HUGE_VAL;
      for (std::uint32_t cell = 0; cell < mesh->cells.size(); ++cell) {
        const auto vertices = view.sorted_vertices(cell);
        const auto p = view.points_at(vertices);
        const render::SeenTet tet{{shear.see(p[0]), shear.see(p[1]), shear.see(p[2]), shear.see(p[3])},
                                  view.values_at(vertices)};
        if (const auto passage = pass_through(tet, 0.1))
          if (const auto t = first_crossing(*passage)) truth = std::min(truth, *t);
      }
      const render::Hit hit = traced.first_crossing(ray, 0.1);
      ASSERT_EQ(hit.t, truth);
      ASSERT_EQ(traced.first_crossing(ray, 0.1, false).t, truth);
      hits += !hit.is_miss();
      hidden_by_the_first_leaf += from_the_first_leaf(view, in_data, 0.1) > truth;
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(hidden_by_the_first_leaf, 20) << "the first leaf is right: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests
