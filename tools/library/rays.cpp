#include "tools/library/rays.h"

#include <algorithm>
#include <limits>

#include "tools/library/conversions.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

RayScratch::RayScratch(std::optional<Machine> machine)
    : implementation_(std::make_unique<Implementation>(inside::machine_of(machine, "RayScratch"))) {}
RayScratch::~RayScratch() = default;
RayScratch::RayScratch(RayScratch&&) noexcept = default;
RayScratch& RayScratch::operator=(RayScratch&&) noexcept = default;

namespace inside {

namespace {

/// Refuses a limit of a ray that is not a number.
void require_limits(const ArrayView& limits, std::string_view name, std::int64_t count) {
  if (!limits.is_given()) return;
  require_floats(limits, name, count, 0);
  for (std::int64_t ray = 0; ray < count; ++ray)
    if (std::isnan(number(limits, ray))) refuse(name, "[", ray, "]: NaN; expected a number");
}

double largest_of(const rhoray::Vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The largest number of a map's axes.
double largest_of(const rhoray::Affine& map) {
  return std::max({largest_of(map.x_axis), largest_of(map.y_axis), largest_of(map.z_axis)});
}

/// The range of rays (rhoray::Rays), in the frame of the data. Within it rays leave the data at
/// times up to about 1e260. The kernels of grids would end them at 2^959
/// (render/traverse/group-inl.h, clip_group).
constexpr double farthest_start = 1e150, shortest_direction = 1e-110, longest_direction = 1e110;

/// Finds rays that are out of range.
class RangeOfRays {
 public:
  explicit RangeOfRays(const rhoray::Affine& data_from_world)
      : data_from_world_(data_from_world),
        surely_near_((farthest_start - largest_of(data_from_world.origin)) / (3 * largest_of(data_from_world))),
        surely_long_(shortest_direction * 3 * largest_of(data_from_world.inverse())),
        surely_short_(longest_direction / (3 * largest_of(data_from_world))) {}

  // Nearly all rays are found in range without being moved to the frame of the data.
  bool holds_start(const rhoray::Vec3& p) const {
    return largest_of(p) <= surely_near_ || largest_of(data_from_world_.point(p)) <= farthest_start;
  }
  bool holds_direction(const rhoray::Vec3& d) const {
    const double length = largest_of(d);
    if (length >= surely_long_ && length <= surely_short_) return true;
    const double in_data = largest_of(data_from_world_.vector(d));
    return in_data >= shortest_direction && in_data <= longest_direction;
  }

 private:
  rhoray::Affine data_from_world_;
  /// Rays within these bounds, in world axes, are in range, however the data are rotated.
  double surely_near_, surely_long_, surely_short_;
};

}  // namespace

CheckedRays::CheckedRays(const Rays& rays, const render::Dataset& dataset)
    : rays_(rays), data_from_world_(render::world_from_ray_frame(dataset).inverse()) {
  const RangeOfRays range(data_from_world_);
  const char* const unit = dataset.is_mesh() || dataset.is_surface() ? "units" : "cells";
  require_floats(rays.origins, "Rays::origins", -1, 3);
  count_ = rays.origins.shape()[0];
  require_floats(rays.directions, "Rays::directions", count_, 3);
  for (std::int64_t ray = 0; ray < count_; ++ray) {
    if (const Vec3 v = vector(rays.origins, ray); !is_finite(v))
      refuse("Rays::origins[", ray, "]: (", v.x, ", ", v.y, ", ", v.z, "); expected finite numbers");
    else if (!range.holds_start(inside_of(v)))
      refuse("Rays::origins[", ray, "]: (", v.x, ", ", v.y, ", ", v.z, ") is too far from the data; expected at most ",
             farthest_start, " ", unit);
    if (const Vec3 v = vector(rays.directions, ray); !is_finite(v) || v == Vec3{})
      refuse("Rays::directions[", ray, "]: (", v.x, ", ", v.y, ", ", v.z, "); expected a finite direction, not 0");
    else if (!range.holds_direction(inside_of(v)))
      refuse("Rays::directions[", ray, "]: (", v.x, ", ", v.y, ", ", v.z, "); expected a length between ",
             shortest_direction, " and ", longest_direction, " ", unit);
  }
  require_limits(rays.t_min, "Rays::t_min", count_);
  require_limits(rays.t_max, "Rays::t_max", count_);
}

render::Ray CheckedRays::operator[](std::int64_t ray) const {
  render::Ray out{.origin = data_from_world_.point(inside_of(vector(rays_.origins, ray))),
                  .direction = data_from_world_.vector(inside_of(vector(rays_.directions, ray)))};
  if (rays_.t_min.is_given()) out.t_min = number(rays_.t_min, ray);
  if (rays_.t_max.is_given()) out.t_max = number(rays_.t_max, ray);
  return out;
}

void check(const Hits& hits, std::int64_t count, bool proves_errors) {
  const auto rays = static_cast<std::size_t>(count);
  struct Row {
    std::string_view name;
    std::size_t found, expected;
  };
  for (const auto& [name, found, expected] : {Row{"t", hits.t.size(), rays},
                                              {"error", hits.error.size(), rays},
                                              {"value", hits.value.size(), rays},
                                              {"gradient", hits.gradient.size(), 3 * rays},
                                              {"cell", hits.cell.size(), rays}})
    if (found != 0 && found != expected)
      refuse("Hits::", name, ": ", found, " elements; expected ", expected, " for ", count, " rays, or none");
  if (!hits.error.empty() && !proves_errors)
    refuse("Hits::error: the method proves no errors; expected certified or exact, or no array");
}

void write(std::span<const render::Hit> from, std::int64_t first, const rhoray::Affine& world_from_data,
           bool has_gradient, bool has_value, const Hits& hits) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const render::Hit& hit = from[i];
    const std::size_t ray = static_cast<std::size_t>(first) + i;
    const bool is_miss = hit.is_miss();
    if (!hits.t.empty()) hits.t[ray] = hit.t;
    if (!hits.error.empty()) hits.error[ray] = is_miss ? nan : hit.error;
    if (!hits.value.empty()) hits.value[ray] = is_miss || !has_value ? nan : hit.value;
    if (!hits.cell.empty()) hits.cell[ray] = is_miss ? no_cell : hit.cell;
    if (hits.gradient.empty()) continue;
    const rhoray::Vec3 gradient =
        is_miss || !has_gradient ? rhoray::Vec3(0, 0, 0) : world_from_data.gradient(hit.gradient);
    for (int axis = 0; axis < 3; ++axis) hits.gradient[3 * ray + static_cast<std::size_t>(axis)] = gradient[axis];
  }
}

}  // namespace inside

}  // namespace rhoray::v0_1
