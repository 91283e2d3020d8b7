#include "render/shade/hit_lookup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "render/triangles/point_gradients.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/expect_error.h"
#include "tests/support/fields.h"
#include "tests/support/made_grid.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Accuracy;
using render::HitAttributes;
using render::HitLookup;
using render::Machine;

constexpr std::size_t group_size = render::RayBatch::group_size;

double waves(const Vec3& p) {
  return std::sin(7 * p.x + 1) + std::sin(9 * p.y) * std::cos(6 * p.z);
}

/// Rays, their first crossings, and what was looked up at these.
struct Answers {
  render::RayBatch rays;
  render::HitBatch hits;
  std::vector<double> values;

  explicit Answers(std::size_t count) : rays(count), hits(count), values(count, -1) { rays.count = count; }
};

/// @param rays  in the data's frame; whole groups
Answers answered(const render::Dataset& volume, const std::vector<render::Ray>& rays, double isovalue,
                 const render::Method& method, const HitAttributes& attributes,
                 Machine machine = render::chosen_machine()) {
  Answers answers(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) answers.rays.set(r, rays[r]);
  const render::LoadedDataset& implementation = volume.implementation();
  render::KernelScratch scratch;
  render::choose_intersectors(implementation, {.method = method})
      .first_hit(implementation, {.isovalue = isovalue, .method = method}, answers.rays, answers.hits, scratch);
  const HitLookup lookup(implementation, attributes, 1, machine);
  for (std::size_t first = 0; first < rays.size(); first += group_size)
    lookup(answers.rays, answers.hits, first, answers.values.data() + first);
  return answers;
}

std::vector<render::Ray> rays_through(const Box3& box, std::size_t count) {
  Dice dice(20261121);
  std::vector<render::Ray> rays;
  for (std::size_t r = 0; r < count; ++r) {
    const auto inside = [&] {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = dice.between(box.min[axis], box.max[axis]);
      return p;
    };
    const Vec3 to = inside(), direction = dice.direction();
    rays.push_back({.origin = to - 3 * box.size().length() * direction, .direction = direction});
  }
  return rays;
}

const std::vector<render::Method>& levels() {
  static const std::vector<render::Method> all{method_of(Accuracy::float32), method_of(Accuracy::float64),
                                               method_of(Accuracy::certified), method_of(Accuracy::exact)};
  return all;
}

/// Calls act(r, place) for every hit, with its position in the data's frame; expects at least
/// `least` hits.
template <class Act>
void for_each_hit(const Answers& answers, std::size_t least, const Act& act) {
  std::size_t count = 0;
  for (std::size_t r = 0; r < answers.rays.count; ++r) {
    const render::Hit hit = answers.hits[r];
    if (hit.is_miss()) continue;
    const render::Ray ray = answers.rays[r];
    act(r, ray.origin + hit.t * ray.direction);
    ++count;
  }
  EXPECT_GE(count, least);
}

preprocess::NeutralMesh mesh_of(const BoxMesh& box, const Field& shown, const Field& other) {
  auto mesh = box_mesh(box, shown);
  add_point_field(mesh, "other", other);
  add_point_field(mesh, "other in single precision", other, true);
  return mesh;
}

TEST(HitLookup, names_the_tetrahedron_that_was_hit_at_every_level) {
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    TracedDataset traced(box_mesh({.cells = {7, 8, 6}, .jitter = 0.12}, waves), {.structure = structure});
    const auto& implementation = traced.dataset().implementation();
    const auto& view = std::get<render::TetData>(implementation.view);
    const auto rays = rays_through(implementation.bounds_data, 256);
    auto methods = levels();
    methods.push_back({.algorithm = render::Method::Algorithm::sampled, .step = 0.05, .bisect = true});
    methods.push_back({.algorithm = render::Method::Algorithm::slack, .slack = 1e-9});
    for (const render::Method& method : methods) {
      const Answers answers = answered(traced.dataset(), rays, 0.3, method, {.smooth_gradients = true, .field = {}});
      for_each_hit(answers, 100, [&](std::size_t r, const Vec3&) {
        EXPECT_EQ(view.cell_id(answers.hits[r].tet), answers.hits[r].cell);
      });
    }
  }
}

