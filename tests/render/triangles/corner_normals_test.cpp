#include "render/triangles/corner_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stop_token>

#include "preprocess/pack_surface.h"
#include "render/cell/triangle_crossing.h"
#include "tests/support/expect_error.h"
#include "tests/support/surfaces.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using render::CornerNormals;
using render::TriangleData;

/// A packed surface as kernels read it.
struct Packed {
  TemporaryFolder folder;
  TriangleData view;

  explicit Packed(const preprocess::NeutralSurface& surface) : view(packed(surface)) {}

  formats::TriangleMesh packed(const preprocess::NeutralSurface& surface) const {
    preprocess::pack_surface(surface, folder / "surface.rho");
    return formats::TriangleMesh(formats::PackedFile::open(folder / "surface.rho"));
  }
};

/// Two triangles at the edge from (0, 0, 0) to (0, 1, 0), bent by an angle there; the second may be
/// oriented the other way round.
preprocess::NeutralSurface bent(double angle_deg, bool is_turned = false) {
  const double angle = angle_deg * std::numbers::pi / 180;
  std::vector<std::vector<std::uint64_t>> facets{{0, 1, 2}, {1, 0, 3}};
  if (is_turned) facets[1] = {0, 1, 3};
  return surface_of({{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(angle), 0, std::sin(angle)}}, facets);
}

/// The normal at the corner of a triangle that is at a point.
Vec3 normal_at(const Packed& packed, const CornerNormals& normals, std::uint32_t triangle, const Vec3& point) {
  const auto vertices = packed.view.vertices(triangle);
  const auto points = packed.view.points_at(vertices);
  for (std::size_t c = 0; c < 3; ++c)
    if (Vec3(points[c][0], points[c][1], points[c][2]) == point) return normals.of(triangle, c);
  ADD_FAILURE() << "no such corner";
  return {0, 0, 0};
}

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / std::numbers::pi;
}

TEST(CornerNormals, are_shared_across_an_edge_below_the_crease_angle_only) {
  for (const bool is_turned : {false, true})
    for (const double angle : {0.0, 10.0, 29.0, 31.0, 90.0, 150.0}) {
      const Packed packed(bent(angle, is_turned));
      const CornerNormals normals(packed.view, 1);
      for (const Vec3& point : {Vec3(0, 0, 0), Vec3(0, 1, 0)}) {
        const Vec3 first = normal_at(packed, normals, 0, point), second = normal_at(packed, normals, 1, point);
        EXPECT_NEAR(first.length(), 1, 1e-12);
        EXPECT_NEAR(degrees_between(first, is_turned ? -second : second), angle < 30 ? 0 : angle, 1e-5) << angle;
      }
    }
}

TEST(CornerNormals, of_a_cube_are_those_of_its_squares) {
  const Packed packed(cube_surface());
  const CornerNormals normals(packed.view, 1);
  for (std::uint32_t t = 0; t < packed.view.triangle_count(); ++t) {
    const Vec3 own = render::triangle_normal(packed.view.points_at(packed.view.vertices(t))).normalized();
    for (std::size_t c = 0; c < 3; ++c) EXPECT_LT((normals.of(t, c) - own).length(), 1e-12);
  }
}

TEST(CornerNormals, of_a_fine_ball_are_radial_and_the_same_for_any_number_of_threads) {
  const Packed packed(round_surface(6));
  const CornerNormals one(packed.view, 1), many(packed.view, 4);
  for (std::uint32_t t = 0; t < packed.view.triangle_count(); ++t) {
    const auto points = packed.view.points_at(packed.view.vertices(t));
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_LT((one.of(t, c) - Vec3(points[c][0], points[c][1], points[c][2])).length(), 0.01);
      EXPECT_EQ(one.of(t, c), many.of(t, c));
    }
  }
}

TEST(CornerNormals, are_not_kept_if_their_computation_was_stopped) {
  std::stop_source stop;
  stop.request_stop();
  const Packed packed(round_surface(4));
  render::CornerNormalsCache cache;
  for (const unsigned threads : {1U, 4U})
    expect_error(ErrorCode::interrupted, "interrupted", [&] { cache.of(packed.view, threads, stop.get_token()); });
  const auto kept = cache.of(packed.view, 4);
  const CornerNormals computed(packed.view, 1);
  for (std::uint32_t t = 0; t < packed.view.triangle_count(); ++t)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(kept->of(t, c), computed.of(t, c));
  EXPECT_EQ(cache.of(packed.view, 4, stop.get_token()), kept);
}

TEST(CornerNormals, pass_triangles_without_area) {
  // A flat triangle between two that are bent by 20 degrees, along the edge they would share.
  const double angle = 20 * std::numbers::pi / 180;
  const Packed packed(surface_of({{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {std::cos(angle), 0, std::sin(angle)}, {0, 0.5, 0}},
                                 {{0, 1, 2}, {1, 0, 4}, {0, 3, 4}, {1, 4, 3}}));
  const CornerNormals normals(packed.view, 1);
  const Vec3 left = normal_at(packed, normals, 0, {0, 0, 0}), right = normal_at(packed, normals, 2, {0, 0, 0});
  EXPECT_NEAR(left.length(), 1, 1e-12);
  EXPECT_LT((left - right).length(), 1e-12);
}

}  // namespace
}  // namespace rhoray::tests
