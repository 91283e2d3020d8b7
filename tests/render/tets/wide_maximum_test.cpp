#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "render/method.h"
#include "render/query/intersectors.h"
#include "render/tets/largest/maximum.h"
#include "tests/render/support/allocation_count.h"
#include "tests/render/support/ask.h"
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

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Answers {
  std::vector<Hit> hits;
  render::KernelCounters counters;
};

/// Rays in the data's frame.
Answers largest_values(const TracedDataset& traced, const Method& method, Machine machine,
                       const std::vector<Ray>& rays) {
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const render::Intersectors kernels = render::choose_intersectors(dataset, {.method = method}, machine);
  render::KernelScratch scratch;
  scratch.queue.reserve(kernels.queue_entries);
  Answers answers{std::vector<Hit>(rays.size()), {}};
  ask(kernels.largest, dataset, {.field_range = traced.dataset().field().range, .method = method}, rays, answers.hits,
      scratch);
  answers.counters = scratch.counters;
  return answers;
}

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z) + 0.3 * std::sin(23 * p.z + 11 * p.x);
}

/// Rays that pass exactly through parts of cells: from points and middles of edges and faces to
/// others, and beyond.
void add_rays_between_points(std::vector<Ray>& rays, const preprocess::NeutralMesh& mesh, const Vec3& origin,
                             std::size_t count, Dice& dice) {
  const auto place = [&] {
    const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
    const auto corners = 1 + dice.below(3);
    Vec3 sum(0);
    for (std::int64_t c = 0; c < corners; ++c) sum += to_vec3(mesh.points[cell[static_cast<std::size_t>(c)]]);
    return sum / static_cast<double>(corners) - origin;
  };
  for (std::size_t r = 0; r < count; ++r) {
    const Vec3 from = place(), towards = place() - from;
    if (towards == Vec3(0)) continue;
    rays.push_back({.origin = from - static_cast<double>(dice.below(3)) * towards, .direction = towards});
  }
}

/// Squares of 8 x 8 rays through a box; rays that graze and miss; rays through points, edges and
/// faces; rays that end inside. Their number does not fill the last group.
std::vector<Ray> rays_through(const Box3& box, const preprocess::NeutralMesh& mesh, const Vec3& origin,
                              std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  const Vec3 size = box.size();
  while (rays.size() < count) {
    const Vec3 target = dice.point(box.min, box.max);
    Vec3 towards = dice.direction();
    if (dice.below(5) == 0) {
      const int axis = static_cast<int>(dice.below(3));
      towards = Vec3(0);
      towards[axis] = dice.coin() ? 1 : -1;
    }
    const double back = dice.between(0, 2) * size.length(), spread = dice.between(0.001, 0.5) * size.length();
    const Vec3 u = towards.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = towards.cross(u);
    const bool is_parallel = dice.below(4) == 0, is_cut = dice.below(4) == 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3 shift = spread * ((x - 3.5) / 4 * u + (y - 3.5) / 4 * v), eye = target - back * towards;
        Ray ray{.origin = is_parallel ? eye + shift : eye,
                .direction = is_parallel ? towards : (target + shift - eye).normalized()};
        if (is_cut) {
          ray.t_min = dice.between(-0.5, 1.5) * size.length();
          ray.t_max = ray.t_min + dice.between(-0.1, 0.8) * size.length();
        }
        rays.push_back(ray);
      }
  }
  for (Ray ray : stressful_rays(Vec3(4), count / 3, seed + 1)) {
    ray.origin = box.min + ray.origin / 4 * size, ray.direction = ray.direction / 4 * size;
    rays.push_back(ray);
  }
  add_rays_between_points(rays, mesh, origin, count / 3, dice);
  rays.push_back({.origin = box.center(), .direction = {nan, 1, 0}});
  rays.push_back({.origin = {infinity, 0, 0}, .direction = {-1, 0, 0}});
  rays.push_back({.origin = box.min - 1e15 * size, .direction = size});
  rays.push_back({.origin = box.min - 1e9 * size, .direction = 1e-300 * size});
  return rays;
}

void expect_same(const std::vector<Hit>& wide, const std::vector<Hit>& reference, const std::vector<Ray>& rays,
                 const std::string& where) {
  int different = 0;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const Hit &a = wide[r], &b = reference[r];
    if (same_bits(a, b) || ++different > 3) continue;
    ADD_FAILURE() << where << ", ray " << r << " from " << rays[r].origin << " along " << rays[r].direction << ": t "
                  << a.t << " instead of " << b.t << ", value " << a.value << " instead of " << b.value << ", cell "
                  << a.cell << " instead of " << b.cell;
  }
  EXPECT_EQ(different, 0) << where;
}

