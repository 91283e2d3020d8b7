// Bounds of the lines of rays that are traced together, and the part of a surface inside these
// bounds.
#if defined(RHORAY_WIDE_FACET_BEAM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_BEAM_INL_H
#undef RHORAY_WIDE_FACET_BEAM_INL_H
#else
#define RHORAY_WIDE_FACET_BEAM_INL_H
#endif

#include <bit>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/triangles/kernels/facet_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Bounds of rays that share a major axis w and a direction along it. At w, u is at least -(offset
/// + slope w) by the first of four lines, and at most offset + slope w by the second; the other two
/// bound v.
struct FacetBeam {
  FacetBeam(int axis, bool down)
      : axis_u((axis + 1) % 3), axis_v((axis + 2) % 3), axis_w(axis), sign(down ? -1.0f : 1.0f) {}

  const int axis_u, axis_v, axis_w;
  const float sign;                     ///< depth = sign w
  float w_from = 0, w_to = 0;           ///< the part of the facets' box that contains rays
  float line_offset[4], line_slope[4];  ///< of all rays
  float far = 0;                        ///< the depth up to which they are still traced

  /// Restricts the facets' box to where there are rays.
  /// @param first, last  the depths between which all rays begin and end
  HWY_INLINE void cut(const FacetSurface& surface, float first, float last) {
    first -= bound_margin, last += bound_margin;
    const bool down = sign < 0;
    const float low = down ? -last : first, high = down ? -first : last;
    w_from = surface.low[axis_w] > low ? surface.low[axis_w] : low;
    w_to = surface.high[axis_w] < high ? surface.high[axis_w] : high;
  }

  /// Over a short distance a slope would be lost in rounding, so the bounds are constant there.
  HWY_INLINE bool is_short() const { return w_to - w_from < 0x1p-8f; }

  /// @param at_low, at_high  extent of the rays' positions along -u, u, -v and v at w_from and w_to
  HWY_INLINE void set_lines(const float* at_low, const float* at_high) {
    for (int l = 0; l < 4; ++l) {
      line_slope[l] = is_short() ? 0.0f : (at_high[l] - at_low[l]) / (w_to - w_from);
      line_offset[l] = (is_short() && at_high[l] > at_low[l] ? at_high[l] : at_low[l]) - line_slope[l] * w_from;
    }
  }

  /// Returns the share of the facets' box, seen along w, that a beam of this width may cover.
  HWY_INLINE float share_of(const FacetSurface& surface, const float* at_low, const float* at_high) const {
    float share = 1;
    for (int m = 0; m < 2; ++m) {
      const int axis = m == 0 ? axis_u : axis_v;
      const float size = surface.high[axis] - surface.low[axis] + bound_margin;
      const float low = at_low[2 * m] + at_low[2 * m + 1], high = at_high[2 * m] + at_high[2 * m + 1];
      const float width = (low > high ? low : high) / size;
      share *= width < 1 ? width : 1;
    }
    return share;
  }
};

/// A node or block on the stack as one number, so that comparing two numbers compares how near they
/// are. From the highest bits: the key of its smallest depth, its level (counted from 1; 0 for a
/// block), and its index in that level.
using FacetEntry = std::uint64_t;
inline constexpr int level_shift = 28;

HWY_INLINE FacetEntry entry_of(std::uint32_t key, std::uint32_t level, std::uint32_t place) {
  return FacetEntry{key} << 32 | FacetEntry{level} << level_shift | place;
}
HWY_INLINE std::uint32_t level_of(FacetEntry entry) {
  return static_cast<std::uint32_t>(entry) >> level_shift;
}
HWY_INLINE std::uint32_t place_of(FacetEntry entry) {
  return static_cast<std::uint32_t>(entry) & ((1U << level_shift) - 1);
}

/// Returns integers in the order of the floats.
HWY_INLINE std::uint32_t key_of(float depth) {
  const auto bits = std::bit_cast<std::int32_t>(depth);
  return static_cast<std::uint32_t>(bits ^ (bits >> 31 & 0x7fffffff)) ^ 0x80000000;
}
HWY_INLINE VecI keys_of(VecF depth) {
  const VecI bits = hn::BitCast(ints, depth), sign = hn::Set(ints, std::numeric_limits<std::int32_t>::min());
  return hn::Xor(hn::Xor(bits, hn::AndNot(sign, hn::ShiftRight<31>(bits))), sign);
}

/// The nodes and blocks of a surface's tree still to be visited, the nearest on top.
struct FacetStack {
  FacetEntry entries[(FacetNode::size - 1) * FacetSurface::largest_level_count + 1];
  std::size_t count = 0;

