// Units never matter: the picture is the same for values and coordinates of any magnitude, far from
// zero, and on cells of any shape. An absolute tolerance would show here, as would coefficients
// formed before the common part is subtracted.
//
// Ray origins are multiples of 2^-20 of a cell and values are multiples of 2^-20. Translations are
// therefore exact, and the query stays the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Method;
using render::Ray;

double on_a_grid(double x) {
  return std::ldexp(std::round(std::ldexp(x, 20)), -20);
}
Vec3 on_a_grid(const Vec3& p) {
  return {on_a_grid(p.x), on_a_grid(p.y), on_a_grid(p.z)};
}

constexpr std::int64_t cells = 8;  // per axis, each with edge 1
constexpr double isovalue = 2.75;

double field_at(const Vec3& p) {
  return on_a_grid((p - Vec3(4.1, 3.9, 4.3)).length() + 0.4 * std::sin(2 * p.x + p.z));
}

/// A change of a scene: maps values to scale * value + offset and points to stretch * p + shift.
struct Change {
  double value_scale = 1, value_offset = 0;
  Vec3 stretch{1, 1, 1}, shift{0, 0, 0};

  double value(double v) const { return value_scale * v + value_offset; }
  Vec3 vector(const Vec3& p) const { return stretch * p; }
  Vec3 point(const Vec3& p) const { return vector(p) + shift; }
};

TracedDataset changed_grid(const Change& change) {
  const Affine map{{change.stretch.x, 0, 0}, {0, change.stretch.y, 0}, {0, 0, change.stretch.z}, change.shift};
  return TracedDataset(volume_of<double>(
      Index3(cells + 1),
      [&](const Index3& at) {
        return change.value(
            field_at({static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)}));
      },
      map));
}

TracedDataset changed_mesh(const Change& change) {
  const BoxMesh shape{.cells = Index3(cells), .box = Box3(Vec3(0), Vec3(cells)), .jitter = 0.15};
  preprocess::NeutralMesh mesh = box_mesh(shape);
  for (auto& point : mesh.points) point = to_array(on_a_grid(to_vec3(point)));
  add_point_field(mesh, "value", [&](const Vec3& p) { return change.value(field_at(p)); });
  for (auto& point : mesh.points) point = to_array(change.point(to_vec3(point)));
  return TracedDataset(mesh);
}

std::vector<Ray> rays_at_the_scene() {
  Dice dice(1);
  std::vector<Ray> rays;
  while (rays.size() < 400) {
    Vec3 direction = on_a_grid(dice.direction());
    if (dice.below(4) == 0) direction[static_cast<int>(dice.below(3))] = 0;
    rays.push_back({.origin = on_a_grid(dice.point(Vec3(0), Vec3(cells)) - 12.0 * direction), .direction = direction});
  }
  return rays;
}

struct Comparison {
  int hits = 0;               ///< in both pictures
  int differ = 0;             ///< hit in one, miss in the other
  int other_bits = 0;         ///< hits whose t is not the same, bit for bit
  double farthest_apart = 0;  ///< largest difference of two hits beyond their bounds, in cells
};

using Make = std::function<TracedDataset(const Change&)>;

/// Directions change together with the points, so that t stays.
Comparison compare(const Make& make, const Change& change, const Method& method) {
  TracedDataset plain = make({}), changed = make(change);
  Comparison result;
  for (const Ray& ray : rays_at_the_scene()) {
    const Ray moved{.origin = change.point(ray.origin), .direction = change.vector(ray.direction)};
    const Hit a = plain.first_crossing(ray, isovalue, method);
    const Hit b = changed.first_crossing(moved, change.value(isovalue), method);
    if (a.is_miss() != b.is_miss()) ++result.differ;
    if (a.is_miss() || b.is_miss()) continue;
    ++result.hits;
    result.other_bits += a.t != b.t;
    const double bounds = render::proves(method) ? a.error + b.error : 0;
    result.farthest_apart = std::max(result.farthest_apart, (std::abs(a.t - b.t) - bounds) * ray.direction.length());
  }
  return result;
}