TEST(HitLookup, of_a_linear_field_says_the_fields_own_gradient_and_values_at_every_level) {
  const Vec3 slope(0.3, -0.7, 0.5);
  const Field other = linear_field({2, 1, -3}, 4);
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    TracedDataset traced(mesh_of({.cells = {7, 8, 6}, .jitter = 0.12}, linear_field(slope, 2), other),
                         {.structure = structure});
    const auto& implementation = traced.dataset().implementation();
    const Affine& world = implementation.world_from_data;
    const auto rays = rays_through(implementation.bounds_data, 256);
    for (const render::Method& method : levels()) {
      // In that case t itself may have that error; the value is the one on the surface.
      const bool is_float = method.precision == render::Method::Precision::float32 ||
                            method.algorithm == render::Method::Algorithm::certified;
      const Answers own = answered(traced.dataset(), rays, 2.05, method, {.smooth_gradients = true, .field = "value"});
      for_each_hit(own, 60, [&](std::size_t r, const Vec3&) {
        EXPECT_NEAR(own.values[r], 2.05, 1e-15 * 8);
        EXPECT_LT((own.hits[r].gradient - slope).length(), 1e-12);
      });
      for (const auto& [name, tolerance] : {std::pair("other", 1e-12), {"other in single precision", 1e-6}}) {
        const Answers answers =
            answered(traced.dataset(), rays, 2.05, method, {.smooth_gradients = false, .field = name});
        for_each_hit(answers, 60, [&, allowed = is_float ? 1e-6 : tolerance](std::size_t r, const Vec3& place) {
          EXPECT_NEAR(answers.values[r], other(world.point(place)), allowed);
        });
      }
    }
  }
}

// Also in slivers and in cells without volume, whose weights by volume are mere rounding or
// undefined.
TEST(HitLookup, of_the_own_field_is_the_value_of_the_hit_to_rounding_in_cells_of_any_shape) {
  for (const double flatness : {1.0, 1e-6, 1e-12, 1e-16, 0.0}) {
    preprocess::NeutralMesh mesh = strewn_mesh(200, 0.3, flatness, 7);
    add_point_field(mesh, "value", waves);
    add_point_field(mesh, "x", [](const Vec3& p) { return p.x; });
    TracedDataset traced(mesh);
    const auto& implementation = traced.dataset().implementation();
    const auto& view = std::get<render::TetData>(implementation.view);
    const auto rays = rays_through(implementation.bounds_data, 1024);
    for (const render::Method& method : levels()) {
      const Answers own = answered(traced.dataset(), rays, 0.3, method, {.smooth_gradients = false, .field = "value"});
      for_each_hit(own, 30, [&](std::size_t r, const Vec3&) { EXPECT_NEAR(own.values[r], 0.3, 1e-15); });
      const Answers other = answered(traced.dataset(), rays, 0.3, method, {.smooth_gradients = false, .field = "x"});
      for_each_hit(other, 30, [&](std::size_t r, const Vec3&) {
        double low = 1e9, high = -1e9;
        for (const auto& p : view.points_at(view.vertices(other.hits[r].tet)))
          low = std::min(low, p[0]), high = std::max(high, p[0]);
        const double origin = implementation.world_from_data.origin.x;
        EXPECT_GE(other.values[r], low + origin - 1e-12);
        EXPECT_LE(other.values[r], high + origin + 1e-12);
      });
    }
  }
}

/// The largest error of a field's gradient at hits, as a share of the largest gradient.
struct GradientErrors {
  double flat = 0, smooth = 0;
};
GradientErrors gradient_errors(std::int64_t cells) {
  const Field bowl = [](const Vec3& p) { return p.x * p.x + 2 * p.y * p.y - p.z * p.z + p.x * p.z; };
  TracedDataset traced(box_mesh({.cells = {cells, cells, cells}, .box = Box3({-1, -1, -1}, {1, 1, 1})}, bowl));
  const auto& implementation = traced.dataset().implementation();
  const auto rays = rays_through(implementation.bounds_data, 2048);
  const auto answers = [&](bool smooth) {
    return answered(traced.dataset(), rays, 0.4, render::Method{}, {.smooth_gradients = smooth, .field = "value"});
  };
  const Answers flat = answers(false), smooth = answers(true);
  GradientErrors errors;
  for_each_hit(flat, 500, [&](std::size_t r, const Vec3& place) {
    const Vec3 p = implementation.world_from_data.point(place);
    // At points of the border only one side contributes.
    if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > 0.7) return;
    const Vec3 exact(2 * p.x + p.z, 4 * p.y, -2 * p.z + p.x);
    errors.flat = std::max(errors.flat, (flat.hits[r].gradient - exact).length());
    errors.smooth = std::max(errors.smooth, (smooth.hits[r].gradient - exact).length());
  });
  return errors;
}

