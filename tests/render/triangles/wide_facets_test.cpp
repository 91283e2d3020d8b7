#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "render/method.h"
#include "render/query/kernels.h"
#include "render/ray_caster.h"
#include "tests/render/support/crossings.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;

constexpr Method single = render::method_of(render::Accuracy::float32);
constexpr Method certified = render::method_of(render::Accuracy::certified);
constexpr Method judged = render::method_of(render::Accuracy::exact);

struct Mesh {
  std::string name;
  std::unique_ptr<TracedDataset> traced;
  Box3 box;  ///< in the data's frame
  std::vector<double> isovalues;
  /// The longest edge of any cell, or the longest distance over which the rounding of a cell's
  /// positions matters.
  double cell_size;
};

Mesh made(const std::string& name, const preprocess::NeutralMesh& mesh, std::vector<double> isovalues,
          double cell_size) {
  Mesh packed{name, std::make_unique<TracedDataset>(mesh), {}, std::move(isovalues), cell_size};
  packed.box = packed.traced->dataset().implementation().bounds_data;
  return packed;
}

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z) + 0.3 * std::sin(23 * p.z + 11 * p.x);
}

/// Scales a mesh along one axis.
preprocess::NeutralMesh squeezed(preprocess::NeutralMesh mesh, double factor) {
  for (auto& point : mesh.points) point[2] *= factor;
  return mesh;
}

preprocess::NeutralMesh with_values(preprocess::NeutralMesh mesh, const std::function<double(std::size_t)>& value) {
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    double& v = mesh.point_fields[0].values[p];
    if (const double other = value(p); !std::isinf(other)) v = other;
  }
  return mesh;
}

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Meshes of many kinds with surfaces in general position.
std::vector<Mesh> meshes() {
  std::vector<Mesh> all;
  all.push_back(made("even", box_mesh({.cells = {9, 8, 10}}, waves), {0.0131, 0.7077, -1.1}, 0.2));
  all.push_back(made("jittered", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), {0.0131, 0.7077, -1.1}, 0.2));
  all.push_back(
      made("floats", box_mesh({.cells = {7, 9, 6}, .jitter = 0.14, .seed = 3}, waves, true), {0.0131, 0.7077}, 0.2));
  all.push_back(
      made("graded", box_mesh({.cells = {12, 12, 12}, .jitter = 0.1, .grading = 100}, waves), {0.0131, -0.5}, 0.4));
  all.push_back(made(
      "far away",
      box_mesh({.cells = {9, 9, 9}, .box = Box3(Vec3(1e6, -3e6, 2e6), Vec3(1e6, -3e6, 2e6) + Vec3(1)), .jitter = 0.1},
               [](const Vec3& p) { return 1e3 + waves(p - Vec3(1e6, -3e6, 2e6)); }),
      {1000.0131, 1000.6}, 0.2));
  all.push_back(made("large",
                     box_mesh({.cells = {9, 9, 9}, .box = Box3(Vec3(-4e8), Vec3(4e8)), .jitter = 0.1},
                              [](const Vec3& p) { return waves(p * 1e-9); }),
                     {0.0131, 0.6}, 2e8));
  all.push_back(made("plate", squeezed(box_mesh({.cells = {12, 12, 2}, .jitter = 0.1}, waves), 1e-4), {0.0131}, 0.2));
  all.push_back(made("values missing",
                     with_values(box_mesh({.cells = {9, 9, 9}, .jitter = 0.1}, waves),
                                 [](std::size_t p) { return p % 17 == 0 ? nan : infinity; }),
                     {0.0131, 0.6}, 0.2));
  all.push_back(made(
      "strewn",
      [] {
        auto mesh = strewn_mesh(4000, 0.06, 1, 5);
        add_point_field(mesh, "value", waves);
        return mesh;
      }(),
      {0.0131}, 0.2));
  return all;
}