struct Named {
  const char* name;
  Method method;
  double cells;  ///< tolerance of t where the change is not by a power of two
};

/// In single precision, a crossing inside a cell is known to the rounding of the values divided by
/// their slope along the ray. This is a ten-thousandth of a cell for the most grazing of these
/// rays. A certified position is as good as its own bounds.
const std::array methods{
    Named{"direct double", {.algorithm = Method::Algorithm::direct, .precision = Method::Precision::float64}, 1e-6},
    Named{"direct float", {.algorithm = Method::Algorithm::direct, .precision = Method::Precision::float32}, 1e-4},
    Named{"certified", {.algorithm = Method::Algorithm::certified}, 1e-6}};

const std::array<std::pair<const char*, Make>, 2> scenes{{{"grid", changed_grid}, {"mesh", changed_mesh}}};

/// @param bits  true when the changes are by powers of two
void expect_the_same_picture_of_all(const std::vector<Change>& changes, bool bits) {
  for (const auto& [scene, make] : scenes)
    for (const Named& named : methods)
      for (const Change& change : changes) {
        SCOPED_TRACE(testing::Message() << scene << ", " << named.name << ", values * " << change.value_scale << " + "
                                        << change.value_offset << ", points * " << change.stretch << " + "
                                        << change.shift);
        const Comparison result = compare(make, change, named.method);
        EXPECT_GT(result.hits, 100);
        EXPECT_EQ(result.differ, 0);
        EXPECT_LE(result.farthest_apart, named.cells);
        if (bits) {
          EXPECT_EQ(result.other_bits, 0);
        }
      }
}

TEST(Units, of_values_change_no_bit_when_they_are_powers_of_two) {
  expect_the_same_picture_of_all(
      {{.value_scale = 0x1p-40}, {.value_scale = 0x1p-3}, {.value_scale = 0x1p7}, {.value_scale = 0x1p40}}, true);
}

TEST(Units, of_values_do_not_matter) {
  expect_the_same_picture_of_all(
      {{.value_scale = 1e-12}, {.value_scale = 1e-3}, {.value_scale = 1e3}, {.value_scale = 1e12}}, false);
}

TEST(Units, of_values_may_begin_anywhere) {
  expect_the_same_picture_of_all({{.value_offset = 1e6}, {.value_offset = -1e6}}, false);
}

TEST(Units, of_length_change_no_bit_when_they_are_powers_of_two) {
  expect_the_same_picture_of_all({{.stretch = Vec3(0x1p-20)}, {.stretch = Vec3(0x1p20)}}, true);
}

TEST(Units, of_length_do_not_matter) {
  expect_the_same_picture_of_all({{.stretch = Vec3(1e-6)}, {.stretch = Vec3(0.1)}, {.stretch = Vec3(1e6)}}, false);
}

TEST(Units, of_length_may_begin_ten_million_cells_away) {
  expect_the_same_picture_of_all({{.shift = {1e7, -1e7, 1e7}}, {.shift = {0, 0, 1e5}}}, false);
}

TEST(Units, may_differ_by_a_thousand_between_axes) {
  expect_the_same_picture_of_all(
      {{.stretch = {1, 1000, 1}}, {.stretch = {1e-3, 1, 1}}, {.stretch = {1, 0x1p5, 0x1p-5}}}, false);
}

TEST(Units, of_values_that_begin_far_from_zero_matter_to_the_papers_closed_form) {
  const Method paper{.algorithm = Method::Algorithm::paper, .precision = Method::Precision::float32};
  EXPECT_GT(compare(changed_grid, {.value_offset = 1e6}, paper).differ, 10) << "is this change still hard?";
}

}  // namespace
}  // namespace rhoray::tests
