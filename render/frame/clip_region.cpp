#include "render/frame/clip_region.h"

#include <cmath>
#include <limits>

#include "render/query/compiled_for.h"
#include "render/traverse/plane_time.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();

double magnitude(const Vec3& v) {
  return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

}  // namespace

ClipRegion::ClipRegion(const Clip& clip, Machine machine)
    : halves_(half_spaces_of(clip)), cuts_away_(clip.cuts_away), machine_(machine) {}

RHORAY_INLINE void ClipRegion::find_spans_inline(const ClipRegion& region, const RayBatch& rays, double* from,
                                                 double* to) {
  for (std::size_t first = 0; first < rays.count; first += group_size) {
    const double *ox = rays.origin[0].data() + first, *oy = rays.origin[1].data() + first,
                 *oz = rays.origin[2].data() + first, *dx = rays.direction[0].data() + first,
                 *dy = rays.direction[1].data() + first, *dz = rays.direction[2].data() + first;
    double low[group_size], high[group_size];
    for (std::size_t i = 0; i < group_size; ++i) low[i] = -infinity, high[i] = infinity;
    for (const HalfSpace& half : region.halves_) {
      const Vec3 point = half.point, normal = half.normal;
      for (std::size_t i = 0; i < group_size; ++i) {
        const PlanePassage passage = passage_of(point, normal, Vec3(ox[i], oy[i], oz[i]), Vec3(dx[i], dy[i], dz[i]));
        const bool enters = passage.along > 0, leaves = passage.along < 0;
        const bool stays_out = !enters && !leaves && passage.ahead > 0;
        const double t_in = stays_out ? infinity : enters ? passage.t : -infinity;
        const double t_out = leaves ? passage.t : infinity;
        low[i] = t_in > low[i] ? t_in : low[i];
        high[i] = t_out < high[i] ? t_out : high[i];
      }
    }
    for (std::size_t i = 0; i < group_size; ++i) from[first + i] = low[i];
    for (std::size_t i = 0; i < group_size; ++i) to[first + i] = high[i];
  }
}

RHORAY_INLINE void ClipRegion::find_kept_inline(const ClipRegion& region, const RayBatch& rays, KeptParts& kept) {
  double *t_min = kept.t_min.data(), *t_max = kept.t_max.data(), *again = kept.again.data();
  find_spans_inline(region, rays, t_min, t_max);
  const std::size_t end = (rays.count + group_size - 1) / group_size * group_size;
  constexpr double never = -1;
  if (region.cuts_away_)
    for (std::size_t i = 0; i < end; ++i) {
      const double from = t_min[i], to = t_max[i];
      const bool is_cut = from <= to && to >= 0;
      t_min[i] = 0;
      t_max[i] = !is_cut ? infinity : from > 0 ? from : never;
      again[i] = is_cut ? to : infinity;
    }
  else
    for (std::size_t i = 0; i < end; ++i) {
      const double from = t_min[i] > 0 ? t_min[i] : 0, to = t_max[i];
      const bool is_left = from <= to && from < infinity;
      t_min[i] = is_left ? from : 0;
      t_max[i] = is_left ? to : never;
      again[i] = infinity;
    }
}

void ClipRegion::find_spans(const RayBatch& rays, double* from, double* to) const {
  compiled_for<find_spans_inline>(machine_)(*this, rays, from, to);
}

void ClipRegion::find_kept(const RayBatch& rays, KeptParts& kept) const {
  compiled_for<find_kept_inline>(machine_)(*this, rays, kept);
}

ClipRegion::InFrame::InFrame(const ClipRegion& region, const Affine& world_from_data, const SurfaceBoxes& boxes)
    : margin_(boxes.margin), cuts_away_(region.cuts_away_) {
  constexpr double rounding = 0x1p-40;
  const Affine& map = world_from_data;
  for (const HalfSpace& half : region.halves_) {
    const Vec3 normal = half.normal;
    const Vec3 in_data(normal.dot(map.x_axis), normal.dot(map.y_axis), normal.dot(map.z_axis));
    const double terms = magnitude(normal) * (magnitude(map.origin) + magnitude(half.point)) +
                         magnitude(normal) * (magnitude(map.x_axis) + magnitude(map.y_axis) + magnitude(map.z_axis)) *
                             magnitude(boxes.anchor);
    functions_.push_back({.factor = in_data * boxes.unit,
                          .constant = in_data.dot(boxes.anchor) + normal.dot(map.origin - half.point),
                          .slack = rounding * terms});
  }
}

bool ClipRegion::InFrame::takes_away(const BoxNode& node, std::size_t child) const {
  constexpr double rounding = 0x1p-40;
  bool lies_inside = true;
  for (const Function& function : functions_) {
    double least = function.constant, largest = function.constant, terms = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = static_cast<double>(node.low[axis][child]) - margin_,
                   high = static_cast<double>(node.high[axis][child]) + margin_, factor = function.factor[axis];
      least += factor * (factor > 0 ? low : high);
      largest += factor * (factor > 0 ? high : low);
      terms += std::abs(factor) * (std::abs(low) + std::abs(high));
    }
    const double slack = function.slack + rounding * terms;
    if (!cuts_away_ && largest < -slack) return true;
    lies_inside &= least > slack;
  }
  return cuts_away_ && lies_inside;
}

}  // namespace rhoray::render
