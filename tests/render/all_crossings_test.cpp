#include "render/all_crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "preprocess/pack_surface.h"
#include "render/ray_caster.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/host_floating_point.h"
#include "tests/support/meshes.h"
#include "tests/support/narrowed.h"
#include "tests/support/surfaces.h"

namespace rhoray::tests {
namespace {

using render::AllCrossings;
using render::Crossing;

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

/// -1 and 1 by turns in the planes x = 0, 1, 2, ...
double zigzag(double x) {
  return static_cast<std::int64_t>(std::llround(x)) % 2 == 0 ? -1 : 1;
}

preprocess::NeutralMesh zigzag_mesh() {
  return box_mesh({.cells = {7, 4, 3}, .box = {{0, 0, 0}, {7, 4, 3}}}, [](const Vec3& p) { return zigzag(p.x); });
}

preprocess::PackMeshOptions with(preprocess::MeshStructure structure) {
  preprocess::PackMeshOptions options;
  options.structure = structure;
  return options;
}

bool are_equal(const Crossing& a, const Crossing& b) {
  return a.t == b.t && a.error == b.error && a.cell == b.cell && a.to_inside == b.to_inside;
}

/// Expects a crossing in the middle between each two planes x = planes[k], by turns to the inside
/// and to the outside.
std::vector<Crossing> expect_zigzag(const render::Dataset& dataset, const std::vector<double>& planes,
                                    const render::Ray& ray) {
  const AllCrossings found = render::all_crossings(dataset, 0, ray, all);
  EXPECT_FALSE(found.truncated);
  EXPECT_EQ(found.crossings.size(), planes.size() - 1);
  if (found.crossings.size() != planes.size() - 1) return {};
  for (std::size_t k = 0; k + 1 < planes.size(); ++k) {
    const double t = (0.5 * (planes[k] + planes[k + 1]) - ray.origin.x) / ray.direction.x;
    EXPECT_NEAR(found.crossings[k].t, t, found.crossings[k].error + 1e-15 * std::abs(t)) << k;
    EXPECT_LE(found.crossings[k].error, 1e-11) << k;
    EXPECT_EQ(found.crossings[k].to_inside, k % 2 == 0) << k;
  }
  return found.crossings;
}

TEST(AllCrossings, are_where_the_field_changes_in_grids_and_meshes) {
  const render::Ray ray{{-2, 0.75, 1.25}, {2, 0.5, 0.25}};
  std::vector<double> planes{0, 1, 2, 3, 4, 5, 6, 7};
  auto volume = volume_of<double>({8, 5, 4}, [](const Index3& at) { return zigzag(static_cast<double>(at.x)); });
  const TracedDataset uniform(volume);
  const auto in_uniform = expect_zigzag(uniform.dataset(), planes, ray);
  for (std::size_t k = 0; k < in_uniform.size(); ++k) {
    const Vec3 p = ray.at(in_uniform[k].t);
    EXPECT_EQ(in_uniform[k].cell,
              k + 7 * static_cast<std::uint64_t>(std::floor(p.y)) + 28 * static_cast<std::uint64_t>(std::floor(p.z)));
  }
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    const TracedDataset mesh(zigzag_mesh(), with(structure));
    // Rays are relative to the mesh's own origin.
    render::Ray in_data = ray;
    in_data.origin = render::world_from_ray_frame(mesh.dataset()).inverse().point(ray.origin);
    std::vector<double> moved = planes;
    for (double& x : moved) x += in_data.origin.x - ray.origin.x;
    for (const Crossing& crossing : expect_zigzag(mesh.dataset(), moved, in_data)) {
      const double x = ray.at(crossing.t).x;
      EXPECT_EQ(crossing.cell / 6 % 7, static_cast<std::uint64_t>(std::floor(x))) << "six cells a cube";
    }
  }
  planes = {0, 1, 1.5, 3, 4.25, 5, 8, 9};
  volume.axes = {planes, {0, 1, 2, 3.5, 5}, {0, 2, 4, 5}};
  expect_zigzag(TracedDataset(volume).dataset(), planes, ray);
}

struct Noise {
  const char* name;
  std::unique_ptr<TracedDataset> traced;
};

/// Values whose isosurface at 0 rays cross many times.
std::vector<Noise> noisy_data() {
  const auto noise = [](std::uint64_t seed, bool has_gaps) {
    return [dice = std::make_shared<Dice>(seed), has_gaps](const auto&) {
      return has_gaps && dice->below(30) == 0 ? std::nanf("") : static_cast<float>(dice->between(-1, 1));
    };
  };
  std::vector<Noise> made;
  made.push_back({"grid", std::make_unique<TracedDataset>(volume_of<float>({14, 12, 13}, noise(1, false)))});
  made.push_back({"grid with gaps", std::make_unique<TracedDataset>(volume_of<float>({14, 12, 13}, noise(2, true)))});
  auto stretched = volume_of<float>({6, 5, 4}, noise(3, false));
  stretched.axes = {{{0, 1, 2.5, 2.75, 7, 8}, {-1, 0, 3, 3.1, 9}, {0, 4, 5, 6}}};
  made.push_back({"rectilinear grid", std::make_unique<TracedDataset>(stretched)});
  const auto mesh = box_mesh({.cells = {6, 6, 6}, .jitter = 0.1}, noise(4, false));
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves})
    made.push_back({"mesh", std::make_unique<TracedDataset>(mesh, with(structure))});
  return made;
}

