#include "render/frame/light_rays.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "render/query/compiled_for.h"
#include "render/shade/facing.h"

namespace rhoray::render {

namespace {

constexpr std::size_t group_size = RayBatch::group_size;

/// Packs bytes that are 0 or 1 into bits.
RHORAY_INLINE std::uint64_t bits_of(const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < group_size; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes + i, 8);
    bits |= (eight * 0x0102'0408'1020'4080) >> 56 << i;
  }
  return bits;
}

/// Dot products of gradients, scaled to avoid overflow and underflow, with vectors of the dataset's
/// frame.
/// @param vectors  (ray of the group)
template <class Vectors>
RHORAY_INLINE void multiply_gradients(const HitBatch& hits, std::size_t first, const Vectors& vectors,
                                      double* product) {
  const double *gx = hits.gradient[0].data() + first, *gy = hits.gradient[1].data() + first,
               *gz = hits.gradient[2].data() + first;
  for (std::size_t i = 0; i < group_size; ++i) product[i] = Facing::scaled({gx[i], gy[i], gz[i]}).dot(vectors(i));
}

/// First rays of groups.
struct Groups {
  const std::size_t* first;
  std::size_t count;
};

RHORAY_INLINE void find_sides_inline(const LayerWork& work, const Groups& groups, StartSide* side) {
  for (std::size_t g = 0; g < groups.count; ++g) {
    const std::size_t first = groups.first[g];
    const double *x = work.rays.direction[0].data() + first, *y = work.rays.direction[1].data() + first,
                 *z = work.rays.direction[2].data() + first;
    double along[group_size];
    multiply_gradients(
        work.hits, first, [=](std::size_t i) { return Vec3(x[i], y[i], z[i]); }, along);
    for (std::size_t i = 0; i < group_size; ++i)
      side[first + i] = static_cast<StartSide>((along[i] < 0) - (along[i] > 0));
  }
}

RHORAY_INLINE void ask_before_surfaces_inline(const Affine& data_from_world, const LayerWork& work,
                                              const Groups& groups, LightRays& light, bool& any_unknown) {
  const Affine map = data_from_world;
  for (std::size_t g = 0; g < groups.count; ++g) {
    const std::size_t first = groups.first[g];
    const double *x = light.direction[0].data() + first, *y = light.direction[1].data() + first,
                 *z = light.direction[2].data() + first;
    double towards[group_size];
    multiply_gradients(
        work.hits, first,
        [&](std::size_t i) {
          return map.vector({x[i], y[i], z[i]});
        },
        towards);
    const StartSide* side = light.side.data() + first;
    const std::uint8_t* is_shown = light.is_shown.data() + first;
    double* t_max = light.t_max.data() + first;
    std::uint8_t unknown[group_size];
    for (std::size_t i = 0; i < group_size; ++i) {
      const bool is_before = towards[i] * static_cast<double>(side[i]) > 0, is_known = side[i] != StartSide::unknown;
      t_max[i] = (is_shown[i] != 0) & (is_before | !is_known) ? t_max[i] : not_asked;
      unknown[i] = (is_shown[i] != 0) & !is_known;
    }
    any_unknown |= bits_of(unknown) != 0;
  }
}

RHORAY_INLINE void find_asked_inline(const LightRays& light, const Groups& groups, RaysBySide* asked) {
  for (std::size_t g = 0; g < groups.count; ++g) {
    const double* t_max = light.t_max.data() + groups.first[g];
    const StartSide* side = light.side.data() + groups.first[g];
    for (const StartSide of : {StartSide::outside, StartSide::unknown, StartSide::inside}) {
      std::uint8_t is_asked[group_size];
      for (std::size_t i = 0; i < group_size; ++i) is_asked[i] = (t_max[i] >= 0) & (side[i] == of);
      asked[g][place_of(of)] = bits_of(is_asked);
    }
  }
}

RHORAY_INLINE void count_inline(const LightRays& light, const Groups& groups, std::uint64_t& count) {
  for (std::size_t g = 0; g < groups.count; ++g) {
    const double* t_max = light.t_max.data() + groups.first[g];
    std::uint64_t here = 0;
    for (std::size_t i = 0; i < group_size; ++i) here += t_max[i] >= 0;
    count += here;
  }
}

RHORAY_INLINE void share_inline(const LightRays& light, const Groups& groups, float* shares) {
  for (std::size_t g = 0; g < groups.count; ++g) {
    const double* t_max = light.t_max.data() + groups.first[g];
    float* out = shares + groups.first[g];
    for (std::size_t i = 0; i < group_size; ++i) out[i] = t_max[i] >= 0 ? 1 : 0;
  }
}

RHORAY_INLINE void write_inline(const LightRays& light, const GroupToWrite& group, const Affine& data_from_world,
                                const HitBatch& hits, const RayBatch& eye_rays, RayBatch& rays) {
  const std::size_t first = group.first, place = group.place;
  const double *hit_t = hits.t.data() + first, *t_max = light.t_max.data() + first;
  double t[group_size];
  for (std::size_t i = 0; i < group_size; ++i) t[i] = t_max[i] >= 0 ? hit_t[i] : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double *origin = eye_rays.origin[axis].data() + first, *direction = eye_rays.direction[axis].data() + first;
    double* out = rays.origin[axis].data() + place;
    for (std::size_t i = 0; i < group_size; ++i) out[i] = origin[i] + t[i] * direction[i];
  }
  const double *x = light.direction[0].data() + first, *y = light.direction[1].data() + first,
               *z = light.direction[2].data() + first;
  for (int axis = 0; axis < 3; ++axis) {
    const double of_x = data_from_world.x_axis[axis], of_y = data_from_world.y_axis[axis],
                 of_z = data_from_world.z_axis[axis];
    double* out = rays.direction[axis].data() + place;
    for (std::size_t i = 0; i < group_size; ++i) out[i] = x[i] * of_x + y[i] * of_y + z[i] * of_z;
  }
  const StartSide* side = light.side.data() + first;
  double *out_min = rays.t_min.data() + place, *out_max = rays.t_max.data() + place;
  StartSide* out_side = rays.start_side.data() + place;
  const StartSide outside = group.side_of[0], unknown = group.side_of[1], inside = group.side_of[2];
  for (std::size_t i = 0; i < group_size; ++i) {
    out_min[i] = 0;
    out_max[i] = (group.chosen >> i & 1) != 0 ? t_max[i] : not_asked;
  }
  for (std::size_t i = 0; i < group_size; ++i)
    out_side[i] = side[i] == StartSide::outside ? outside : side[i] == StartSide::inside ? inside : unknown;
}

