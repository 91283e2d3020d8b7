// Rays of a chunk that are asked about together: their lines in the frame of the facets, and what bounds the lines of
// them all.
#if defined(RHORAY_WIDE_FACET_GROUP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_GROUP_INL_H
#undef RHORAY_WIDE_FACET_GROUP_INL_H
#else
#define RHORAY_WIDE_FACET_GROUP_INL_H
#endif

#include <bit>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "render/kernels/wide/facet_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The rays of a chunk that move most along one axis, one way; of these, some lanes at a time.
class FacetGroup {
 public:
  HWY_INLINE FacetGroup(const FacetSurface& of_surface, const RayArrays& of_rays, std::size_t count, int axis,
                        bool down, FacetScratch& memory)
      : surface(of_surface),
        rays(of_rays),
        scratch(memory),
        ray_count(count),
        axis_u((axis + 1) % 3),
        axis_v((axis + 2) % 3),
        axis_w(axis),
        sign(down ? -1.0f : 1.0f) {
    describe_rays();
  }

  /// Makes these lanes, and no others, ready, and bounds the places of their rays.
  template <FacetSearch search>
  void begin(std::uint64_t lanes_alive) {
    const VecF none = hn::Set(floats, -beyond);
    float first = beyond, last = -beyond, last_begin = -beyond, first_end = beyond;
    for (std::size_t r = 0; r < lanes; r += float_lanes) {
      const MaskF alive = alive_in(lanes_alive, r);
      const VecF begin = hn::Load(floats, scratch.begin + r), end = hn::Load(floats, scratch.end + r);
      hn::Store(hn::IfThenElse(alive, end, none), floats, scratch.depth + r);
      if constexpr (search != FacetSearch::any)
        hn::Store(hn::Set(ints, FacetScratch::no_facet), ints, scratch.facet + r);
      if constexpr (search == FacetSearch::certified) {
        hn::Store(hn::IfThenElse(alive, end, none), floats, scratch.far + r);
        hn::Store(hn::Set(floats, never), floats, scratch.nearest + r);
        hn::Store(hn::Set(floats, never), floats, scratch.second + r);
        hn::Store(hn::Set(floats, never), floats, scratch.doubt + r);
      }
      const float least = least_of(hn::IfThenElse(alive, begin, hn::Set(floats, beyond)));
      const float most = largest_of(hn::IfThenElse(alive, end, none));
      first = least < first ? least : first, last = most > last ? most : last;
      if constexpr (search == FacetSearch::any) {
        const float begins = largest_of(hn::IfThenElse(alive, begin, none));
        const float ends = least_of(hn::IfThenElse(alive, end, hn::Set(floats, beyond)));
        last_begin = begins > last_begin ? begins : last_begin, first_end = ends < first_end ? ends : first_end;
      }
    }
    all_from = last_begin, all_to = first_end;
    // The part of the facets' box, along w, in which there are rays.
    first -= bound_margin, last += bound_margin;
    const bool down = sign < 0;
    const float low = down ? -last : first, high = down ? -first : last;
    w_from = surface.low[axis_w] > low ? surface.low[axis_w] : low;
    w_to = surface.high[axis_w] < high ? surface.high[axis_w] : high;
    if (has_facets()) bound_places(lanes_alive);
  }

  /// False where no facet lies between the depths at which the group's rays begin and end.
  HWY_INLINE bool has_facets() const { return surface.facet_count != 0 && w_from <= w_to; }

  /// False when the rays lie so far apart that most of what one meets is met by no other; reckoned with facets spread
  /// evenly over their box.
  HWY_INLINE bool is_narrow(std::uint64_t lanes_alive) const {
    if ((lanes_alive & (lanes_alive - 1)) == 0 || !has_facets()) return true;
    float share = 1;
    for (int m = 0; m < 2; ++m) {
      const int axis = m == 0 ? axis_u : axis_v;
      const float size = surface.high[axis] - surface.low[axis] + bound_margin;
      const float at_low = group_at_low_[2 * m] + group_at_low_[2 * m + 1];
      const float at_high = group_at_high_[2 * m] + group_at_high_[2 * m + 1];
      const float width = (at_low > at_high ? at_low : at_high) / size;
      share *= width < 1 ? width : 1;
    }
    constexpr float facets_per_ray = 24;
    return share * static_cast<float>(surface.facet_count) <=
           facets_per_ray * static_cast<float>(std::popcount(lanes_alive));
  }

