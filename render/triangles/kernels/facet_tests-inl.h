// Tests facets against rays: which rays pass through a facet, from which side, and at which depth.
#if defined(RHORAY_WIDE_FACET_TESTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_TESTS_INL_H
#undef RHORAY_WIDE_FACET_TESTS_INL_H
#else
#define RHORAY_WIDE_FACET_TESTS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/triangles/kernels/facet_group-inl.h"
#include "render/triangles/kernels/facet_lists-inl.h"
#include "render/triangles/kernels/triangle_start.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Tests facets of blocks, one by one, against the rays of a group.
template <FacetSearch search>
class FacetTests {
 public:
  explicit HWY_INLINE FacetTests(FacetGroup& group) : group_(group) {}

  /// Tests the facets of a block that the group may hit, one by one.
  HWY_INLINE void look_into(std::uint32_t block_index) {
    const FacetBlock& block = group_.surface.blocks[block_index];
    const std::uint32_t first = block_index * FacetBlock::size;
    const std::uint32_t in_block =
        group_.surface.facet_count - first < FacetBlock::size ? group_.surface.facet_count - first : FacetBlock::size;
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetBlock::size; i += float_lanes) {
      const MetFacetLanes here = meet_facets(block, group_, i);
      hn::Store(here.near, floats, facet_near_ + i);
      hn::Store(group_.sign < 0 ? hn::Neg(here.w_low) : here.w_high, floats, facet_far_ + i);
      if constexpr (search == FacetSearch::certified) {
        VecF size = hn::Sub(here.w_high, here.w_low);
        for (const int axis : {group_.axis_u, group_.axis_v}) {
          VecF low = hn::Set(floats, beyond), high = hn::Set(floats, -beyond);
          for (int c = 0; c < 4; ++c) {
            const VecF place = hn::Load(floats, block.corner[c][axis] + i);
            low = hn::Min(low, place), high = hn::Max(high, place);
          }
          size = hn::Max(size, hn::Sub(high, low));
        }
        // Corners of a facet near a ray have positions of at most twice its size, d. The margin
        // covers products of a position and an error, products of two errors, and the rounding of
        // two products and a difference.
        const VecF d = hn::Add(size, size);
        const VecF factor = hn::MulAdd(hn::Set(floats, 1.25f), d, hn::Set(floats, 4.25f));
        const VecF margin =
            hn::Mul(hn::Set(floats, place_error), hn::MulAdd(d, factor, hn::Set(floats, 3 * place_error)));
        hn::Store(margin, floats, margin_ + i);
      }
      met |= bits_of(floats, here.in) << i;
    }
    met &= (std::uint64_t{1} << in_block) - 1;
    std::uint32_t changed = 0;
    for (; met != 0; met &= met - 1)
      changed |= test_facet(block, first, static_cast<std::uint32_t>(std::countr_zero(met)));
    if (changed == 0) return;
    for (; changed != 0; changed &= changed - 1)
      group_.find_pack_far<search>(static_cast<std::size_t>(std::countr_zero(changed)));
    group_.find_group_far();
  }

  /// Number of tests of a facet against a pack since forget_count().
  HWY_INLINE std::uint64_t count() const { return tests_; }
  HWY_INLINE void forget_count() { tests_ = 0; }

 private:
  /// A facet's corners in all lanes.
  struct Corners {
    VecF u[4], v[4], w[4];
  };

  /// @return  the packs in which a ray was hit
  HWY_INLINE std::uint32_t test_facet(const FacetBlock& block, std::uint32_t first, std::uint32_t f) {
    Corners corners;
    for (int c = 0; c < 4; ++c) {
      corners.u[c] = hn::Set(floats, block.corner[c][group_.axis_u][f]);
      corners.v[c] = hn::Set(floats, block.corner[c][group_.axis_v][f]);
      corners.w[c] = hn::Set(floats, block.corner[c][group_.axis_w][f]);
    }
    std::uint64_t outside = 0;
    HWY_ALIGN static constexpr float sign_of_u[16] = {1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0};
    HWY_ALIGN static constexpr float sign_of_v[16] = {0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1};
    for (std::size_t i = 0; i < lanes / 4; i += float_lanes) {
      const VecF slope = hn::Load(floats, group_.scratch.cull_slope + i),
                 offset = hn::Load(floats, group_.scratch.cull_offset + i);
      const VecF along_u = hn::Load(floats, sign_of_u + i), along_v = hn::Load(floats, sign_of_v + i);
      VecF within = hn::Set(floats, -beyond);
      for (int c = 0; c < 4; ++c) {
        const VecF bound = hn::MulAdd(slope, corners.w[c], offset);
        within = hn::Max(within, hn::MulAdd(along_u, corners.u[c], hn::MulAdd(along_v, corners.v[c], bound)));
      }
      outside |= bits_of(floats, hn::Lt(within, hn::Zero(floats))) << i;
    }
    const std::uint32_t facet = search == FacetSearch::any ? first + f : source_of(first + f);
    std::uint32_t changed = 0;
    for (std::size_t p = 0; p < packs; ++p) {
      if ((outside >> 4 * p & 15) != 0 || facet_near_[f] > group_.scratch.pack_far[p]) continue;
      ++tests_;
      if (test_pack(corners, p, facet, f)) changed |= 1U << p;
    }
    return changed;
  }

  /// @param facet  its index in `fields`; for any crossing, in the blocks
  /// @return       true when a ray was hit
  HWY_INLINE bool test_pack(const Corners& corners, std::size_t p, std::uint32_t facet, std::uint32_t f) {
    bool changed = false;
    const VecF zero = hn::Zero(floats);
    for (std::size_t i = 0; i < pack; i += float_lanes) {
      const std::size_t r = pack * p + i;
      const VecF slope_u = hn::Load(floats, group_.lines.slope[0] + r),
                 slope_v = hn::Load(floats, group_.lines.slope[1] + r);
      const VecF shift_u = hn::Load(floats, group_.lines.shift[0] + r),
                 shift_v = hn::Load(floats, group_.lines.shift[1] + r);
      VecF x[4], y[4];
      for (int c = 0; c < 4; ++c) {
        x[c] = hn::Sub(hn::NegMulAdd(slope_u, corners.w[c], corners.u[c]), shift_u);
        y[c] = hn::Sub(hn::NegMulAdd(slope_v, corners.w[c], corners.v[c]), shift_v);
      }
      const VecF ab = edge_function(x[0], y[0], x[1], y[1]), bc = edge_function(x[1], y[1], x[2], y[2]);
      const VecF cd = edge_function(x[2], y[2], x[3], y[3]), da = edge_function(x[3], y[3], x[0], y[0]);
      const VecF ac = edge_function(x[0], y[0], x[2], y[2]), ca = hn::Neg(ac);
      MaskF is_abc, any;
      if constexpr (search == FacetSearch::certified) {
        const VecF margin = hn::Set(floats, margin_[f]), minus = hn::Neg(margin);
        const VecF least = hn::Min(hn::Min(ab, bc), hn::Min(cd, da)), most = hn::Max(hn::Max(ab, bc), hn::Max(cd, da));
        any = hn::Or(hn::Ge(least, minus), hn::Le(most, margin));
        if (hn::AllFalse(floats, any)) continue;
        // The edge between the two copies of a triangle's last corner is ignored.
        const MaskF is_triangle =
            hn::And(hn::And(hn::Eq(corners.u[2], corners.u[3]), hn::Eq(corners.v[2], corners.v[3])),
                    hn::Eq(corners.w[2], corners.w[3]));
        const VecF third = hn::IfThenElse(is_triangle, bc, cd);
        const VecF least_edge = hn::Min(hn::Min(ab, bc), hn::Min(third, da)),
                   most_edge = hn::Max(hn::Max(ab, bc), hn::Max(third, da));
        const MaskF sure = hn::Or(hn::Gt(least_edge, margin), hn::Lt(most_edge, minus));
        changed |= note_certified(corners, x, y, sure, any, ab, bc, cd, da, ac, r, facet, f);
        continue;
      }
      const VecF least_abc = hn::Min(hn::Min(ab, bc), ca), most_abc = hn::Max(hn::Max(ab, bc), ca);
      const VecF least_acd = hn::Min(hn::Min(cd, da), ac), most_acd = hn::Max(hn::Max(cd, da), ac);
      is_abc = hn::Or(hn::Ge(least_abc, zero), hn::Le(most_abc, zero));
      const MaskF is_acd = hn::Or(hn::Ge(least_acd, zero), hn::Le(most_acd, zero));
      any = hn::Or(is_abc, is_acd);
      if (hn::AllFalse(floats, any)) continue;
      // A triangle seen edge-on has no inside: where it has neighbours, those are hit.
      const VecF weight_abc = hn::Add(hn::Add(ab, bc), ca), weight_acd = hn::Add(hn::Add(cd, da), ac);
      is_abc = hn::And(is_abc, hn::Ne(weight_abc, zero));
      any = hn::Or(is_abc, hn::And(is_acd, hn::Ne(weight_acd, zero)));
      if constexpr (search == FacetSearch::any) {
        changed |= note_any(corners, is_abc, any, ab, bc, cd, da, ac, hn::IfThenElse(is_abc, weight_abc, weight_acd), r,
                            facet, f);
        continue;
      }
      const VecF depth =
          depth_at(corners, is_abc, ab, bc, cd, da, ac, hn::IfThenElse(is_abc, weight_abc, weight_acd), f);
      if constexpr (search == FacetSearch::all) {
        changed |= note_in_lists(group_, any, depth, r, facet);
        continue;
      }
      const VecF best = hn::Load(floats, group_.scratch.depth + r);
      const VecI best_facet = hn::Load(ints, group_.scratch.facet + r),
                 this_facet = hn::Set(ints, static_cast<std::int32_t>(facet));
      const MaskF is_lower = hn::RebindMask(floats, hn::Lt(this_facet, best_facet));
      const MaskF is_first = hn::Or(hn::Lt(depth, best), hn::And(hn::Eq(depth, best), is_lower));
      MaskF hit = hn::And(hn::And(any, is_first), hn::Ge(depth, hn::Load(floats, group_.lines.begin + r)));
      if (group_.rays.start_side != nullptr) hit = hn::And(hit, leaves_start_side(corners, facet, r));
      if (hn::AllFalse(floats, hit)) continue;
      hn::Store(hn::IfThenElse(hit, depth, best), floats, group_.scratch.depth + r);
      hn::Store(hn::IfThenElse(hn::RebindMask(ints, hit), this_facet, best_facet), ints, group_.scratch.facet + r);
      changed = true;
    }
    return changed;
  }

  /// Finishes rays that need only know whether they pass through any facet between their ends.
  /// @param through  rays that pass through this facet
  HWY_INLINE bool note_any(const Corners& corners, MaskF is_abc, MaskF through, VecF ab, VecF bc, VecF cd, VecF da,
                           VecF ac, VecF weight, std::size_t r, std::uint32_t facet, std::uint32_t f) {
    const VecF none = hn::Set(floats, -beyond), end = hn::Load(floats, group_.scratch.depth + r);
    MaskF hit = hn::And(through, hn::Gt(end, none));
    if (hn::AllFalse(floats, hit)) return false;
    if (facet_near_[f] < group_.all_from || facet_far_[f] > group_.all_to) {
      const VecF depth = depth_at(corners, is_abc, ab, bc, cd, da, ac, weight, f);
      hit = hn::And(hit, hn::And(hn::Le(depth, end), hn::Ge(depth, hn::Load(floats, group_.lines.begin + r))));
    }
    if (group_.rays.start_side != nullptr && !is_sure(facet))
      hit = hn::And(hit, leaves_start_side(corners, source_of(facet), r));
    if (hn::AllFalse(floats, hit)) return false;
    hn::Store(hn::IfThenElse(hit, none, end), floats, group_.scratch.depth + r);
    group_.crossed |= bits_of(floats, hit) << r;
    return true;
  }

  /// @param facet  its index in the blocks
  HWY_INLINE bool is_sure(std::uint32_t facet) const {
    const std::uint16_t* sure = group_.surface.sure;
    return sure != nullptr && (sure[facet / FacetBlock::size] >> facet % FacetBlock::size & 1) != 0;
  }
  HWY_INLINE std::uint32_t source_of(std::uint32_t facet) const {
    return group_.surface.sources != nullptr ? group_.surface.sources[facet] : facet;
  }

  /// Returns the rays that approach the facet from the side on which they start, or whose start
  /// side is unknown.
  HWY_INLINE MaskF leaves_start_side(const Corners& corners, std::uint32_t facet, std::size_t r) const {
    const VecF slope_u = hn::Load(floats, group_.lines.slope[0] + r),
               slope_v = hn::Load(floats, group_.lines.slope[1] + r);
    const VecF shift_u = hn::Load(floats, group_.lines.shift[0] + r),
               shift_v = hn::Load(floats, group_.lines.shift[1] + r);
    const double* gradient = group_.surface.fields[facet].gradient;
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
      const double size = gradient[a] < 0 ? -gradient[a] : gradient[a];
      largest = size > largest ? size : largest;
    }
    const auto component = [&](int axis)
                               HWY_ATTR { return hn::Set(floats, static_cast<float>(gradient[axis] / largest)); };
    const VecF rise = hn::Mul(hn::Set(floats, group_.sign),
                              hn::MulAdd(slope_u, component(group_.axis_u),
                                         hn::MulAdd(slope_v, component(group_.axis_v), component(group_.axis_w))));
    const VecF start_side = hn::Load(floats, group_.lines.start_side + r), leaving = hn::Mul(rise, start_side);
    // Written so that the facet of a flat cell, whose gradient is NaN, counts.
    if (!group_.surface.is_of_triangles) return hn::Not(hn::Gt(leaving, hn::Zero(floats)));
    // As starts_in of triangle_start.h; a normal here has a length of 1 to 1.7.
    const VecF w = hn::Mul(hn::Set(floats, group_.sign), hn::Load(floats, group_.lines.begin + r));
    const VecF away_u = hn::Sub(hn::MulAdd(slope_u, w, shift_u), corners.u[0]),
               away_v = hn::Sub(hn::MulAdd(slope_v, w, shift_v), corners.v[0]);
    const VecF away = hn::MulAdd(
        away_u, component(group_.axis_u),
        hn::MulAdd(away_v, component(group_.axis_v), hn::Mul(hn::Sub(w, corners.w[0]), component(group_.axis_w))));
    const MaskF is_far = hn::Gt(hn::Abs(away), hn::Set(floats, static_cast<float>(start_distance)));
    return hn::Or(hn::Or(is_far, hn::Lt(leaving, hn::Zero(floats))), hn::Eq(start_side, hn::Zero(floats)));
  }

  /// Returns the mean of the corners' depths weighted by the opposite areas, clamped to their
  /// range.
  HWY_INLINE VecF depth_at(const Corners& corners, MaskF is_abc, VecF ab, VecF bc, VecF cd, VecF da, VecF ac,
                           VecF weight, std::uint32_t f) const {
    const VecF of_a = hn::IfThenElse(is_abc, bc, cd), of_c = hn::IfThenElse(is_abc, ab, da);
    const VecF of_other = hn::IfThenElse(is_abc, hn::Neg(ac), ac),
               other = hn::IfThenElse(is_abc, corners.w[1], corners.w[3]);
    const VecF sum = hn::MulAdd(of_a, corners.w[0], hn::MulAdd(of_c, corners.w[2], hn::Mul(of_other, other)));
    const VecF depth = hn::Mul(hn::Set(floats, group_.sign), hn::Div(sum, weight));
    return hn::Min(hn::Max(depth, hn::Set(floats, facet_near_[f])), hn::Set(floats, facet_far_[f]));
  }

  /// Records proven hits, and doubts.
  /// @param sure  rays that certainly pass through the facet, and so does the exact ray
  /// @param any   rays that may pass through it
  HWY_INLINE bool note_certified(const Corners& corners, const VecF* x, const VecF* y, MaskF sure, MaskF any, VecF ab,
                                 VecF bc, VecF cd, VecF da, VecF ac, std::size_t r, std::uint32_t facet,
                                 std::uint32_t f) {
    const VecF zero = hn::Zero(floats), e = hn::Set(floats, place_error);
    for (const VecF* place : {x, y}) {
      const VecF least = hn::Min(hn::Min(place[0], place[1]), hn::Min(place[2], place[3]));
      const VecF most = hn::Max(hn::Max(place[0], place[1]), hn::Max(place[2], place[3]));
      any = hn::And(any, hn::And(hn::Le(least, e), hn::Ge(most, hn::Neg(e))));
    }
    const VecF begin = hn::Load(floats, group_.lines.begin + r), end = hn::Load(floats, group_.lines.end + r);
    const VecF facet_near = hn::Sub(hn::Set(floats, facet_near_[f]), e),
               facet_far = hn::Add(hn::Set(floats, facet_far_[f]), e);
    any = hn::And(any, hn::And(hn::Ge(facet_far, begin), hn::Le(facet_near, end)));
    const VecF far_before = hn::Load(floats, group_.scratch.far + r);
    any = hn::And(any, hn::Le(facet_near, far_before));
    if (hn::AllFalse(floats, any)) return false;
    if (group_.surface.fields[facet].doubt > beyond) sure = no_lane(floats);

    // The diagonal's edge function tells on which side of the diagonal the ray passes.
    const VecF weight_abc = hn::Sub(hn::Add(ab, bc), ac), weight_acd = hn::Add(hn::Add(cd, da), ac);
    const VecF least_abc = hn::Min(hn::Min(ab, bc), hn::Neg(ac)), most_abc = hn::Max(hn::Max(ab, bc), hn::Neg(ac));
    const MaskF is_abc = hn::Or(hn::Ge(least_abc, zero), hn::Le(most_abc, zero));
    const VecF weight = hn::IfThenElse(is_abc, weight_abc, weight_acd);
    const VecF depth = depth_at(corners, is_abc, ab, bc, cd, da, ac, weight, f);
    // Each weight has an error of up to the margin.
    const VecF thickness = hn::Sub(facet_far, facet_near);
    const VecF share = hn::Min(hn::Set(floats, 1.0f), hn::Div(hn::Set(floats, 4 * margin_[f]), hn::Abs(weight)));
    const VecF error = hn::MulAdd(thickness, share, hn::Add(e, e));
    const VecF low = hn::Sub(depth, error), high = hn::Add(depth, error);
    sure = hn::And(hn::And(sure, any), hn::And(hn::Gt(low, begin), hn::Lt(high, end)));
    const MaskF unsure = hn::AndNot(sure, any);

    VecF nearest = hn::Load(floats, group_.scratch.nearest + r), second = hn::Load(floats, group_.scratch.second + r);
    if (!hn::AllFalse(floats, unsure)) keep_doubts(unsure, facet_near, r, facet);
    second = hn::Min(second, hn::IfThenElse(sure, hn::Max(nearest, low), second));
    nearest = hn::Min(nearest, hn::IfThenElse(sure, low, nearest));
    hn::Store(second, floats, group_.scratch.second + r);
    hn::Store(nearest, floats, group_.scratch.nearest + r);
    const VecF best = hn::Load(floats, group_.scratch.depth + r);
    const MaskF hit = hn::And(sure, hn::Lt(depth, best));
    if (hn::AllFalse(floats, hit)) return false;
    const VecI best_facet = hn::Load(ints, group_.scratch.facet + r),
               this_facet = hn::Set(ints, static_cast<std::int32_t>(facet));
    hn::Store(hn::IfThenElse(hit, depth, best), floats, group_.scratch.depth + r);
    hn::Store(hn::IfThenElse(hit, high, far_before), floats, group_.scratch.far + r);
    hn::Store(hn::IfThenElse(hn::RebindMask(ints, hit), this_facet, best_facet), ints, group_.scratch.facet + r);
    return true;
  }

  /// Certified: records that the facet must be tested again for these rays.
  HWY_INLINE void keep_doubts(MaskF unsure, VecF near, std::size_t r, std::uint32_t facet) {
    const VecF doubt = hn::Load(floats, group_.scratch.doubt + r);
    hn::Store(hn::Min(doubt, hn::IfThenElse(unsure, near, doubt)), floats, group_.scratch.doubt + r);
    for (std::uint64_t bits = bits_of(floats, unsure); bits != 0; bits &= bits - 1) {
      const auto ray = static_cast<std::uint32_t>(ray_of(r + static_cast<std::size_t>(std::countr_zero(bits))));
      if (group_.scratch.doubt_count < FacetScratch::doubt_capacity)
        group_.scratch.doubts[group_.scratch.doubt_count++] = {ray, facet};
      else
        group_.answered.whole |= std::uint64_t{1} << ray;
    }
  }

  FacetGroup& group_;
  alignas(64) float facet_near_[FacetBlock::size], facet_far_[FacetBlock::size];
  /// Certified: upper bound of the error of an edge function near the facet.
  alignas(64) float margin_[FacetBlock::size];
  std::uint64_t tests_ = 0;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