/// Squares of 8 x 8 rays from points around and inside a box towards points in it, in the box's
/// frame.
std::vector<Ray> bundles(const Box3& box, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  const Vec3 size = box.size();
  while (rays.size() < count) {
    const Vec3 target = dice.point(box.min, box.max), towards = dice.direction();
    const double back = dice.between(0.1, 3) * size.length(), spread = dice.between(0.001, 0.3) * size.length();
    const Vec3 u = towards.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = towards.cross(u);
    const bool is_parallel = dice.below(4) == 0;
    const double speed = std::pow(10.0, dice.between(-3, 3));
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3 shift = spread * ((x - 3.5) / 4 * u + (y - 3.5) / 4 * v), eye = target - back * towards;
        rays.push_back({.origin = is_parallel ? eye + shift : eye,
                        .direction = speed * (is_parallel ? towards : (target + shift - eye).normalized())});
      }
  }
  return rays;
}

/// stressful_rays, moved into a box.
std::vector<Ray> stressful_rays_in(const Box3& box, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays = stressful_rays(Vec3(1), count, seed);
  const Vec3 size = box.size();
  for (Ray& ray : rays) ray.origin = box.min + ray.origin * size, ray.direction = ray.direction * size;
  return rays;
}

std::vector<Ray> all_rays(const Box3& box, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays = bundles(box, count, seed);
  for (const Ray& ray : stressful_rays_in(box, count, seed + 1)) rays.push_back(ray);
  return rays;
}

/// True for rays in a plane that bounds the mesh: either decision whether they are inside is
/// acceptable.
bool lies_in_border(const Ray& ray, const Box3& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const double off = std::min(std::abs(ray.origin[axis] - box.min[axis]), std::abs(ray.origin[axis] - box.max[axis]));
    if (std::abs(ray.direction[axis]) <= 1e-9 * ray.direction.length() && off <= 1e-9 * box.size()[axis]) return true;
  }
  return false;
}

struct Difference {
  int hits = 0, decisions = 0, cells = 0;
  double largest = 0, largest_in_cell = 0;  ///< distances of two hits, and of two in the same cell
};

Difference difference(const std::vector<Ray>& rays, const std::vector<Hit>& a, const std::vector<Hit>& b) {
  Difference found;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (a[r].is_miss() != b[r].is_miss()) ++found.decisions;
    if (a[r].is_miss() || b[r].is_miss()) continue;
    ++found.hits;
    const double distance = std::abs(a[r].t - b[r].t) * rays[r].direction.length();
    found.largest = std::max(found.largest, distance);
    if (a[r].cell == b[r].cell)
      found.largest_in_cell = std::max(found.largest_in_cell, distance);
    else
      ++found.cells;
  }
  return found;
}

TEST(WideFacets, agree_with_the_scalar_reference) {
  for (const Mesh& mesh : meshes())
    for (const double isovalue : mesh.isovalues) {
      std::vector<Ray> rays = bundles(mesh.box, 3000, 11);
      for (const Ray& ray : stressful_rays_in(mesh.box, 1500, 12))
        if ((ray.origin - mesh.box.center()).length() < 1e3 * mesh.box.size().length() &&
            !lies_in_border(ray, mesh.box))
          rays.push_back(ray);
      const std::vector<Hit> reference = answers(*mesh.traced, Method{}, Machine::scalar, rays, isovalue);
      for (const Machine machine : wide_machines()) {
        const Difference found = difference(rays, reference, answers(*mesh.traced, single, machine, rays, isovalue));
        const std::string where = mesh.name + ", " + name_of(machine) + ", isovalue " + std::to_string(isovalue);
        EXPECT_EQ(found.decisions, 0) << where;
        EXPECT_LE(found.largest, 1e-3 * mesh.cell_size) << where;
        EXPECT_LE(found.largest_in_cell, 1e-6 * mesh.cell_size) << where;
        EXPECT_LE(found.cells, found.hits / 300) << where;
        EXPECT_GT(found.hits, 200) << where;
      }
    }
}

