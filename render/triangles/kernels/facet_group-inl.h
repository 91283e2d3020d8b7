// Rays of a chunk that are traced together: their lines in the frame of the facets, and bounds of
// all these lines.
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

#include "render/triangles/kernels/facet_beam-inl.h"
#include "render/triangles/kernels/facet_lanes-inl.h"
#include "render/triangles/kernels/facet_part-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The rays of a chunk that share a major axis and a direction along it; some of their lanes at a
/// time.
class FacetGroup : public FacetBeam {
 public:
  HWY_INLINE FacetGroup(const FacetSurface& of_surface, const RayArrays& of_rays, std::size_t count, int axis,
                        bool down, FacetChunk& chunk, FacetScratch& memory)
      : FacetBeam(axis, down),
        surface(of_surface),
        rays(of_rays),
        lines(chunk.lines),
        scratch(memory),
        ray_count(count) {
    if (chunk.axis == axis && chunk.down == down) return;
    describe_rays(surface, rays, count, *this, chunk.lines);
    chunk.axis = axis, chunk.down = down;
  }

  /// Prepares these lanes, and no others, and bounds the positions of their rays.
  template <FacetSearch search>
  void begin(std::uint64_t lanes_alive) {
    const VecF none = hn::Set(floats, -beyond);
    float first = beyond, last = -beyond, last_begin = -beyond, first_end = beyond;
    for (std::size_t r = 0; r < lanes; r += float_lanes) {
      const MaskF alive = alive_in(lanes_alive, r);
      const VecF begin = hn::Load(floats, lines.begin + r), end = hn::Load(floats, lines.end + r);
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
    cut(surface, first, last);
    if (has_facets()) bound_places(lanes_alive);
  }

  /// False when no facet is between the depths at which the group's rays begin and end.
  HWY_INLINE bool has_facets() const { return surface.facet_count != 0 && w_from <= w_to; }

  /// False when the rays are so far apart that most facets met by one ray are met by no other.
  /// Estimated with facets spread evenly over their box.
  HWY_INLINE bool is_narrow(std::uint64_t lanes_alive) const {
    if ((lanes_alive & (lanes_alive - 1)) == 0 || !has_facets()) return true;
    constexpr float facets_per_ray = 24;
    return share_of(surface, group_at_low_, group_at_high_) * static_cast<float>(surface.facet_count) <=
           facets_per_ray * static_cast<float>(std::popcount(lanes_alive));
  }

  /// Updates how far rays of a pack, and of the group, are still to be traced.
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
  const FacetLines& lines;
  FacetScratch& scratch;
  const std::size_t ray_count;     ///< of the chunk
  float all_from = 0, all_to = 0;  ///< any: the depth range that is common to all rays
  std::uint64_t crossed = 0;       ///< any: lanes that hit a facet
  Answered answered;

 private:
  HWY_INLINE MaskF alive_in(std::uint64_t lanes_alive, std::size_t lane) const {
    return mask_of(floats, lanes_alive >> lane);
  }

  /// Lines that bound the positions of each pack's rays, and of the group's rays. At w, u is at
  /// least -(offset + slope w) by the first of four lines, and at most offset + slope w by the
  /// second; the other two bound v. The minimum of linear functions is above the straight line
  /// between any two of its values.
  HWY_INLINE void bound_places(std::uint64_t lanes_alive) {
    HWY_ALIGN float at_low[lanes / 4], at_high[lanes / 4];
    float* const at[2] = {at_low, at_high};
    const VecF end_of_box[2] = {hn::Set(floats, w_from), hn::Set(floats, w_to)};
    for (int m = 0; m < 2; ++m) {
      VecF least[2][packs], most[2][packs];
      for (std::size_t p = 0; p < packs; ++p) {
        for (int e = 0; e < 2; ++e) least[e][p] = hn::Set(floats, beyond), most[e][p] = hn::Set(floats, -beyond);
        for (std::size_t r = pack * p; r < pack * (p + 1); r += float_lanes) {
          const MaskF alive = alive_in(lanes_alive, r);
          const VecF slope = hn::Load(floats, lines.slope[m] + r), shift = hn::Load(floats, lines.shift[m] + r);
          for (int e = 0; e < 2; ++e) {
            const VecF place = hn::MulAdd(slope, end_of_box[e], shift);
            least[e][p] = hn::Min(least[e][p], hn::IfThenElse(alive, place, least[e][p]));
            most[e][p] = hn::Max(most[e][p], hn::IfThenElse(alive, place, most[e][p]));
          }
        }
      }
      for (int e = 0; e < 2; ++e) {
        HWY_ALIGN float of_packs[2][packs];
        for (VecF& v : least[e]) v = hn::Neg(v);
        largest_of_each(least[e], of_packs[0]);
        largest_of_each(most[e], of_packs[1]);
        for (std::size_t p = 0; p < packs; ++p)
          for (std::size_t side = 0; side < 2; ++side)
            at[e][4 * p + 2 * static_cast<std::size_t>(m) + side] = bound_margin + of_packs[side][p];
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
    const VecF inverse = hn::Set(floats, is_short() ? 0.0f : 1 / (w_to - w_from));
    for (std::size_t i = 0; i < lanes / 4; i += float_lanes) {
      const VecF low = hn::Load(floats, at_low + i), high = hn::Load(floats, at_high + i);
      const VecF slope = hn::Mul(hn::Sub(high, low), inverse);
      const VecF base = is_short() ? hn::Max(low, high) : low;
      hn::Store(slope, floats, scratch.cull_slope + i);
      hn::Store(hn::NegMulAdd(slope, end_of_box[0], base), floats, scratch.cull_offset + i);
    }
    set_lines(group_at_low_, group_at_high_);
  }

  float group_at_low_[4], group_at_high_[4];
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