/// Rays through the bounds of the data, in their frame.
std::vector<render::Ray> rays_through(const render::Dataset& dataset, std::size_t count) {
  const Box3& bounds = dataset.implementation().bounds_data;
  Dice dice(71);
  std::vector<render::Ray> rays;
  while (rays.size() < count) {
    const Vec3 direction = dice.direction() * dice.between(0.5, 2);
    rays.push_back({dice.point(bounds.min, bounds.max) - 3 * bounds.size().length() * direction, direction});
  }
  return rays;
}

TEST(AllCrossings, begin_with_the_hit_of_the_level_exact_and_go_on_behind_it) {
  for (const Noise& noise : noisy_data()) {
    SCOPED_TRACE(noise.name);
    const render::Dataset& dataset = noise.traced->dataset();
    render::RayCaster exact(dataset, 0, render::method_of(render::Accuracy::exact));
    std::size_t found = 0, compared = 0;
    for (render::Ray ray : rays_through(dataset, 60)) {
      const std::vector<Crossing> crossings = render::all_crossings(dataset, 0, ray, all).crossings;
      found += crossings.size();
      const double start = ray.t_min;
      for (std::size_t c = 0; c <= crossings.size(); ++c) {
        const render::Hit hit = exact.first_crossing(ray);
        ASSERT_EQ(hit.is_miss(), c == crossings.size());
        if (hit.is_miss()) break;
        if (ray.t_min == start) {
          ASSERT_EQ(hit.t, crossings[c].t);
          ASSERT_EQ(hit.error, crossings[c].error);
        }
        ASSERT_NEAR(hit.t, crossings[c].t, hit.error + crossings[c].error);
        ASSERT_EQ(hit.cell, crossings[c].cell);
        ++compared;
        ray.t_min = hit.t + 1e-7;
        if (c + 1 < crossings.size() && crossings[c + 1].t < ray.t_min + 1e-7) break;
      }
    }
    EXPECT_GT(found, 80U);
    EXPECT_GT(compared + 10, found);
  }
}