TEST(WideFacets, of_a_ray_do_not_depend_on_the_rays_beside_it) {
  const Mesh mesh = made("", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), {}, 0.2);
  const std::vector<Ray> rays = all_rays(mesh.box, 1000, 21);
  std::vector<std::size_t> order(rays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937_64(23));
  std::vector<Ray> shuffled;
  for (const std::size_t r : order) shuffled.push_back(rays[r]);
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> together = answers(*mesh.traced, single, machine, rays, 0.0131),
                           apart = answers(*mesh.traced, single, machine, shuffled, 0.0131);
    for (std::size_t i = 0; i < order.size(); ++i) {
      ASSERT_TRUE(same_bits(together[order[i]], apart[i])) << name_of(machine) << ", ray " << order[i];
      const std::vector<Hit> alone = answers(*mesh.traced, single, machine, {shuffled[i]}, 0.0131);
      ASSERT_TRUE(same_bits(alone[0], apart[i])) << name_of(machine) << ", ray " << order[i];
    }
  }
}

/// Squares of 32 x 32 rays, 8 x 8 after 8 x 8 as in a tile: between the whole mesh and a hundredth
/// of it in one square.
std::vector<std::vector<Ray>> tiles(const Box3& box, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<std::vector<Ray>> all(count);
  const double size = box.size().length();
  for (std::vector<Ray>& rays : all) {
    const Vec3 target = dice.point(box.min, box.max), towards = dice.direction();
    const Vec3 u = towards.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = towards.cross(u);
    const Vec3 eye = target - dice.between(0.1, 3) * size * towards;
    const double spread = size * std::pow(10.0, dice.between(-2, 0));
    for (int block = 0; block < 16; ++block)
      for (int in_block = 0; in_block < 64; ++in_block) {
        const int x = block % 4 * 8 + in_block % 8, y = block / 4 * 8 + in_block / 8;
        rays.push_back(
            {.origin = eye, .direction = target + spread * ((x - 15.5) / 16 * u + (y - 15.5) / 16 * v) - eye});
      }
  }
  return all;
}

TEST(WideFacets, of_a_tile_are_those_of_its_blocks) {
  for (const Mesh& mesh : meshes())
    for (const Machine machine : wide_machines())
      for (const Method& method : {single, certified}) {
        std::uint64_t visits_together = 0, visits_apart = 0;
        for (const std::vector<Ray>& rays : tiles(mesh.box, 30, 31)) {
          const std::vector<Hit> together = answers(*mesh.traced, method, machine, rays, mesh.isovalues[0]);
          for (std::size_t first = 0; first < rays.size(); first += 64) {
            const auto begin = rays.begin() + static_cast<std::ptrdiff_t>(first);
            const std::vector<Hit> apart =
                answers(*mesh.traced, method, machine, {begin, begin + 64}, mesh.isovalues[0]);
            for (std::size_t r = 0; r < apart.size(); ++r) {
              Hit same = together[first + r];
              visits_together += same.cost, visits_apart += apart[r].cost;
              same.cost = apart[r].cost;
              ASSERT_TRUE(same_bits(same, apart[r])) << mesh.name << ", " << name_of(machine) << ", ray " << first + r;
            }
          }
        }
        // Nodes that many blocks hit are searched for all of them at once: otherwise the visits
        // would be equal.
        EXPECT_NE(visits_together, visits_apart) << mesh.name << ", " << name_of(machine);
      }
}

TEST(WideFacets, report_values_gradients_and_counts) {
  const Mesh mesh = made("", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), {}, 0.2);
  const std::vector<Ray> rays = bundles(mesh.box, 2000, 31);
  const std::vector<Hit> reference = answers(*mesh.traced, Method{}, Machine::scalar, rays, 0.0131);
  for (const Machine machine : wide_machines()) {
    mesh.traced->scratch.counters = {};
    const std::vector<Hit> wide = answers(*mesh.traced, single, machine, rays, 0.0131);
    const render::KernelCounters counters = mesh.traced->scratch.counters;
    EXPECT_EQ(counters.rays_wide, rays.size());
    EXPECT_GT(counters.cells_solved, 0U);
    std::uint64_t cost = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) {
      cost += wide[r].cost;
      if (wide[r].is_miss() || wide[r].cell != reference[r].cell) continue;
      EXPECT_EQ(wide[r].value, 0.0131);
      EXPECT_EQ(wide[r].root_count, 1U);
      EXPECT_EQ(wide[r].gradient, reference[r].gradient);
    }
    EXPECT_EQ(cost, counters.visits()) << name_of(machine);
  }
}

