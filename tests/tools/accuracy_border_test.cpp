#include "tools/analysis/border.h"

#include <gtest/gtest.h>

#include <random>

#include "preprocess/pack_mesh.h"
#include "preprocess/resample.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

// A grid resampled from a mesh does not end exactly where the mesh ends. Picture errors from this
// are counted separately from errors of the samples.
namespace rhoray::tests {
namespace {

using namespace tools;

const Field ramp = linear_field({1, 0, 0});

/// The unit cube without the part where x, y and z are above one half.
preprocess::NeutralMesh notched_cube() {
  preprocess::NeutralMesh mesh = box_mesh({.cells = {4, 4, 4}, .box = Box3({0, 0, 0}, {1, 1, 1})}, ramp);
  preprocess::Array<std::array<std::uint64_t, 4>> kept;
  for (const auto& cell : mesh.cells) {
    Vec3 middle(0, 0, 0);
    for (const std::uint64_t v : cell) middle += 0.25 * to_vec3(mesh.points[v]);
    if (!(middle.x > 0.5 && middle.y > 0.5 && middle.z > 0.5)) kept.push_back(cell);
  }
  mesh.cells = kept;
  return mesh;
}

TEST(MeshPlaces, are_those_inside_the_mesh) {
  const TemporaryFolder folder;
  preprocess::pack_mesh(notched_cube(), folder / "mesh.rho");
  const formats::TetMesh packed(formats::PackedFile::open(folder / "mesh.rho"));
  const MeshPlaces places(packed);
  const Vec3 origin = packed.description().origin;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-0.2, 1.2);
  int inside = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vec3 p(place(random), place(random), place(random));
    bool is_inside = !(p.x > 0.5 && p.y > 0.5 && p.z > 0.5);
    for (int a = 0; a < 3; ++a) is_inside = is_inside && p[a] > 0 && p[a] < 1;
    EXPECT_EQ(places.holds(p - origin), is_inside) << p;
    inside += is_inside;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_TRUE(places.holds(Vec3(0, 0.25, 0.3) - origin)) << "the border is inside";
}

TEST(ResampledBorder, separates_hits_that_only_the_mesh_has_or_only_the_grid) {
  const TemporaryFolder folder;
  const preprocess::NeutralMesh whole = box_mesh({.cells = {4, 4, 4}, .box = Box3({0, 0, 0}, {1, 1, 1})}, ramp);
  preprocess::pack_mesh(whole, folder / "whole.rho");
  preprocess::pack_mesh(notched_cube(), folder / "notched.rho");
  preprocess::resample(notched_cube(), folder / "grid.rho", {.lattice = {.spacing = {0.15, 0.15, 0.15}}});
  const render::Dataset grid = render::Dataset::load(folder / "grid.rho");
  const auto separates = [&](const char* mesh, const Vec3& truth, const Vec3& said) {
    const render::Dataset dataset = render::Dataset::load(folder / mesh);
    const Vec3 origin = formats::TetMesh(dataset.file()).description().origin;
    // A ray through both points, or from a height of 1 above the only one.
    render::Ray ray{.origin = truth - origin - Vec3(0, 0, 1), .direction = {0, 0, 1}, .t_min = 0, .t_max = 9};
    const auto hit = [&](const Vec3& place) {
      render::Hit found;
      if (place.z > -9) found.t = place.z - ray.origin.z - origin.z;
      return found;
    };
    return ResampledBorder(dataset, grid).separates(ray, hit(truth), hit(said));
  };
  const Vec3 nowhere(0, 0, -10);
  EXPECT_FALSE(separates("notched.rho", {0.3, 0.3, 0.3}, {0.3, 0.3, 0.35})) << "both have both";
  EXPECT_FALSE(separates("notched.rho", {0.3, 0.3, 0.3}, nowhere));
  EXPECT_TRUE(separates("notched.rho", {0.7, 0.7, 0.45}, {0.7, 0.7, 0.55})) << "only the grid is in the notch";
  EXPECT_TRUE(separates("whole.rho", {0.9, 0.9, 0.9}, nowhere)) << "the grid was not made of this corner";
  EXPECT_FALSE(separates("whole.rho", {0.9, 0.9, 0.2}, nowhere));
}

}  // namespace
}  // namespace rhoray::tests