// Around a point inside this mesh the cells are symmetric, so the mean of a quadratic field's
// gradients is exact there. Between the points it is linear, as the gradient is.
TEST(SmoothGradients, of_a_quadratic_field_converge_where_those_of_cells_converge_slowly) {
  const GradientErrors coarse = gradient_errors(8), fine = gradient_errors(16);
  EXPECT_GT(fine.flat, 0.1);
  EXPECT_LT(fine.flat, 0.7 * coarse.flat);
  EXPECT_LT(coarse.smooth, 1e-12);
  EXPECT_LT(fine.smooth, 1e-12);
}

/// Two rays so close that they hit on both sides of a face, between two rays that hit different
/// cells. False when there is no face between them but an outline.
bool straddle_face(TracedDataset& traced, double isovalue, render::Ray& left, render::Ray& right) {
  const render::LoadedDataset& volume = traced.dataset().implementation();
  const render::Kernel kernel = render::choose_intersectors(volume, {}).first_hit;
  const auto hit_of = [&](const render::Ray& ray) {
    render::Hit hit;
    ask(kernel, volume, {.isovalue = isovalue}, std::span(&ray, 1), std::span(&hit, 1), traced.scratch);
    return hit;
  };
  const std::uint32_t tet = hit_of(left).tet;
  for (int k = 0; k < 40; ++k) {
    render::Ray middle = left;
    middle.origin = 0.5 * (left.origin + right.origin);
    const render::Hit hit = hit_of(middle);
    if (hit.is_miss()) return false;
    (hit.tet == tet ? left : right) = middle;
  }
  const render::Hit a = hit_of(left), b = hit_of(right);
  return a.tet != b.tet && std::abs(a.t - b.t) < 1e-9;
}

TEST(SmoothGradients, on_both_sides_of_a_face_are_the_same_where_those_of_cells_are_not) {
  TracedDataset traced(box_mesh({.cells = {7, 8, 6}, .jitter = 0.12}, waves));
  const auto& implementation = traced.dataset().implementation();
  const auto rays = rays_through(implementation.bounds_data, 128);
  std::vector<render::Ray> beside = rays, pairs;
  for (render::Ray& ray : beside) ray.origin.x += 0.03;
  const auto answers = [&](const std::vector<render::Ray>& of, bool smooth) {
    return answered(traced.dataset(), of, 0.3, render::Method{}, {.smooth_gradients = smooth, .field = "value"});
  };
  const Answers left = answers(rays, false), right = answers(beside, false);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    if (left.hits[r].is_miss() || right.hits[r].is_miss() || left.hits[r].tet == right.hits[r].tet) continue;
    render::Ray a = rays[r], b = beside[r];
    if (straddle_face(traced, 0.3, a, b)) pairs.insert(pairs.end(), {a, b});
  }
  const std::size_t straddling = pairs.size() / 2;
  EXPECT_GT(straddling, 20U);
  pairs.resize((pairs.size() + group_size - 1) / group_size * group_size, rays[0]);
  const Answers flat = answers(pairs, false), smooth = answers(pairs, true);
  std::size_t jumps = 0;
  for (std::size_t r = 0; r < 2 * straddling; r += 2) {
    EXPECT_LT((smooth.hits[r].gradient - smooth.hits[r + 1].gradient).length(), 1e-9);
    jumps += (flat.hits[r].gradient - flat.hits[r + 1].gradient).length() > 1e-3;
  }
  // On the border y = 0 the field depends on x alone and is the same on both sides of some faces.
  EXPECT_GT(10 * jumps, 9 * straddling);
}