  /// How far rays of a pack, and of the group, are still to be followed.
  template <FacetSearch search>
  HWY_INLINE void find_pack_far(std::size_t p) {
    const float* reach = search == FacetSearch::certified ? scratch.far : scratch.depth;
    VecF most = hn::Load(floats, reach + pack * p);
    for (std::size_t i = float_lanes; i < pack; i += float_lanes)
      most = hn::Max(most, hn::Load(floats, reach + pack * p + i));
    scratch.pack_far[p] = largest_of(most) + (search == FacetSearch::certified ? 2 * place_error : 0);
  }
  HWY_INLINE void find_group_far() {
    far = scratch.pack_far[0];
    for (std::size_t p = 1; p < packs; ++p) far = scratch.pack_far[p] > far ? scratch.pack_far[p] : far;
  }

  const FacetSurface& surface;
  const RayArrays& rays;
  FacetScratch& scratch;
  const std::size_t ray_count;  ///< of the chunk's rays
  const int axis_u, axis_v, axis_w;
  const float sign;                     ///< depth = sign w
  float w_from = 0, w_to = 0;           ///< the part of the facets' box in which there are rays
  float line_offset[4], line_slope[4];  ///< bounds of all rays' places, as bound_places says
  float far = 0;
  float all_from = 0, all_to = 0;  ///< any: the depths that lie between the ends of all rays
  std::uint64_t crossed = 0;       ///< any: lanes that have met a facet
  Unanswered unanswered;

 private:
  /// Of all rays of the chunk, as if all moved along this axis; those that do not, stay without hits.
  HWY_INLINE void describe_rays() {
    HWY_ALIGN float slope[2][lanes], shift[2][lanes], begin[lanes], end[lanes];
    const VecD scale = hn::Set(doubles, surface.scale);
    const VecD towards = hn::Set(doubles, static_cast<double>(sign));
    const int minor[2] = {axis_u, axis_v};
    for (std::size_t r = 0; r < ray_count; r += double_lanes) {
      const VecD d = hn::Load(doubles, rays.direction[axis_w] + r);
      const VecD inverse = hn::Div(hn::Set(doubles, 1.0), d);
      const auto start = [&](int axis) HWY_ATTR {
        return hn::Mul(hn::Sub(hn::Load(doubles, rays.origin[axis] + r), hn::Set(doubles, surface.anchor[axis])),
                       scale);
      };
      const VecD w = start(axis_w);
      for (int m = 0; m < 2; ++m) {
        const VecD s = hn::Mul(hn::Load(doubles, rays.direction[minor[m]] + r), inverse);
        store(s, slope[m] + r);
        store(hn::Sub(start(minor[m]), hn::Mul(s, w)), shift[m] + r);
      }
      const VecD speed = hn::Mul(d, scale);
      store(hn::Mul(towards, hn::MulAdd(hn::Load(doubles, rays.t_min + r), speed, w)), begin + r);
      store(hn::Mul(towards, hn::MulAdd(hn::Load(doubles, rays.t_max + r), speed, w)), end + r);
    }
    if (rays.start_side != nullptr)
      for (std::size_t r = 0; r < ray_count; ++r)
        scratch.start_side[lane_of(r)] = static_cast<float>(rays.start_side[r]);
    for (std::size_t quad = 0; 4 * quad < ray_count; ++quad) {
      const auto place = [&](const float* from, float* to)
                             HWY_ATTR { std::memcpy(to + lane_of(4 * quad), from + 4 * quad, 4 * sizeof(float)); };
      for (int m = 0; m < 2; ++m) place(slope[m], scratch.slope[m]), place(shift[m], scratch.shift[m]);
      place(begin, scratch.begin), place(end, scratch.end);
    }
  }