  HWY_INLINE explicit FacetStack(const FacetSurface& surface) {
    entries[count++] = entry_of(0, static_cast<std::uint32_t>(surface.level_count), 0);
  }

  /// Pushes those children of a node that the beam may meet.
  HWY_INLINE void open(const FacetSurface& surface, const FacetBeam& beam, FacetEntry entry) {
    const std::uint32_t level = level_of(entry), place = place_of(entry);
    const FacetNode& node = surface.levels[level - 1][place];
    HWY_ALIGN std::int32_t keys[FacetNode::size];
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetNode::size; i += float_lanes) {
      const VecF w_low = hn::Max(hn::Load(floats, node.low[beam.axis_w] + i), hn::Set(floats, beam.w_from));
      const VecF w_high = hn::Min(hn::Load(floats, node.high[beam.axis_w] + i), hn::Set(floats, beam.w_to));
      const VecF near = beam.sign < 0 ? hn::Neg(w_high) : w_low;
      MaskF in = hn::And(hn::Le(w_low, w_high), hn::Le(near, hn::Set(floats, beam.far)));
      for (int m = 0; m < 2; ++m) {
        const int axis = m == 0 ? beam.axis_u : beam.axis_v;
        const VecF low = hn::Load(floats, node.low[axis] + i), high = hn::Load(floats, node.high[axis] + i);
        const auto bound = [&](int l) HWY_ATTR {
          return hn::MulAdd(hn::Set(floats, beam.line_slope[l]), beam.line_slope[l] > 0 ? w_high : w_low,
                            hn::Set(floats, beam.line_offset[l]));
        };
        in = hn::And(in, hn::Ge(hn::Add(bound(2 * m), high), hn::Zero(floats)));
        in = hn::And(in, hn::Ge(hn::Sub(bound(2 * m + 1), low), hn::Zero(floats)));
      }
      hn::Store(keys_of(near), ints, keys + i);
      met |= bits_of(floats, in) << i;
    }
    const std::size_t bottom = count;
    for (; met != 0; met &= met - 1) {
      const auto child = static_cast<std::uint32_t>(std::countr_zero(met));
      const FacetEntry added =
          entry_of(static_cast<std::uint32_t>(keys[child]), level - 1, FacetNode::size * place + child);
      std::size_t at = count++;
      for (; at > bottom && entries[at - 1] < added; --at) entries[at] = entries[at - 1];
      entries[at] = added;
    }
  }
};

/// For some consecutive facets of a block: their smallest and largest w, and whether the beam may
/// meet them.
struct MetFacetLanes {
  VecF w[4], w_low, w_high, near;
  MaskF in;
};
HWY_INLINE MetFacetLanes meet_facets(const FacetBlock& block, const FacetBeam& beam, std::size_t i) {
  MetFacetLanes met;
  for (int c = 0; c < 4; ++c) met.w[c] = hn::Load(floats, block.corner[c][beam.axis_w] + i);
  met.w_low = hn::Min(hn::Min(met.w[0], met.w[1]), hn::Min(met.w[2], met.w[3]));
  met.w_high = hn::Max(hn::Max(met.w[0], met.w[1]), hn::Max(met.w[2], met.w[3]));
  met.near = beam.sign < 0 ? hn::Neg(met.w_high) : met.w_low;
  met.in = hn::And(hn::Ge(met.w_high, hn::Set(floats, beam.w_from)), hn::Le(met.w_low, hn::Set(floats, beam.w_to)));
  met.in = hn::And(met.in, hn::Le(met.near, hn::Set(floats, beam.far)));
  for (int m = 0; m < 2; ++m) {
    const int axis = m == 0 ? beam.axis_u : beam.axis_v;
    // How far the corner deepest inside each bound is.
    VecF below = hn::Set(floats, -beyond), above = below;
    for (int c = 0; c < 4; ++c) {
      const VecF place = hn::Load(floats, block.corner[c][axis] + i);
      const auto bound = [&](int l) HWY_ATTR {
        return hn::MulAdd(hn::Set(floats, beam.line_slope[l]), met.w[c], hn::Set(floats, beam.line_offset[l]));
      };
      below = hn::Max(below, hn::Add(bound(2 * m), place));
      above = hn::Max(above, hn::Sub(bound(2 * m + 1), place));
    }
    met.in = hn::And(met.in, hn::And(hn::Ge(below, hn::Zero(floats)), hn::Ge(above, hn::Zero(floats))));
  }
  return met;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
