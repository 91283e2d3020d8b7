#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/agreement/pictures.h"
#include "tests/render/support/methods.h"

namespace rhoray::tests {

namespace {

struct WorldRay {
  Vec3 origin, direction;
};

WorldRay ray_of_pixel(const render::Camera& camera, int x, int y, int width, int height) {
  const Vec3 forward = (camera.target - camera.position).normalized(), right = forward.cross(camera.up).normalized(),
             down = forward.cross(right);
  const double half = std::tan(camera.vertical_fov_deg * std::numbers::pi / 360);
  const Vec3 offset =
      half * width / height * ((2 * x + 1.0) / width - 1) * right + half * ((2 * y + 1.0) / height - 1) * down;
  return {camera.position, (forward + offset).normalized()};
}

/// The largest value on a ray through a grid whose samples stand at whole positions. Passes all
/// lattice planes in order; between two of them, searches the cubic through four points for its
/// largest value. Shares no code with the renderer.
std::optional<double> brute_force_maximum(const preprocess::NeutralVolume& volume, const WorldRay& ray,
                                          bool faces_only) {
  const auto* samples = reinterpret_cast<const float*>(volume.samples.data());
  const Index3 n = volume.sample_count;
  const auto value_at = [&](const Vec3& p, const Vec3& middle) {
    Index3 c;
    for (int a = 0; a < 3; ++a)
      c[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(middle[a])), 0, n[a] - 2);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      Index3 at = c;
      for (int a = 0; a < 3; ++a) {
        const double u = std::clamp(p[a] - static_cast<double>(c[a]), 0.0, 1.0);
        const bool far = corner >> a & 1;
        weight *= far ? u : 1 - u;
        at[a] += far;
      }
      sum += weight * static_cast<double>(samples[(at.z * n.y + at.y) * n.x + at.x]);
    }
    return sum;
  };

  double t_in = 0, t_out = std::numeric_limits<double>::infinity();
  std::vector<double> times;
  for (int a = 0; a < 3; ++a)
    for (std::int64_t k = 0; k < n[a]; ++k) {
      const double t = (static_cast<double>(k) - ray.origin[a]) / ray.direction[a];
      times.push_back(t);
    }
  for (int a = 0; a < 3; ++a) {
    const double t0 = -ray.origin[a] / ray.direction[a],
                 t1 = (static_cast<double>(n[a] - 1) - ray.origin[a]) / ray.direction[a];
    t_in = std::max(t_in, std::min(t0, t1));
    t_out = std::min(t_out, std::max(t0, t1));
  }
  if (!(t_in < t_out)) return std::nullopt;
  std::erase_if(times, [&](double t) { return t < t_in || t > t_out; });
  times.push_back(t_in);
  times.push_back(t_out);
  std::sort(times.begin(), times.end());

  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s + 1 < times.size(); ++s) {
    const double a = times[s], b = times[s + 1];
    const Vec3 middle = ray.origin + 0.5 * (a + b) * ray.direction;
    const auto at = [&](double share) { return value_at(ray.origin + (a + share * (b - a)) * ray.direction, middle); };
    best = std::max({best, at(0), at(1)});
    if (faces_only) continue;
    // The cubic through four points, by divided differences; its extrema by the quadratic formula.
    const double f0 = at(0), f1 = at(1.0 / 3), f2 = at(2.0 / 3), f3 = at(1);
    const double c1 = (-11 * f0 + 18 * f1 - 9 * f2 + 2 * f3) / 2, c2 = 9 * (2 * f0 - 5 * f1 + 4 * f2 - f3) / 2,
                 c3 = 9 * (-f0 + 3 * f1 - 3 * f2 + f3) / 2;
    const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c1 * c3));
    for (const double extremum : {(-c2 + root) / (3 * c3), (-c2 - root) / (3 * c3), -c1 / (2 * c2)})
      if (extremum > 0 && extremum < 1) best = std::max(best, at(extremum));
  }
  return best;
}

/// The largest value on a ray through tetrahedra. Cuts the ray with the four planes of each
/// tetrahedron in turn.
std::optional<double> brute_force_maximum(const preprocess::NeutralMesh& mesh, const WorldRay& ray) {
  std::optional<double> best;
  for (const auto& cell : mesh.cells) {
    std::array<Vec3, 4> p;
    for (std::size_t v = 0; v < 4; ++v) p[v] = to_vec3(mesh.points[cell[v]]);
    double t_in = 0, t_out = std::numeric_limits<double>::infinity(), value_origin = 0, value_slope = 0;
    bool parallel_outside = false;
    for (std::size_t v = 0; v < 4; ++v) {
      const Vec3 &a = p[(v + 1) % 4], &b = p[(v + 2) % 4], &c = p[(v + 3) % 4];
      const Vec3 normal = (b - a).cross(c - a);
      const double height = normal.dot(p[v] - a), at_origin = normal.dot(ray.origin - a) / height,
                   slope = normal.dot(ray.direction) / height;
      value_origin += at_origin * mesh.point_fields[0].values[cell[v]];
      value_slope += slope * mesh.point_fields[0].values[cell[v]];
      if (slope > 0)
        t_in = std::max(t_in, -at_origin / slope);
      else if (slope < 0)
        t_out = std::min(t_out, -at_origin / slope);
      else
        parallel_outside |= at_origin < 0;
    }
    if (parallel_outside || !(t_in <= t_out)) continue;
    const double value = std::max(value_origin + t_in * value_slope, value_origin + t_out * value_slope);
    best = std::max(best.value_or(value), value);
  }
  return best;
}

}  // namespace