TEST(SmoothGradients, are_left_out_where_they_say_nothing) {
  // A cell without volume that no other cell touches: there is no gradient at its points.
  preprocess::NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}};
  mesh.cells = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  add_point_field(mesh, "value", [](const Vec3& p) { return p.x; });
  TracedDataset traced(mesh);
  const auto& view = std::get<render::TetData>(traced.dataset().implementation().view);
  std::uint32_t flat = 0;
  while (view.cell_id(flat) != 0) ++flat;
  const render::PointGradients gradients(view, 1);
  for (const std::uint32_t v : view.vertices(flat)) EXPECT_EQ(gradients.of_points()[v], (std::array<double, 3>{}));
  render::RayBatch rays(1);
  render::HitBatch hits(1);
  double values[group_size];
  for (std::size_t i = 0; i < group_size; ++i) {
    rays.set(i, {.origin = {0.5, 0.4, -1}, .direction = {0, 0, 1}});
    hits.set(i, {.t = 1, .value = 0.5, .tet = flat, .gradient = {1, 2, 3}});
  }
  HitLookup(traced.dataset().implementation(), {.smooth_gradients = true, .field = {}}, 1)(rays, hits, 0, values);
  EXPECT_EQ(hits[0].gradient, Vec3(1, 2, 3));
}

TEST(PointGradients, are_the_same_bits_for_any_number_of_threads) {
  TracedDataset traced(box_mesh({.cells = {40, 40, 40}, .jitter = 0.12}, waves));
  const auto& view = std::get<render::TetData>(traced.dataset().implementation().view);
  const render::PointGradients one(view, 1), many(view, 4);
  const auto a = one.of_points(), b = many.of_points();
  ASSERT_EQ(a.size(), 41U * 41 * 41);
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
}

TEST(PointGradients, are_not_kept_if_their_computation_was_stopped) {
  std::stop_source stop;
  stop.request_stop();
  TracedDataset traced(box_mesh({.cells = {9, 8, 7}}, waves));
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  const auto& view = std::get<render::TetData>(dataset.view);
  for (const unsigned threads : {1U, 4U})
    expect_error(ErrorCode::interrupted, "interrupted", [&] {
      HitLookup(dataset, {.smooth_gradients = true, .field = {}}, threads, Machine::baseline, stop.get_token());
    });
  const auto kept = dataset.point_gradients->of(view, 4);
  const render::PointGradients computed(view, 1);
  const auto a = kept->of_points(), b = computed.of_points();
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
  EXPECT_EQ(dataset.point_gradients->of(view, 4, stop.get_token()), kept);
}

