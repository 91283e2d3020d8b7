#pragma once

#include <algorithm>
#include <vector>

#include "render/cell/tet_methods.h"
#include "render/query/sampling.h"
#include "render/tets/reference/walk.h"

namespace rhoray::render {

namespace {

/// Samples a ray through a mesh (render/query/sampling.h). Each sample is looked up in the
/// tetrahedra that the leaf cell there lists, or in those of the clusters whose boxes contain it.
/// Steps are in leaf cells, about the size of a tetrahedron.
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

  template <class MayHold, class Region>
  void walk(const SampledWalk& walk, KernelCounters& counters, MayHold&& may_hold, Region&& region) const {
    if (view_.has_clusters())
      walk_in_order(walk, counters, may_hold, region);
    else
      walk_lattice(*this, walk, counters, may_hold, region);
  }

  /// Returns the value, linear in the tetrahedron that contains the point, with a tolerance for
  /// rounding. If several contain it, the preferred one is used.
  double sample(double t) const {
    const std::optional<Found> found = find(t);
    return found ? found->value : std::numeric_limits<double>::quiet_NaN();
  }

  void complete(Hit& hit) const {
    const std::optional<Found> found = find(hit.t);
    if (!found) return;
    const auto vertices = view_.sorted_vertices(found->tet);
    hit.cell = view_.cell_id(found->tet);
    hit.tet = found->tet;
    hit.gradient = tet_gradient(view_.points_at(vertices), view_.values_at(vertices));
  }

 private:
  struct Found {
    std::uint32_t tet;
    double value;
  };

  /// Clusters overlap and are not visited in the order in which they begin.
  template <class MayHold, class Region>
  void walk_in_order(const SampledWalk& walk, KernelCounters& counters, MayHold& may_hold, Region& region) const {
    std::vector<ClusterVisit> visits;
    walk_clusters(
        view_, BoxRay(ray_, view_.clusters().box_unit), walk.use_hierarchy, counters, may_hold,
        [](double) { return true; },
        [&](const ClusterVisit& visit) {
          visits.push_back(visit);
          return true;
        });
    std::sort(visits.begin(), visits.end(),
              [](const ClusterVisit& a, const ClusterVisit& b) { return a.part.t_in < b.part.t_in; });
    for (const ClusterVisit& visit : visits) {
      const double t_in = std::max(visit.part.t_in, walk.segment.t_in);
      const double t_out = std::min(visit.part.t_out, walk.segment.t_out);
      if (t_in <= t_out && !region(t_in, t_out)) return;
    }
  }

  std::optional<Found> find(double t) const {
    const Vec3 p = ray_.at(t);
    std::optional<Found> found;
    if (view_.has_clusters()) {
      const double unit = view_.clusters().box_unit;
      look_around({p[0] / unit, p[1] / unit, p[2] / unit}, view_.clusters().shape.top_level(), 0, p, found);
    } else {
      const Vec3 p_lattice = ray_lattice_.at(t);
      Index3 leaf;
      for (int a = 0; a < 3; ++a)
        leaf[a] = static_cast<std::int64_t>(
            std::clamp(std::floor(p_lattice[a]), 0.0, static_cast<double>(lattice().leaf_count[a] - 1)));
      for (const std::uint32_t tet : view_.tetrahedra_at(leaf)) look_into(tet, p, found);
    }
    return found;
  }

  /// Searches the cells of the clusters below a block whose boxes contain the point, or nearly. A
  /// point with weights of at least -slack may be up to three slacks of the box outside it.
  /// @param p_box  the point, in units of the boxes
  void look_around(const std::array<double, 3>& p_box, int level, std::uint64_t block, const Vec3& p,
                   std::optional<Found>& found) const {
    const formats::CellClustersView& clusters = view_.clusters();
    const formats::BoxBlock& boxes = clusters.boxes[static_cast<std::size_t>(level)][block];
    std::array<bool, BoxRay::width> holds;
    holds.fill(true);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t e = 0; e < BoxRay::width; ++e) {
        const double lo = static_cast<double>(boxes.lo[axis][e]), hi = static_cast<double>(boxes.hi[axis][e]);
        const double beside = 4 * default_tet_slack * (hi - lo);
        holds[e] = holds[e] && lo - beside <= p_box[axis] && p_box[axis] <= hi + beside;
      }
    for (std::size_t e = 0; e < BoxRay::width; ++e) {
      if (!holds[e]) continue;
      const std::uint64_t entry = block * BoxRay::width + e;
      if (level > 0)
        look_around(p_box, level - 1, entry, p, found);
      else
        for (std::uint64_t tet = clusters.first_cell(entry); tet < clusters.end_cell(entry); ++tet)
          look_into(static_cast<std::uint32_t>(tet), p, found);
    }
  }

  RHORAY_INLINE void look_into(std::uint32_t tet, const Vec3& p, std::optional<Found>& found) const {
    if (found && !is_preferred(view_, tet, found->tet)) return;
    if (double value; find_value_in(tet, p, value)) found = {tet, value};
  }

  /// False when the tetrahedron does not contain the point or has no data.
  RHORAY_INLINE bool find_value_in(std::uint32_t tet, const Vec3& p, double& value) const {
    const auto vertices = view_.sorted_vertices(tet);
    const std::array<double, 4> w = barycentric(view_.points_at(vertices), p);
    // Written so that a NaN fails too: the weights of a flat tetrahedron are NaN. One decision is
    // faster than four that are hard to predict.
    const auto is_inside = [](double weight) { return static_cast<int>(weight >= -default_tet_slack); };
    if (!(is_inside(w[0]) & is_inside(w[1]) & is_inside(w[2]) & is_inside(w[3]))) return false;
    const TetValues values = view_.values_at(vertices);
    if (!has_data(values)) return false;
    value = w[0] * values[0] + w[1] * values[1] + w[2] * values[2] + w[3] * values[3];
    return true;
  }

  RHORAY_INLINE static std::array<double, 4> barycentric(const TetPoints& points, const Vec3& p) {
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

}  // namespace

}  // namespace rhoray::render