Groups shown_in(const LightRays& light) {
  return {light.shown.data(), light.shown.size()};
}

}  // namespace

void find_shown_groups(std::size_t count, LightRays& light) {
  light.shown.clear();
  for (std::size_t first = 0; first < count; first += group_size)
    if (bits_of(light.is_shown.data() + first) != 0) light.shown.push_back(first);
}

void find_sides_by_gradient(Machine machine, const LayerWork& work, LightRays& light) {
  compiled_for<find_sides_inline>(machine)(work, shown_in(light), light.side.data());
}

void aim_all(const Vec3& direction, LightRays& light) {
  for (const std::size_t first : light.shown) {
    for (int axis = 0; axis < 3; ++axis) std::fill_n(light.direction[axis].data() + first, group_size, direction[axis]);
    std::fill_n(light.t_max.data() + first, group_size, std::numeric_limits<double>::infinity());
  }
}

bool ask_before_surfaces(Machine machine, const Affine& data_from_world, const LayerWork& work, LightRays& light) {
  bool any_unknown = false;
  compiled_for<ask_before_surfaces_inline>(machine)(data_from_world, work, shown_in(light), light, any_unknown);
  return any_unknown;
}

void find_asked(Machine machine, const LightRays& light, RaysBySide* asked) {
  compiled_for<find_asked_inline>(machine)(light, shown_in(light), asked);
}

std::uint64_t asked_count(Machine machine, const LightRays& light) {
  std::uint64_t count = 0;
  compiled_for<count_inline>(machine)(light, shown_in(light), count);
  return count;
}

void share_of_asked(Machine machine, const LightRays& light, float* shares) {
  compiled_for<share_inline>(machine)(light, shown_in(light), shares);
}

void write_light_rays(Machine machine, const LightRays& light, const GroupToWrite& group, const Affine& data_from_world,
                      const HitBatch& hits, const RayBatch& eye_rays, RayBatch& rays) {
  compiled_for<write_inline>(machine)(light, group, data_from_world, hits, eye_rays, rays);
}

}  // namespace rhoray::render