TEST(PointGradients, are_the_means_of_the_cells_around_by_volume_without_those_that_have_no_data) {
  auto mesh = box_mesh({.cells = {4, 3, 5}, .jitter = 0.12, .grading = 8}, waves);
  mesh.point_fields[0].values[17] = std::numeric_limits<double>::quiet_NaN();
  TracedDataset traced(mesh);
  const auto& view = std::get<render::TetData>(traced.dataset().implementation().view);
  const render::PointGradients gradients(view, 1);
  std::vector<Vec3> sums(view.description().point_count, Vec3(0, 0, 0));
  std::vector<double> datasets(sums.size());
  for (std::uint32_t cell = 0; cell < view.description().cell_count; ++cell) {
    const auto vertices = view.vertices(cell);
    const auto p = view.points_at(vertices);
    if (!render::has_data(view.values_at(vertices))) continue;
    const Vec3 o = to_vec3(p[0]);
    const double volume = std::abs((to_vec3(p[1]) - o).dot((to_vec3(p[2]) - o).cross(to_vec3(p[3]) - o))) / 6;
    for (const std::uint32_t v : vertices) {
      sums[v] += volume * render::tet_gradient(p, view.values_at(vertices));
      datasets[v] += volume;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const Vec3 expected = datasets[v] > 0 ? sums[v] / datasets[v] : Vec3(0, 0, 0);
    EXPECT_LT((to_vec3(gradients.of_points()[v]) - expected).length(), 1e-11);
  }
}

std::vector<MadeField> grid_fields() {
  return {{"value",
           [](auto i, auto j, auto k) {
             return static_cast<float>(std::sin(0.9 * static_cast<double>(i)) + 0.3 * static_cast<double>(j) -
                                       0.2 * static_cast<double>(k));
           }},
          {"other", [](auto i, auto j, auto k) { return static_cast<float>(3 * i - 2 * j + 5 * k); }}};
}

TEST(HitLookup, in_grids_is_trilinear_at_the_hit_where_samples_stand_and_lie_anyhow) {
  for (const bool is_sparse : {false, true})
    for (const bool is_rectilinear : {false, true}) {
      MadeGridChoice choice{.sample_count = {17, 12, 14}, .is_sparse = is_sparse};
      if (is_rectilinear)
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (std::int64_t i = 0; i < choice.sample_count[static_cast<int>(axis)]; ++i)
            choice.axes[axis].push_back(0.1 * static_cast<double>(i * i) + static_cast<double>(i));
      TracedDataset traced(made_grid(choice, grid_fields()).file(), "value");
      const auto& implementation = traced.dataset().implementation();
      const auto rays = rays_through(implementation.bounds_data, 256);
      // In sample coordinates, in which the other field is linear.
      const auto in_samples = [&](int axis, double x) {
        if (!is_rectilinear) return x;
        const auto& table = choice.axes[static_cast<std::size_t>(axis)];
        const auto above = std::upper_bound(table.begin() + 1, table.end() - 1, x);
        return static_cast<double>(above - table.begin() - 1) + (x - above[-1]) / (above[0] - above[-1]);
      };
      for (const render::Method& method : levels()) {
        const double tolerance = method.precision == render::Method::Precision::float32 ? 1e-5 : 1e-11;
        const Answers own =
            answered(traced.dataset(), rays, 0.7, method, {.smooth_gradients = false, .field = "value"});
        for_each_hit(own, 60,
                     [&](std::size_t r, const Vec3&) { EXPECT_NEAR(own.values[r], 0.7, 2e-3 * 1e-2 + tolerance); });
        const Answers other =
            answered(traced.dataset(), rays, 0.7, method, {.smooth_gradients = false, .field = "other"});
        for_each_hit(other, 60, [&](std::size_t r, const Vec3& p) {
          EXPECT_NEAR(other.values[r], 3 * in_samples(0, p.x) - 2 * in_samples(1, p.y) + 5 * in_samples(2, p.z), 1e-9);
        });
      }
    }
}

TEST(HitLookup, says_nan_where_the_cell_has_no_data) {
  auto fields = grid_fields();
  fields[1].value = [](auto i, auto, auto) {
    return i == 8 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(i);
  };
  TracedDataset grid(made_grid({.sample_count = {17, 12, 14}}, fields).file(), "value");
  const auto rays = rays_through(grid.dataset().implementation().bounds_data, 256);
  const Answers answers =
      answered(grid.dataset(), rays, 0.7, render::Method{}, {.smooth_gradients = false, .field = "other"});
  int without = 0;
  for_each_hit(answers, 60, [&](std::size_t r, const Vec3& p) {
    const bool has_none = p.x > 7 && p.x < 9;
    without += has_none;
    EXPECT_EQ(std::isnan(answers.values[r]), has_none);
  });
  EXPECT_GT(without, 5);
}

TEST(HitLookup, gives_the_same_bits_on_every_machine) {
  TracedDataset mesh(mesh_of({.cells = {7, 8, 6}, .jitter = 0.12}, waves, linear_field({1, 2, 3})));
  TracedDataset grid(made_grid({.sample_count = {17, 12, 14}}, grid_fields()).file(), "value");
  for (const TracedDataset* traced : {&mesh, &grid}) {
    const auto rays = rays_through(traced->dataset().implementation().bounds_data, 256);
    const HitAttributes attributes{.smooth_gradients = true, .field = "other"};
    const auto on = [&](Machine machine) {
      return answered(traced->dataset(), rays, 0.3, render::Method{}, attributes, machine);
    };
    const Answers scalar = on(Machine::scalar);
    for (const Machine machine : wide_machines()) {
      const Answers wide = on(machine);
      for_each_hit(scalar, 60, [&](std::size_t r, const Vec3&) {
        EXPECT_EQ(wide.values[r], scalar.values[r]);
        EXPECT_EQ(wide.hits[r].gradient, scalar.hits[r].gradient);
      });
    }
  }
}

TEST(HitLookup, refuses_what_does_not_apply) {
  TracedDataset mesh(box_mesh({}, waves));
  TracedDataset grid(made_grid({}, grid_fields()).file());
  expect_error(ErrorCode::usage, "no field 'colour'; it has 'value'",
               [&] { HitLookup(mesh.dataset().implementation(), {.smooth_gradients = false, .field = "colour"}, 1); });
  expect_error(ErrorCode::usage, "no field 'colour'",
               [&] { HitLookup(grid.dataset().implementation(), {.smooth_gradients = true, .field = "colour"}, 1); });
}

}  // namespace
}  // namespace rhoray::tests
