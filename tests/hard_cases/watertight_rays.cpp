#include "tests/hard_cases/watertight_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/base/checks.h"

namespace rhoray::tests {

namespace {

using render::Ray;
using study::Aim;
using study::ClosedScene;

constexpr std::size_t square = 64;

/// Adds rays from one eye, or parallel rays, at edges that are close together in the scene's list,
/// hence neighbours.
void add_square(const ClosedScene& scene, Aim aim, study::Dice& dice, std::vector<Ray>& rays) {
  const auto edge_count = static_cast<int>(scene.edges.size());
  const int first = dice.below(edge_count);
  const auto edge = [&](std::size_t i) {
    return scene.edges[(static_cast<std::size_t>(first) + i) % scene.edges.size()];
  };
  const Vec3 direction = study::any_direction(dice);
  const Vec3 eye = target_at(scene, edge(square / 2), aim, dice) - dice.between(1.5, 50) * scene.diagonal * direction;
  const bool is_parallel = dice.coin(), is_unit = dice.coin();
  for (std::size_t i = 0; i < square; ++i) {
    const Vec3 target = target_at(scene, edge(i), aim, dice);
    if (is_parallel)
      rays.push_back({.origin = target - 2 * scene.diagonal * direction, .direction = direction});
    else
      rays.push_back({.origin = eye, .direction = is_unit ? (target - eye).normalized() : target - eye});
  }
}

/// Points inside, proven to be so by the values at the ends of edges.
class InsidePoints {
 public:
  explicit InsidePoints(const ClosedScene& scene) : scene_(scene) {
    double largest_step = 0;
    for (const auto& [a, b] : scene.edges) {
      const double step = std::abs(scene.values[a] - scene.values[b]);
      largest_step = std::max(largest_step, step);
      steepest_ = std::max(steepest_, step / (scene.vertices[a] - scene.vertices[b]).length());
    }
    for (const auto& edge : scene.edges)
      if (depth(edge) > largest_step / 64) edges_.push_back(edge);
    RHORAY_CHECK(!edges_.empty());
  }

  /// Returns a point on an edge, at an end of one, or so close to one that the field cannot have
  /// reached the isovalue. The field is nowhere 16 times as steep as the steepest edge.
  Vec3 any(Aim aim, study::Dice& dice) const {
    const auto& edge = edges_[static_cast<std::size_t>(dice.below(static_cast<int>(edges_.size())))];
    const Vec3 a = scene_.vertices[edge[0]], b = scene_.vertices[edge[1]];
    if (aim == Aim::at_vertices) return a;
    const Vec3 point = a + dice.unit() * (b - a);
    if (aim == Aim::at_edges) return point;
    return point + depth(edge) / (16 * steepest_) * dice.unit() * study::any_direction(dice);
  }

 private:
  double depth(const std::array<std::uint32_t, 2>& edge) const {
    return std::min(scene_.values[edge[0]], scene_.values[edge[1]]) - scene_.isovalue;
  }

  const ClosedScene& scene_;
  double steepest_ = 0;
  std::vector<std::array<std::uint32_t, 2>> edges_;
};

Ray ray_from_inside(const ClosedScene& scene, const InsidePoints& points, Aim aim, study::Dice& dice) {
  const Vec3 origin = points.any(aim, dice), target = target_of(scene, aim, dice);
  const bool is_aimed = aim != Aim::anywhere && (target - origin).length() > 0;
  return {.origin = origin, .direction = is_aimed ? target - origin : study::any_direction(dice)};
}

/// Adds rays in planes that have all cells of the surface on one side; some of these planes are
/// close to the surface.
void add_rays_past(const ClosedScene& scene, study::Dice& dice, std::vector<Ray>& rays) {
  const Vec3 normal = study::any_direction(dice);
  Vec3 last = scene.vertices[scene.edges.front()[0]];
  for (const auto& edge : scene.edges)
    for (const std::uint32_t v : edge)
      if (normal.dot(scene.vertices[v]) > normal.dot(last)) last = scene.vertices[v];
  // As close as a millionth of a cell: a ray that starts two diagonals away is rounded by less than
  // 1e-13 of a cell.
  const Vec3 beside = last + scene.cell_edge * std::exp2(dice.between(-20, -1)) * normal;
  for (std::size_t i = 0; i < 32; ++i) {
    const auto along = [&] {
      const Vec3 v = study::any_direction(dice);
      return v - normal.dot(v) * normal;
    };
    const Vec3 direction = along();
    const Vec3 near = beside + 4 * scene.cell_edge * dice.unit() * along();
    rays.push_back({.origin = near - 2 * scene.diagonal * direction.normalized(), .direction = direction});
  }
}

}  // namespace

WatertightRays watertight_rays(const ClosedScene& scene, Aim aim, std::size_t count, study::Dice& dice) {
  RHORAY_CHECK(count % 256 == 0);
  const std::size_t through = 5 * count / 8, from_inside = 2 * count / 8, past = count / 8;
  const InsidePoints points(scene);
  WatertightRays rays;
  while (rays.through.size() + square <= through / 2) add_square(scene, aim, dice, rays.through);
  while (rays.through.size() < through) rays.through.push_back(ray_at(scene, aim, dice));
  while (rays.from_inside.size() < from_inside) rays.from_inside.push_back(ray_from_inside(scene, points, aim, dice));
  while (rays.past.size() < past) add_rays_past(scene, dice, rays.past);
  return rays;
}

}  // namespace rhoray::tests