/// Every ray that starts outside a closed surface and aims at a point inside it hits the surface.
/// Most of them aim at vertices and edges of facets.
TEST(WideFacets, of_closed_surfaces_are_met_by_every_ray_aimed_inside) {
  for (const bool has_steps : {false, true}) {
    const auto ball = [&](const Vec3& p) {
      const double value = 0.3 - (p - Vec3(0.5)).length() + 0.02 * std::sin(40 * p.x) * std::sin(40 * p.y);
      return has_steps ? std::round(value * 16) / 16 : value;
    };
    const auto mesh = box_mesh({.cells = {14, 14, 14}, .jitter = 0.12, .seed = 7}, ball);
    TracedDataset traced(mesh);
    const render::LoadedDataset& dataset = traced.dataset().implementation();
    Dice dice(8);
    std::vector<Ray> rays;
    while (rays.size() < 20000) {  // towards edges, as if from inside: the ray on the other side
      const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
      const auto a = static_cast<std::size_t>(dice.below(4)), b = (a + 1 + static_cast<std::size_t>(dice.below(3))) % 4;
      const auto& values = mesh.point_fields[0].values;
      if (values[cell[a]] >= 0 || values[cell[b]] < 0) continue;
      const double s = values[cell[a]] / (values[cell[a]] - values[cell[b]]);
      const Vec3 corner =
          to_vec3(mesh.points[cell[a]]) + s * (to_vec3(mesh.points[cell[b]]) - to_vec3(mesh.points[cell[a]]));
      const Vec3 inside = Vec3(0.5) + 0.05 * dice.direction();
      const Vec3 away = (corner - inside).normalized();
      Ray ray{.origin = corner + 0.9 * away, .direction = -away};
      rays.push_back({.origin = ray.origin - dataset.world_from_data.origin, .direction = ray.direction});
    }
    for (const Machine machine : wide_machines())
      for (const Method& method : {single, certified}) {
        int missed = 0;
        // Certified uses exact arithmetic for most of these.
        const std::vector<Ray> asked(rays.begin(), rays.begin() + (method == certified ? 300 : 20000));
        for (const Hit& hit : answers(traced, method, machine, asked, 0)) missed += hit.is_miss();
        EXPECT_EQ(missed, 0) << name_of(machine) << (has_steps ? ", steps" : "");
      }
  }
}

TEST(WideFacets, certified_decide_as_the_judge_and_keep_their_bounds) {
  std::uint64_t rays_asked = 0, rays_redone = 0, hard_rays_redone = 0;
  std::vector<Mesh> all = meshes();
  const auto whole = [](const Vec3& p) { return std::round(4 * waves(p)); };
  all.push_back(made("whole values", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, whole), {0}, 0.2));
  all.push_back(made("whole values on a lattice", box_mesh({.cells = {6, 6, 6}}, whole), {1}, 0.2));
  for (const Mesh& mesh : all) {
    if (mesh.name == "strewn") continue;  // its cells are not a partition
    const std::vector<Ray> coherent = bundles(mesh.box, 256, 81), stressful = stressful_rays_in(mesh.box, 128, 82);
    for (const double isovalue : mesh.isovalues)
      for (const bool is_coherent : {true, false}) {
        const std::vector<Ray>& rays = is_coherent ? coherent : stressful;
        const std::vector<Hit> truth = answers(*mesh.traced, judged, Machine::scalar, rays, isovalue);
        for (const Machine machine : wide_machines()) {
          mesh.traced->scratch.counters = {};
          const std::vector<Hit> wide = answers(*mesh.traced, certified, machine, rays, isovalue);
          if (is_coherent && mesh.isovalues.size() > 1) {
            rays_asked += rays.size();
            rays_redone += mesh.traced->scratch.counters.rays_redone;
          } else {
            hard_rays_redone += mesh.traced->scratch.counters.rays_redone;
          }
          for (std::size_t r = 0; r < rays.size(); ++r) {
            const std::string where = mesh.name + ", " + name_of(machine) + ", ray " + std::to_string(r);
            ASSERT_EQ(wide[r].is_miss(), truth[r].is_miss()) << where;
            if (truth[r].is_miss()) continue;
            ASSERT_LE(std::abs(wide[r].t - truth[r].t), wide[r].error + truth[r].error) << where;
            EXPECT_LE(wide[r].error * rays[r].direction.length(), 3e-3 * mesh.cell_size) << where;
          }
        }
      }
  }
  EXPECT_LT(rays_redone, rays_asked / 100);
  EXPECT_GT(hard_rays_redone, 0U);
}

