#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "render/cell/triangle_crossing.h"
#include "render/dataset/loaded_dataset.h"
#include "render/query/intersection_timer.h"
#include "render/query/kernels.h"
#include "render/triangles/facets.h"
#include "render/triangles/kernels/triangle_start.h"

/// First hits of rays with a surface's triangles: in double precision, one ray at a time.
namespace rhoray::render {

namespace {

/// Intersects a ray with the boxes of facets, in their frame.
class BoxPassage {
 public:
  BoxPassage(const Ray& ray, const Facets& facets)
      : origin_((ray.origin - facets.anchor()) * facets.scale()),
        direction_(ray.direction * facets.scale()),
        t_min_(ray.t_min) {
    for (int axis = 0; axis < 3; ++axis) {
      inverse_[axis] = 1 / direction_[axis];
      margin_[axis] = box_margin + 0x1p-48 * std::abs(origin_[axis]);
    }
  }

  /// Returns the t from which the ray is in a box of a node, widened by the margin; infinity when
  /// it misses.
  double enters(const BoxNode& node, std::size_t child) const {
    double t_in = t_min_, t_out = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double low = static_cast<double>(node.low[axis][child]) - margin_[axis];
      const double high = static_cast<double>(node.high[axis][child]) + margin_[axis];
      if (!std::isfinite(inverse_[axis])) {
        if (origin_[axis] < low || origin_[axis] > high) return std::numeric_limits<double>::infinity();
        continue;
      }
      const double a = (low - origin_[axis]) * inverse_[axis], b = (high - origin_[axis]) * inverse_[axis];
      t_in = std::max(t_in, std::min(a, b));
      t_out = std::min(t_out, std::max(a, b));
    }
    return t_in <= t_out ? t_in : std::numeric_limits<double>::infinity();
  }

 private:
  /// Corners of boxes are rounded to 2^-25 in this frame.
  static constexpr double box_margin = 0x1p-20;

  Vec3 origin_, direction_, inverse_, margin_;
  double t_min_;
};

/// Searches for the nearest triangle along one ray; of those at the same t the one with the lowest
/// index.
class FirstTriangle {
 public:
  FirstTriangle(const TriangleData& view, const Facets& facets, const RayQuery& query, const Ray& ray,
                KernelCounters& counters)
      : view_(view), facets_(facets), query_(query), ray_(ray), counters_(counters), shear_(ray) {}

  Hit find() {
    if (!query_.use_hierarchy)
      for (std::uint32_t triangle = 0; triangle < view_.triangle_count(); ++triangle) look_at(triangle);
    else
      walk();
    return hit_;
  }

 private:
  struct Entry {
    double t_in;
    std::uint32_t node;
    int level;  ///< -1: a block
  };

  void walk() {
    if (facets_.count() == 0) return;  // the boundary of a closed mesh has no tree
    const BoxPassage passage(ray_, facets_);
    Entry stack[(BoxNode::size - 1) * SurfaceBoxes::largest_level_count + 1];
    std::size_t top = 0;
    stack[top++] = {ray_.t_min, 0, facets_.level_count() - 1};
    while (top != 0) {
      const Entry entry = stack[--top];
      if (entry.t_in > nearest_box()) continue;
      if (entry.level < 0) {
        look_into(entry.node);
        continue;
      }
      ++counters_.macrocells_visited;
      const BoxNode& node = facets_.level(entry.level)[entry.node];
      const std::size_t bottom = top;
      for (std::uint32_t child = 0; child < BoxNode::size; ++child) {
        if (node.low[0][child] > node.high[0][child]) continue;
        const Entry added{passage.enters(node, child), BoxNode::size * entry.node + child, entry.level - 1};
        if (!(added.t_in < std::numeric_limits<double>::infinity()) || added.t_in > nearest_box()) continue;
        std::size_t place = top++;
        for (; place > bottom && stack[place - 1].t_in < added.t_in; --place) stack[place] = stack[place - 1];
        stack[place] = added;
      }
    }
  }

  /// Boxes that begin behind this t are skipped.
  double nearest_box() const { return hit_.is_miss() ? ray_.t_max : hit_.t; }

  void look_into(std::uint32_t block) {
    ++counters_.cells_visited;
    const IntersectionTimer timer(query_, counters_);
    const std::uint32_t first = block * FacetBlock::size;
    const std::uint32_t end = std::min(first + FacetBlock::size, facets_.count());
    for (std::uint32_t f = first; f < end; ++f) look_at(facets_.fields()[f].tet);
  }

  void look_at(std::uint32_t triangle) {
    ++counters_.cells_solved;
    const auto vertices = view_.vertices(triangle);
    const TrianglePoints points = view_.points_at(vertices);
    const std::optional<double> t = cross_triangle(shear_, points, vertices);
    if (!t || !(*t >= ray_.t_min && *t <= ray_.t_max)) return;
    if (*t > hit_.t || (*t == hit_.t && triangle > hit_.tet)) return;
    const Vec3 normal = triangle_normal(points);
    if (ray_.start_side != StartSide::unknown && starts_in(ray_, points[0], normal, start_distance / facets_.scale()))
      return;
    hit_.t = *t;
    hit_.value = std::numeric_limits<double>::quiet_NaN();
    hit_.cell = view_.cell_id(triangle);
    hit_.tet = triangle;
    hit_.gradient = normal;
    hit_.root_count = 1;
  }

  const TriangleData& view_;
  const Facets& facets_;
  const RayQuery& query_;
  const Ray& ray_;
  KernelCounters& counters_;
  RayShear shear_;
  Hit hit_;
};

/// False for rays that do not move, or are not finite.
bool is_ray(const Ray& ray) {
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(ray.origin[axis]) || !std::isfinite(ray.direction[axis])) return false;
  const Vec3& d = ray.direction;
  const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
  return largest > 0 && std::isfinite(1 / largest) && ray.t_min <= ray.t_max;
}

void first_triangles(const LoadedDataset& dataset, const RayQuery& query, const RayBatch& rays, HitBatch& hits,
                     KernelScratch& scratch) {
  const TriangleData& view = std::get<TriangleData>(dataset.view);
  const std::shared_ptr<const Facets> facets = dataset.facets->of(view, dataset.bounds_data, 0, 1, {});
  for (std::size_t r = 0; r < rays.count; ++r) {
    const std::uint64_t before = scratch.counters.visits();
    const Ray ray = rays[r];
    Hit hit = is_ray(ray) ? FirstTriangle(view, *facets, query, ray, scratch.counters).find() : Hit{};
    hit.cost = static_cast<std::uint32_t>(scratch.counters.visits() - before);
    hits.set(r, hit);
  }
}

/// A surface has no values.
void no_values(const LoadedDataset&, const RayQuery&, const RayBatch& rays, HitBatch& hits, KernelScratch&) {
  for (std::size_t r = 0; r < rays.count; ++r) hits.set(r, {});
}

}  // namespace

template <>
ReferenceKernels reference_kernels(const TriangleData&, Method::Algorithm) {
  return {.first_hit = first_triangles, .largest = no_values, .queue_entries = 0};
}

}  // namespace rhoray::render
