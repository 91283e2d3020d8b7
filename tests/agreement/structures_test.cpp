#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

// Leaf lists and clusters list the tetrahedra along a ray in different orders and groups. The hit
// must not depend on this, bit for bit: among hits at one t, the cell with the smallest id counts.
namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;
using render::Ray;
using Algorithm = render::Method::Algorithm;

struct MeshCase {
  std::string name;
  preprocess::NeutralMesh mesh;
  double isovalue;
  bool suits_samples = true;  ///< in no region does the field equal the isovalue, where rounding
                              ///< would decide each sample's side
};

/// A mesh squeezed along z between two layers: cells whose four vertices are nearly coplanar,
/// beside good cells.
preprocess::NeutralMesh squeezed_mesh(const Field& field) {
  auto mesh = box_mesh({.cells = {6, 6, 6}, .jitter = 0.1});
  for (auto& point : mesh.points)
    if (point[2] > 0.3 && point[2] < 0.7) point[2] = 0.5 + (point[2] - 0.5) * 1e-4;
  add_point_field(mesh, "value", field);
  return mesh;
}

std::vector<MeshCase> mesh_cases() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Field distance = distance_field({0.4, 0.5, 0.6});
  const Field waves = [](const Vec3& p) { return std::sin(31 * p.x) + std::sin(27 * p.y + 1) + std::sin(29 * p.z); };
  const Field holed = [](const Vec3& p) { return p.x < 0.3 && p.y < 0.4 ? nan : p.x + p.y - p.z; };
  // A field with many equal values.
  const Field steps = [](const Vec3& p) { return std::floor(3 * p.x) + std::floor(3 * p.z); };
  auto cut = box_mesh({.cells = {5, 5, 5}, .jitter = 0.1}, distance);
  // Six tetrahedra are cut from one cell.
  for (std::uint64_t c = 0; c < cut.cells.size(); ++c) cut.cell_ids.push_back(c / 6);
  std::vector<MeshCase> cases;
  cases.push_back({"uniform", box_mesh({.cells = {5, 4, 6}}, distance), 0.3});
  cases.push_back({"jittered waves", box_mesh({.cells = {7, 8, 6}, .jitter = 0.12}, waves, true), 0.1});
  cases.push_back({"graded", box_mesh({.cells = {7, 7, 7}, .jitter = 0.1, .grading = 40}, distance), 0.35});
  cases.push_back({"slivers", squeezed_mesh(distance), 0.3});
  cases.push_back({"without data", box_mesh({.cells = {6, 6, 6}}, holed), 0.5});
  cases.push_back({"equal values", box_mesh({.cells = {6, 6, 6}}, steps), 2, false});
  cases.push_back({"cut from cubes", cut, 0.31});
  return cases;
}

/// Rays that graze edges and the mesh's border, run in faces, or start far away.
std::vector<Ray> stressful_rays_through_cube(std::size_t count) {
  std::vector<Ray> rays = stressful_rays({4, 4, 4}, count, 11);
  // Planes and lattice points are at quarters.
  for (Ray& ray : rays) ray.origin /= 4, ray.direction /= 4;
  return rays;
}

std::vector<Ray> ordinary_rays_through_cube(std::size_t count) {
  Dice dice(3);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const Vec3 direction = dice.direction();
    rays.push_back({.origin = dice.point({0, 0, 0}, {1, 1, 1}) - 3.0 * direction, .direction = direction});
  }
  return rays;
}

/// Compares every bit of two hits.
void expect_same(const Hit& a, const Hit& b, const std::string& of) {
  ASSERT_EQ(a.t, b.t) << of;
  ASSERT_EQ(a.value, b.value) << of;
  ASSERT_EQ(a.cell, b.cell) << of << " at t " << a.t;
  ASSERT_EQ(a.gradient, b.gradient) << of;
  ASSERT_TRUE(a.error == b.error || (std::isnan(a.error) && std::isnan(b.error))) << of;
}

using Ask = Hit (*)(TracedDataset& dataset, const Ray& ray, double isovalue, const Method& method, bool use_hierarchy);