TEST(WideFacets, leave_rays_without_numbers_and_meshes_beyond_measure_to_the_reference) {
  const Mesh mesh = made("", box_mesh({.cells = {4, 4, 4}, .jitter = 0.1}, waves), {}, 0.2);
  std::vector<Ray> rays = bundles(mesh.box, 64, 51);
  rays[3].direction = {0, 0, 0};
  rays[5].t_min = 3, rays[5].t_max = 2;
  rays[7].origin.x = 1e200;
  const std::vector<Hit> reference = answers(*mesh.traced, single, Machine::scalar, rays, 0.0131);
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> wide = answers(*mesh.traced, single, machine, rays, 0.0131);
    for (std::size_t r = 0; r < rays.size(); ++r) EXPECT_EQ(wide[r].is_miss(), reference[r].is_miss()) << r;
  }
  TracedDataset steep(box_mesh({.cells = {3, 3, 3}}, [](const Vec3& p) { return 1e200 * (p.x + p.y); }));
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> scalar = answers(steep, single, Machine::scalar, rays, 0.7e200),
                           wide = answers(steep, single, machine, rays, 0.7e200);
    for (std::size_t r = 0; r < rays.size(); ++r) ASSERT_TRUE(same_bits(wide[r], scalar[r]));
  }
}

TEST(WideFacets, are_those_of_the_isovalue_that_is_asked_for) {
  const Mesh mesh = made("", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), {}, 0.2);
  const std::vector<Ray> rays = bundles(mesh.box, 500, 61);
  for (int round = 0; round < 2; ++round)  // more isovalues than are cached, and back to each
    for (int k = 0; k < 7; ++k) {
      const double isovalue = -0.9 + 0.31 * k;
      const std::vector<Hit> reference = answers(*mesh.traced, Method{}, Machine::scalar, rays, isovalue);
      EXPECT_EQ(
          difference(rays, reference, answers(*mesh.traced, single, wide_machines().back(), rays, isovalue)).decisions,
          0);
    }
}

TEST(WideFacets, of_an_isovalue_beyond_all_values_are_none) {
  const Mesh mesh = made("", box_mesh({.cells = {4, 4, 4}}, waves), {}, 0.2);
  const std::vector<Ray> rays = bundles(mesh.box, 500, 71);
  for (const double isovalue : {-5.0, 5.0, 1e100, -1e100})
    for (const Machine machine : wide_machines())
      for (const Method& method : {single, certified})
        for (const Hit& hit : answers(*mesh.traced, method, machine, rays, isovalue)) EXPECT_TRUE(hit.is_miss());
}

TEST(WideFacets, are_the_same_bits_for_any_number_of_threads) {
  const Mesh mesh = made("", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), {}, 0.2);
  const std::vector<Ray> rays = bundles(mesh.box, 8000, 91);
  for (const Method& method : {single, certified}) {
    std::vector<Hit> first;
    for (const unsigned threads : {1U, 2U, 5U}) {
      std::vector<Hit> hits(rays.size());
      render::RayCaster(mesh.traced->dataset(), 0.0131, method, threads).first_crossings(rays, hits);
      if (first.empty()) first = hits;
      for (std::size_t r = 0; r < rays.size(); ++r) ASSERT_TRUE(same_bits(first[r], hits[r]));
    }
  }
}

}  // namespace
}  // namespace rhoray::tests