TEST(AllCrossings, say_whether_there_are_more) {
  const TracedDataset mesh(zigzag_mesh());
  const TracedDataset grid(volume_of<float>(
      {8, 3, 3}, [](const Index3& at) { return static_cast<float>(zigzag(static_cast<double>(at.x))); }));
  for (const TracedDataset* traced : {&mesh, &grid}) {
    const Box3& bounds = traced->dataset().implementation().bounds_data;
    const render::Ray ray{{bounds.min.x - 1, bounds.center().y + 0.1, bounds.center().z + 0.2}, {1, 0, 0}};
    const AllCrossings whole = render::all_crossings(traced->dataset(), 0, ray, all);
    ASSERT_EQ(whole.crossings.size(), 7U);
    for (const std::size_t most : {0U, 1U, 6U, 7U, 8U}) {
      const AllCrossings some = render::all_crossings(traced->dataset(), 0, ray, most);
      EXPECT_EQ(some.truncated, most < 7) << most;
      ASSERT_EQ(some.crossings.size(), std::min<std::size_t>(most, 7));
      for (std::size_t c = 0; c < some.crossings.size(); ++c)
        EXPECT_TRUE(are_equal(some.crossings[c], whole.crossings[c]));
    }
    EXPECT_FALSE(render::all_crossings(traced->dataset(), 2, ray, 0).truncated) << "none at all";
  }
}

TEST(AllCrossings, enter_and_leave_at_one_t_where_a_ray_touches) {
  const TracedDataset ridge(volume_of<float>({5, 3, 3}, [](const Index3& at) { return at.x == 2 ? 1.0F : 0.0F; }));
  const AllCrossings found = render::all_crossings(ridge.dataset(), 1, {{-1, 0.5, 0.5}, {1, 0, 0}}, all);
  ASSERT_EQ(found.crossings.size(), 2U);
  EXPECT_TRUE(are_equal(found.crossings[0], {3, 0, 1, true}));
  EXPECT_TRUE(are_equal(found.crossings[1], {3, 0, 2, false}));
}

TEST(AllCrossings, do_not_depend_on_the_floating_point_environment_of_the_host) {
  for (const Noise& noise : noisy_data()) {
    SCOPED_TRACE(noise.name);
    std::size_t compared = 0;
    for (const render::Ray& ray : rays_through(noise.traced->dataset(), 10)) {
      const AllCrossings expected = render::all_crossings(noise.traced->dataset(), 0, ray, all);
      for (const HostFloatingPoint& host : host_environments()) {
        const InHostFloatingPoint environment(host);
        const AllCrossings found = render::all_crossings(noise.traced->dataset(), 0, ray, all);
        EXPECT_TRUE(environment.is_kept()) << host.name;
        ASSERT_EQ(found.crossings.size(), expected.crossings.size()) << host.name;
        for (std::size_t c = 0; c < found.crossings.size(); ++c)
          EXPECT_TRUE(are_equal(found.crossings[c], expected.crossings[c])) << host.name;
        compared += found.crossings.size();
      }
    }
    EXPECT_GT(compared, 50U);
  }
}

TEST(AllCrossings, are_refused_where_they_have_no_meaning_or_no_proof) {
  const render::Ray ray{{-1, 0.5, 0.5}, {1, 0, 0}};
  const TracedDataset mesh(zigzag_mesh());
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double isovalue : {std::nan(""), infinity, -infinity})
    expect_error(ErrorCode::usage, "isovalue", [&] { render::all_crossings(mesh.dataset(), isovalue, ray, 1); });
  const TemporaryFolder folder;
  preprocess::pack_surface(cube_surface(), folder / "cube.rho");
  for (const render::Dataset& triangles : {render::Dataset::load(folder / "cube.rho"), mesh.dataset().boundary()})
    expect_error(ErrorCode::unsupported, "triangles", [&] { render::all_crossings(triangles, 0, ray, 1); });
  const TracedDataset spoilt(
      narrowed(read_file(mesh.dataset().file().name()), "range.0.0", IntervalStep::cluster_ranges));
  expect_error(ErrorCode::invalid, "packed.rho: ", [&] { render::all_crossings(spoilt.dataset(), 0, ray, 1); });
}

}  // namespace
}  // namespace rhoray::tests
