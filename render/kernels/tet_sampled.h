#pragma once

#include "render/cells/tet_methods.h"
#include "render/kernels/sampling.h"

namespace rhoray::render {

namespace {

/// A ray through a mesh (sampling.h): each sample is looked up in the tetrahedra that the leaf cell there lists. Steps
/// are in leaf cells, about the size of a tetrahedron.
template <class View>
class TetSampler {
 public:
  TetSampler(const View& view, const Ray& ray)
      : view_(view), ray_(ray), ray_lattice_(view.on_lattice(ray)), planes_(ray_lattice_) {}

  WalkLattice lattice() const { return view_.lattice(); }
  const PlaneTimes& planes() const { return planes_; }
  const Ray& ray_lattice() const { return ray_lattice_; }
  int top_level() const { return view_.level_count(); }
  double steps_per_t() const { return ray_lattice_.direction.length(); }
  Interval<double> range(int level, const Index3& cell) const { return view_.range(level, cell); }

  /// Linear in the first listed tetrahedron that holds the point, rounding included.
  double sample(double t) const {
    const std::optional<Found> found = find(t);
    return found ? found->value : std::numeric_limits<double>::quiet_NaN();
  }

  void complete(Hit& hit) const {
    const std::optional<Found> found = find(hit.t);
    if (!found) return;
    const auto vertices = view_.sorted_vertices(found->tet);
    hit.cell = view_.cell_id(found->tet);
    hit.gradient = tet_gradient(view_.points_at(vertices), view_.values_at(vertices));
  }

 private:
  struct Found {
    std::uint32_t tet;
    double value;
  };

  std::optional<Found> find(double t) const {
    const Vec3 p = ray_.at(t), p_lattice = ray_lattice_.at(t);
    Index3 leaf;
    for (int a = 0; a < 3; ++a)
      leaf[a] = static_cast<std::int64_t>(
          std::clamp(std::floor(p_lattice[a]), 0.0, static_cast<double>(lattice().leaf_count[a] - 1)));
    for (const std::uint32_t tet : view_.tetrahedra_at(leaf)) {
      const auto vertices = view_.sorted_vertices(tet);
      const TetValues values = view_.values_at(vertices);
      const std::array<double, 4> w = barycentric(view_.points_at(vertices), p);
      // Nothing is above a NaN, which the weights of a flat tetrahedron are.
      if (!(std::min({w[0], w[1], w[2], w[3]}) >= -default_tet_slack) || !has_data(values)) continue;
      return Found{tet, w[0] * values[0] + w[1] * values[1] + w[2] * values[2] + w[3] * values[3]};
    }
    return std::nullopt;
  }

  static std::array<double, 4> barycentric(const TetPoints& points, const Vec3& p) {
    const auto corner = [&](std::size_t i) { return Vec3(points[i][0], points[i][1], points[i][2]); };
    const Vec3 a = corner(1) - corner(0), b = corner(2) - corner(0), c = corner(3) - corner(0), q = p - corner(0);
    const double volume = a.dot(b.cross(c));
    const double w1 = q.dot(b.cross(c)) / volume, w2 = a.dot(q.cross(c)) / volume, w3 = a.dot(b.cross(q)) / volume;
    return {1 - w1 - w2 - w3, w1, w2, w3};
  }

  const View& view_;
  const Ray& ray_;
  Ray ray_lattice_;
  PlaneTimes planes_;
};

template <class View>
Hit sampled_crossing_of_ray(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  TetSampler sampler(view, ray);
  return sampled_crossing(sampler, question, scratch.counters);
}

template <class View>
Hit sampled_maximum_on_ray(const View& view, const Question& question, const Ray& ray, KernelScratch& scratch) {
  TetSampler sampler(view, ray);
  return sampled_maximum(sampler, question, scratch.counters);
}

}  // namespace

}  // namespace rhoray::render