Hit first_crossing(TracedDataset& dataset, const Ray& ray, double isovalue, const Method& method, bool use_hierarchy) {
  return dataset.first_crossing(ray, isovalue, method, use_hierarchy);
}
Hit largest_value(TracedDataset& dataset, const Ray& ray, double, const Method& method, bool use_hierarchy) {
  return dataset.largest_value(ray, method, use_hierarchy);
}

/// Returns the number of hits, and checks that they are the same in leaf lists, clusters and small
/// clusters. Also checks the structures without their trees, which only scalar kernels can do
/// without.
int expect_same_everywhere(const MeshCase& one, Ask ask, const std::vector<Method>& methods,
                           const std::vector<Ray>& rays) {
  TracedDataset leaves(one.mesh, {.structure = preprocess::MeshStructure::leaves});
  TracedDataset clusters(one.mesh), small(one.mesh, {.cluster_size = 4});
  int hits = 0;
  for (std::size_t m = 0; m < methods.size(); ++m)
    for (std::size_t r = 0; r < rays.size(); ++r) {
      const Hit expected = ask(leaves, rays[r], one.isovalue, methods[m], true);
      const std::string of = concat(one.name, ", method ", m, ", ray ", r);
      expect_same(ask(clusters, rays[r], one.isovalue, methods[m], true), expected, of);
      expect_same(ask(clusters, rays[r], one.isovalue, methods[m], false),
                  ask(leaves, rays[r], one.isovalue, methods[m], false), of + " flat");
      expect_same(ask(small, rays[r], one.isovalue, methods[m], true), expected, of + " small");
      hits += !expected.is_miss();
    }
  return hits;
}

TEST(Structures, give_the_same_hits_by_methods_that_no_ray_slips_through) {
  const std::vector<Method> methods{{},
                                    {.precision = Method::Precision::float32},
                                    {.algorithm = Algorithm::preview},
                                    {.algorithm = Algorithm::certified},
                                    {.algorithm = Algorithm::exact}};
  const std::vector<Ray> rays = stressful_rays_through_cube(150);
  int crossings = 0, values = 0;
  for (const MeshCase& one : mesh_cases()) {
    crossings += expect_same_everywhere(one, first_crossing, methods, rays);
    values += expect_same_everywhere(one, largest_value, methods, rays);
  }
  EXPECT_GT(crossings, 1000);
  EXPECT_GT(values, 2000);
}

// By rounding, the method of Appendix B accepts crossings that lie beside a cell, and a sample may
// lie beside the mesh. Whether a grazing ray looks there depends on the regions that it meets. Rays
// in general position have the same hits.
TEST(Structures, give_the_same_hits_of_ordinary_rays_by_published_methods) {
  const std::vector<Method> methods{
      {.algorithm = Algorithm::paper},
      {.algorithm = Algorithm::slack, .slack = 1e-12},
      {.algorithm = Algorithm::slack, .precision = Method::Precision::float32, .slack = 1e-4},
      {.algorithm = Algorithm::sampled},
      {.algorithm = Algorithm::sampled, .step = 0.3, .bisect = true}};
  const std::vector<Ray> rays = ordinary_rays_through_cube(200);
  int crossings = 0, values = 0;
  for (const MeshCase& one : mesh_cases()) {
    if (!one.suits_samples) continue;
    crossings += expect_same_everywhere(one, first_crossing, methods, rays);
    values += expect_same_everywhere(one, largest_value, {{.algorithm = Algorithm::sampled}}, rays);
  }
  EXPECT_GT(crossings, 1500);
  EXPECT_GT(values, 900);
}

TEST(Structures, of_clusters_look_into_each_cell_once_and_far_fewer_than_there_are) {
  const auto mesh = box_mesh({.cells = {20, 20, 20}, .jitter = 0.1}, distance_field({0.5, 0.5, 0.5}));
  TracedDataset traced(mesh);
  traced.first_crossing({.origin = {-1, 0.41, 0.43}, .direction = {1, 0, 0}}, 0.3);
  const render::KernelCounters& counters = traced.scratch.counters;
  EXPECT_GT(counters.cells_solved, 0U);
  EXPECT_LE(counters.cells_solved, 64 * counters.cells_visited);
  EXPECT_LT(counters.cells_visited, 40U) << "of 750 clusters";
  EXPECT_LT(counters.macrocells_visited, 40U);
}

}  // namespace
}  // namespace rhoray::tests