  /// Numbers too large for floats become large ones.
  HWY_INLINE static void store(VecD v, float* to) {
    const VecD largest = hn::Set(doubles, static_cast<double>(beyond));
    hn::StoreU(hn::DemoteTo(half_floats, hn::Max(hn::Min(v, largest), hn::Neg(largest))), half_floats, to);
  }

  HWY_INLINE MaskF alive_in(std::uint64_t lanes_alive, std::size_t lane) const {
    return mask_of(floats, lanes_alive >> lane);
  }

  /// Lines that the places of each pack's rays keep between, and the group's: u at w is at least -(offset + slope w) by
  /// the first of four, at most offset + slope w by the second; v by the others. The least of linear functions lies
  /// above the straight line between any two of its values.
  HWY_INLINE void bound_places(std::uint64_t lanes_alive) {
    HWY_ALIGN float at_low[lanes / 4], at_high[lanes / 4];
    const VecF w_low = hn::Set(floats, w_from), w_high = hn::Set(floats, w_to);
    for (std::size_t p = 0; p < packs; ++p) {
      float* bound[2] = {at_low + 4 * p, at_high + 4 * p};
      if ((lanes_alive >> pack * p & pack_bits) == 0) {
        for (int l = 0; l < 4; ++l) bound[0][l] = bound[1][l] = -beyond;
        continue;
      }
      for (int m = 0; m < 2; ++m) {
        VecF least[2], most[2];
        for (int e = 0; e < 2; ++e) least[e] = hn::Set(floats, beyond), most[e] = hn::Set(floats, -beyond);
        for (std::size_t i = 0; i < pack; i += float_lanes) {
          const std::size_t r = pack * p + i;
          const MaskF alive = alive_in(lanes_alive, r);
          const VecF slope = hn::Load(floats, scratch.slope[m] + r), shift = hn::Load(floats, scratch.shift[m] + r);
          for (int e = 0; e < 2; ++e) {
            const VecF place = hn::MulAdd(slope, e == 0 ? w_low : w_high, shift);
            least[e] = hn::Min(least[e], hn::IfThenElse(alive, place, least[e]));
            most[e] = hn::Max(most[e], hn::IfThenElse(alive, place, most[e]));
          }
        }
        for (int e = 0; e < 2; ++e) {
          bound[e][2 * m] = bound_margin - least_of(least[e]);
          bound[e][2 * m + 1] = bound_margin + largest_of(most[e]);
        }
      }
    }
    for (int l = 0; l < 4; ++l) {
      group_at_low_[l] = group_at_high_[l] = -beyond;
      for (std::size_t p = 0; p < packs; ++p) {
        const float low = at_low[4 * p + static_cast<std::size_t>(l)],
                    high = at_high[4 * p + static_cast<std::size_t>(l)];
        group_at_low_[l] = low > group_at_low_[l] ? low : group_at_low_[l];
        group_at_high_[l] = high > group_at_high_[l] ? high : group_at_high_[l];
      }
    }
    // Over a short way a slope would be lost in rounding: there the bounds are constant.
    const bool is_short = w_to - w_from < 0x1p-8f;
    const VecF inverse = hn::Set(floats, is_short ? 0.0f : 1 / (w_to - w_from));
    for (std::size_t i = 0; i < lanes / 4; i += float_lanes) {
      const VecF low = hn::Load(floats, at_low + i), high = hn::Load(floats, at_high + i);
      const VecF slope = hn::Mul(hn::Sub(high, low), inverse);
      const VecF base = is_short ? hn::Max(low, high) : low;
      hn::Store(slope, floats, scratch.cull_slope + i);
      hn::Store(hn::NegMulAdd(slope, w_low, base), floats, scratch.cull_offset + i);
    }
    for (int l = 0; l < 4; ++l) {
      const float low = group_at_low_[l], high = group_at_high_[l];
      line_slope[l] = is_short ? 0.0f : (high - low) / (w_to - w_from);
      line_offset[l] = (is_short && high > low ? high : low) - line_slope[l] * w_from;
    }
  }

  float group_at_low_[4], group_at_high_[4];
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