TEST(Maximum, of_packed_grids_equals_brute_force_by_both_rules) {
  const TemporaryFolder folder;
  const Index3 count(22, 17, 26);
  for (const int largest : {3, 1000}) {
    const auto neutral = noise_volume<float>(count, largest, 17);
    const render::Dataset volume = packed(folder, concat(largest), neutral);
    render::Scene scene = oblique_scene(volume, 0);
    scene.layers[0].mode = render::Mode::mip;
    double deficit = 0;
    for (const render::Method& method : {render::Method{}, face_rule}) {
      scene.layers[0].method = method;
      const render::Framebuffer found = picture(volume, scene);
      std::size_t checked = 0, mask_differs = 0;
      for (int y = 0; y < found.height; ++y)
        for (int x = 0; x < found.width; ++x) {
          const auto pixel = static_cast<std::size_t>(y * found.width + x);
          const WorldRay ray = ray_of_pixel(scene.camera, x, y, found.width, found.height);
          const auto expected = brute_force_maximum(neutral, ray, method == face_rule);
          const bool is_hit = found.cell[pixel] != render::Framebuffer::no_cell;
          mask_differs += expected.has_value() != is_hit;
          if (!expected || !is_hit) continue;
          // Both computations round positions of some tens of cells: 1e-12 of the range is hundreds
          // of such roundings.
          ASSERT_NEAR(found.value[pixel], *expected, 1e-12 * largest);
          ++checked;
          if (method == face_rule)
            deficit = std::max(deficit, *brute_force_maximum(neutral, ray, false) - found.value[pixel]);
        }
      EXPECT_GT(checked, 4000u);
      EXPECT_EQ(mask_differs, 0u);
    }
    EXPECT_GT(deficit, 0.02 * largest)
        << "the face rule is no longer too low here: does this still tell the methods apart?";
  }
}

TEST(Maximum, of_packed_meshes_equals_brute_force) {
  const TemporaryFolder folder;
  auto neutral = box_mesh({.cells = {5, 6, 4}, .jitter = 0.15, .grading = 4});
  std::mt19937_64 random(4);
  add_point_field(neutral, "noise", [&](const Vec3&) { return static_cast<double>(random() % 1000); });
  const render::Dataset volume = packed(folder, "m", neutral);
  render::Scene scene = oblique_scene(volume, 0);
  scene.layers[0].mode = render::Mode::mip;
  const render::Framebuffer found = picture(volume, scene);
  std::size_t checked = 0, mask_differs = 0;
  for (int y = 0; y < found.height; ++y)
    for (int x = 0; x < found.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * found.width + x);
      const auto expected = brute_force_maximum(neutral, ray_of_pixel(scene.camera, x, y, found.width, found.height));
      const bool is_hit = found.cell[pixel] != render::Framebuffer::no_cell;
      mask_differs += expected.has_value() != is_hit;
      if (!expected || !is_hit) continue;
      // Planes of cells seen edge-on amplify rounding.
      ASSERT_NEAR(found.value[pixel], *expected, 1e-9 * 1000);
      ++checked;
    }
  EXPECT_GT(checked, 4000u);
  EXPECT_EQ(mask_differs, 0u);
}

// Lower bounds only save work. With them, without them, and with the one left by a neighbour, the
// answer is the same.
TEST(Maximum, does_not_depend_on_the_last_t) {
  const TemporaryFolder folder;
  const Index3 count(40, 40, 40);
  const render::Dataset volume =
      packed(folder, "v",
             sampled_volume<float>(count, lattice_over({{-1, -1, -1}, {1, 1, 1}}, count), marschner_lobb_field(3)));
  render::Scene scene = oblique_scene(volume, 0);
  scene.layers[0].mode = render::Mode::mip;
  for (const render::Method& method : {render::Method{}, face_rule}) {
    scene.layers[0].method = method;
    expect_same_bits(picture(volume, scene, {.use_last_t = true}), picture(volume, scene, {.use_last_t = false}));
  }
}

}  // namespace rhoray::tests