/// Expects the scalar kernel's result on every machine; returns the number of rays that hit.
int expect_agreement(const std::string& name, const preprocess::NeutralMesh& mesh, std::size_t count,
                     const preprocess::PackMeshOptions& options = {}) {
  const TracedDataset traced(mesh, options);
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const std::vector<Ray> rays =
      rays_through(dataset.bounds_data, mesh, dataset.world_from_data.point(Vec3(0)), count, 17 + mesh.cells.size());
  const Answers reference = largest_values(traced, Method{}, Machine::scalar, rays);
  EXPECT_EQ(reference.counters.rays_wide, 0U);
  for (const Machine machine : wide_machines()) {
    const Answers wide = largest_values(traced, Method{}, machine, rays);
    expect_same(wide.hits, reference.hits, rays, name + ", " + name_of(machine));
    EXPECT_GT(wide.counters.rays_wide, rays.size() * 9 / 10) << name;
  }
  return static_cast<int>(
      std::count_if(reference.hits.begin(), reference.hits.end(), [](const Hit& hit) { return !hit.is_miss(); }));
}

preprocess::NeutralMesh squeezed(preprocess::NeutralMesh mesh, double factor) {
  for (auto& point : mesh.points) point[2] *= factor;
  return mesh;
}

TEST(WideTetMaximum, is_the_scalar_kernels_in_meshes_of_many_shapes) {
  int hits = 0;
  hits += expect_agreement("even", box_mesh({.cells = {9, 8, 10}}, waves), 1500);
  hits += expect_agreement("jittered", box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves), 1500);
  hits += expect_agreement("floats", box_mesh({.cells = {7, 9, 6}, .jitter = 0.14, .seed = 3}, waves, true), 1500);
  hits += expect_agreement("graded", box_mesh({.cells = {12, 12, 12}, .jitter = 0.1, .grading = 1e4}, waves), 1000);
  const Vec3 far(1e6, -3e6, 2e6);
  hits += expect_agreement("far away",
                           box_mesh({.cells = {9, 9, 9}, .box = Box3(far, far + Vec3(1)), .jitter = 0.1},
                                    [&](const Vec3& p) { return waves(p - far); }),
                           1000);
  hits += expect_agreement("large",
                           box_mesh({.cells = {9, 9, 9}, .box = Box3(Vec3(-4e8), Vec3(4e8)), .jitter = 0.1},
                                    [](const Vec3& p) { return waves(p * 1e-9); }),
                           1000);
  hits += expect_agreement("plate", squeezed(box_mesh({.cells = {12, 12, 2}, .jitter = 0.1}, waves), 1e-4), 1000);
  hits += expect_agreement("flat cells", squeezed(box_mesh({.cells = {8, 8, 2}}, waves), 1e-9), 600);
  hits += expect_agreement(
      "strewn",
      [] {
        auto mesh = strewn_mesh(4000, 0.06, 1, 5);
        add_point_field(mesh, "value", waves);
        return mesh;
      }(),
      1000);
  EXPECT_GT(hits, 8000);
}

TEST(WideTetMaximum, is_the_scalar_kernels_in_fields_of_many_kinds) {
  int hits = 0;
  const auto of = [&](const std::string& name, const Field& field, std::size_t count = 700) {
    hits += expect_agreement(name, box_mesh({.cells = {8, 8, 8}, .jitter = 0.1}, field), count);
  };
  of(
      "constant", [](const Vec3&) { return 3.3; }, 300);
  of(
      "zero", [](const Vec3&) { return 0.0; }, 300);
  of("steps", [](const Vec3& p) { return std::floor(3 * p.x) + std::floor(3 * p.z); });
  of("plateau", [](const Vec3& p) { return std::min(waves(p), 0.3); });
  of("negative", [](const Vec3& p) { return -1000 + waves(p); });
  of("offset", [](const Vec3& p) { return 1e14 + waves(p); });
  of("tiny", [](const Vec3& p) { return 1e-300 * waves(p); });
  of("below normal numbers", [](const Vec3& p) { return 1e-312 * waves(p); });
  of("huge", [](const Vec3& p) { return 1e59 * waves(p); });
  of("one peak", [](const Vec3& p) { return (p - Vec3(0.5)).length() < 0.05 ? 1e30 : waves(p); });
  of("values missing", [](const Vec3& p) { return std::sin(100 * p.x + 77 * p.y + 55 * p.z) > 0.7 ? nan : waves(p); });
  of("infinite values", [](const Vec3& p) { return std::sin(100 * p.x + 77 * p.y) > 0.8 ? infinity : waves(p); });
  of("noise", [](const Vec3& p) { return std::sin(1e4 * p.x) * std::cos(1e4 * p.y + 3e3 * p.z); });
  EXPECT_GT(hits, 5000);
}

TEST(WideTetMaximum, is_the_scalar_kernels_in_clusters_of_any_size) {
  const auto mesh = box_mesh({.cells = {14, 14, 14}, .jitter = 0.1}, waves);
  for (const std::uint64_t size : {1, 2, 8, 16, 32})
    EXPECT_GT(expect_agreement("clusters of " + std::to_string(size), mesh, 500, {.cluster_size = size}), 200);
}

