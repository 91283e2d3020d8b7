#include "render/frame/slices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/traverse/plane_time.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 0x1p-44;  // for sums of a few numbers: 512 units in the last place

/// True if two planes are the same, up to rounding.
bool is_same_plane(const HalfSpace& a, const HalfSpace& b) {
  const Vec3 normal_a = a.normal.normalized(), normal_b = b.normal.normalized();
  return normal_a.cross(normal_b).length() <= 0x1p-45 &&
         std::abs(normal_a.dot(b.point - a.point)) <= 0x1p-45 * (a.point.length() + b.point.length());
}

/// Returns the region's face that coincides with the plane, or the plane itself.
HalfSpace face_or(const HalfSpace& plane, const std::optional<Clip>& clip) {
  if (clip)
    for (const HalfSpace& half : half_spaces_of(*clip))
      if (is_same_plane(half, plane)) return half;
  return plane;
}

}  // namespace

SlicePlane::SlicePlane(const LoadedDataset& dataset, const Layer& layer, const std::optional<Clip>& clip,
                       Machine machine)
    : dataset_(dataset), threshold_(layer.threshold), lookup_(dataset, machine) {
  const HalfSpace plane = face_or(layer.plane, clip);
  point_ = plane.point, normal_ = plane.normal;
  const Affine &world_from_data = dataset.world_from_data, data_from_world = world_from_data.inverse();
  point_data_ = data_from_world.point(point_);
  normal_data_ = {normal_.dot(world_from_data.x_axis), normal_.dot(world_from_data.y_axis),
                  normal_.dot(world_from_data.z_axis)};
  for (int axis = 0; axis < 3; ++axis)
    slack_[axis] =
        rounding *
        (std::abs(data_from_world.origin[axis]) + std::abs(data_from_world.x_axis[axis] * point_.x) +
         std::abs(data_from_world.y_axis[axis] * point_.y) + std::abs(data_from_world.z_axis[axis] * point_.z));
}

SurfaceBoxes SlicePlane::boxes() const {
  const Box3& bounds = dataset_.bounds_data;
  Box3 part = part_of_plane({.point = point_data_, .normal = normal_data_}, bounds);
  if (part.isEmpty()) return {};
  const Vec3 more = Vec3(0x1p-20 * bounds.size().length()) + slack_;
  part.min -= more, part.max += more;
  return box_around(part);
}

bool SlicePlane::find_times(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts, std::size_t first,
                            double* t) const {
  bool any = false;
  for (std::size_t i = 0; i < group_size; ++i) {
    const std::size_t r = first + i;
    const Vec3 origin(in_world.origin[0][r], in_world.origin[1][r], in_world.origin[2][r]),
        direction(in_world.direction[0][r], in_world.direction[1][r], in_world.direction[2][r]);
    const double at = passage_of(point_, normal_, origin, direction).t;
    bool is_asked = r < rays.count && at >= rays.t_min[r] && at <= rays.t_max[r];
    if (parts.begin != nullptr && r < rays.count)
      is_asked = is_asked || (at >= parts.begin[r] && (parts.end == nullptr || at <= parts.end[r]));
    t[i] = is_asked && at < infinity ? at : infinity;
    any |= t[i] < infinity;
  }
  return any;
}

std::uint64_t SlicePlane::ask(const RayBatch& rays, const RayBatch& in_world, const SecondParts& parts,
                              HitBatch& hits) const {
  std::uint64_t asked = 0;
  PlacesInPlane places;
  places.normal = normal_data_, places.offset = normal_data_.dot(point_data_);
  PlaceAnswers answers;
  for (std::size_t first = 0; first < rays.count; first += group_size) {
    double t[group_size];
    const bool any = find_times(rays, in_world, parts, first, t);
    std::fill_n(answers.value, group_size, std::numeric_limits<double>::quiet_NaN());
    std::fill_n(answers.cost, group_size, 0U);
    if (any) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double largest = 0;
        for (std::size_t i = 0; i < group_size; ++i) {
          const double way = t[i] < infinity ? t[i] * rays.direction[axis][first + i] : 0;
          places.at[axis][i] = rays.origin[axis][first + i] + way;
          if (t[i] < infinity) largest = std::max(largest, std::abs(rays.origin[axis][first + i]) + std::abs(way));
        }
        places.slack[axis] = slack_[static_cast<int>(axis)] + rounding * largest;
      }
      for (std::size_t i = 0; i < group_size; ++i) {
        places.is_asked[i] = t[i] < infinity;
        asked += places.is_asked[i];
      }
      lookup_(places, answers);
    }
    for (std::size_t i = 0; i < group_size && first + i < rays.count; ++i) {
      const bool is_shown = threshold_.contains(answers.value[i]);  // false for a NaN
      hits.set(first + i, {.t = is_shown ? t[i] : infinity,
                           .value = answers.value[i],
                           .cell = is_shown ? answers.cell[i] : 0,
                           .tet = is_shown ? answers.tet[i] : 0,
                           .gradient = normal_data_,
                           .cost = answers.cost[i]});
    }
  }
  return asked;
}

}  // namespace rhoray::render