TEST(WideTetMaximum, tells_the_cell_of_the_smallest_id_of_those_that_share_it) {
  auto mesh = box_mesh({.cells = {5, 5, 5}}, [](const Vec3& p) { return std::floor(4 * p.x); });
  for (std::uint64_t c = 0; c < mesh.cells.size(); ++c) mesh.cell_ids.push_back((c * 7919 + 13) % 400 / 2);
  EXPECT_GT(expect_agreement("ids", mesh, 1000), 500);
}

/// Exact arithmetic shares no code with either kernel.
TEST(WideTetMaximum, is_the_judges_to_rounding) {
  const auto mesh = box_mesh({.cells = {6, 5, 7}, .jitter = 0.14}, waves);
  const TracedDataset traced(mesh);
  Dice dice(5);
  std::vector<Ray> rays;
  while (rays.size() < 150) {
    const Vec3 direction = dice.direction();
    rays.push_back({.origin = dice.point({0, 0, 0}, {1, 1, 1}) -
                              traced.dataset().implementation().world_from_data.point(Vec3(0)) -
                              dice.between(0, 3) * direction,
                    .direction = direction});
  }
  const std::vector<Hit> judged =
      largest_values(traced, render::method_of(render::Accuracy::exact), Machine::scalar, rays).hits;
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> wide = largest_values(traced, Method{}, machine, rays).hits;
    for (std::size_t r = 0; r < rays.size(); ++r) {
      ASSERT_EQ(wide[r].is_miss(), judged[r].is_miss()) << r;
      if (judged[r].is_miss()) continue;
      EXPECT_NEAR(wide[r].value, judged[r].value, 1e-12) << name_of(machine) << ", ray " << r;
    }
  }
}

TEST(WideTetMaximum, of_a_ray_does_not_depend_on_the_rays_beside_it) {
  const auto mesh = box_mesh({.cells = {9, 8, 10}, .jitter = 0.14}, waves);
  const TracedDataset traced(mesh);
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  std::vector<Ray> rays = rays_through(dataset.bounds_data, mesh, dataset.world_from_data.point(Vec3(0)), 1000, 29);
  std::shuffle(rays.begin(), rays.end(), std::mt19937_64(23));
  const std::vector<Hit> reference = largest_values(traced, Method{}, Machine::scalar, rays).hits;
  for (const Machine machine : wide_machines()) {
    expect_same(largest_values(traced, Method{}, machine, rays).hits, reference, rays, name_of(machine));
    for (std::size_t r = 0; r < 100; ++r)
      ASSERT_TRUE(same_bits(largest_values(traced, Method{}, machine, {rays[r]}).hits[0], reference[r])) << r;
  }
}

TEST(WideTetMaximum, leaves_lists_and_other_ways_to_the_scalar_kernels) {
  const auto mesh = box_mesh({.cells = {4, 4, 4}}, waves);
  const TracedDataset clusters(mesh), lists(mesh, {.structure = preprocess::MeshStructure::leaves});
  const auto kernel = [](const TracedDataset& traced, const Method& method, Machine machine) {
    return render::wide::largest_value_in_tets_kernel(traced.dataset().implementation(), method, machine);
  };
  for (const Machine machine : wide_machines()) {
    EXPECT_NE(kernel(clusters, {}, machine), nullptr);
    EXPECT_EQ(kernel(lists, {}, machine), nullptr);
    for (const render::Accuracy accuracy : {render::Accuracy::certified, render::Accuracy::exact})
      EXPECT_EQ(kernel(clusters, render::method_of(accuracy), machine), nullptr);
    EXPECT_EQ(kernel(clusters, {.algorithm = Method::Algorithm::sampled}, machine), nullptr);
  }
  EXPECT_EQ(kernel(clusters, {}, Machine::scalar), nullptr);
}

TEST(WideTetMaximum, counts_what_each_ray_costs_and_allocates_nothing_for_it) {
  const auto mesh = box_mesh({.cells = {12, 12, 12}, .jitter = 0.1}, waves);
  const TracedDataset traced(mesh);
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const std::vector<Ray> rays =
      rays_through(dataset.bounds_data, mesh, dataset.world_from_data.point(Vec3(0)), 1500, 31);
  for (const Machine machine : wide_machines()) {
    const render::Intersectors kernels = render::choose_intersectors(dataset, {}, machine);
    render::KernelScratch scratch;
    render::RayBatch asked(rays.size());
    render::HitBatch answered(rays.size());
    asked.count = rays.size();
    for (std::size_t r = 0; r < rays.size(); ++r) asked.set(r, rays[r]);
    kernels.largest(dataset, {}, asked, answered, scratch);
    std::uint64_t cost = 0;
    for (std::size_t r = 0; r < rays.size(); ++r) cost += answered[r].cost;
    EXPECT_EQ(cost, scratch.counters.visits());
    EXPECT_GT(cost, 0U);
    const std::size_t before = allocation_count();
    kernels.largest(dataset, {}, asked, answered, scratch);
    EXPECT_EQ(allocation_count(), before);
  }
}

}  // namespace
}  // namespace rhoray::tests
