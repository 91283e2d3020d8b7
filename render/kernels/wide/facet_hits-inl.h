// Hits of rays at facets, written down in double precision.
#if defined(RHORAY_WIDE_FACET_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_HITS_INL_H
#undef RHORAY_WIDE_FACET_HITS_INL_H
#else
#define RHORAY_WIDE_FACET_HITS_INL_H
#endif

#include <bit>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "render/kernels/wide/facet_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Writes the hits of a group's rays.
template <FacetSearch search>
class FacetHits {
 public:
  HWY_INLINE FacetHits(FacetGroup& group, const HitArrays& hits) : group_(group), hits_(hits) {}

  /// @param visits  of nodes and blocks, for each of these lanes
  HWY_INLINE void write(std::uint64_t lanes_alive, std::uint64_t visits) {
    const std::uint64_t rays_alive = rays_of(lanes_alive);
    for (std::size_t r = 0; r < group_.ray_count; r += double_lanes)
      if (const std::uint64_t bits = rays_alive >> r & ((std::uint64_t{1} << double_lanes) - 1); bits != 0)
        write_rays(bits, r, visits);
  }

 private:
  /// Numbers of lanes, in the order of the rays from r on.
  template <class T>
  HWY_INLINE static void in_order_of_rays(const T* of_lanes, std::size_t r, T* out) {
    constexpr std::size_t run = double_lanes < 4 ? double_lanes : 4;
    for (std::size_t i = 0; i < double_lanes; i += run)
      std::memcpy(out + i, of_lanes + lane_of(r + i), run * sizeof(T));
  }
  HWY_INLINE static VecD depths(const float* of_lanes, std::size_t r) {
    HWY_ALIGN float ordered[lanes];
    in_order_of_rays(of_lanes, r, ordered);
    return hn::PromoteTo(doubles, hn::Load(half_floats, ordered));
  }

  /// @param alive  a bit for each of the rays from r on
  HWY_INLINE void write_rays(std::uint64_t alive, std::size_t r, std::uint64_t visits) {
    hn::BlendedStore(hn::Set(counts, static_cast<std::uint32_t>(visits)), mask_of(counts, alive), counts,
                     hits_.cost + r);
    HWY_ALIGN std::int32_t facet[lanes];
    in_order_of_rays(group_.scratch.facet, r, facet);
    const VecI64 index = hn::PromoteTo(longs, hn::Load(half_ints, facet));
    MaskD hit = hn::And(mask_of(doubles, alive),
                        hn::RebindMask(doubles, hn::Ne(index, hn::Set(longs, FacetScratch::no_facet))));
    if constexpr (search == FacetSearch::certified) {
      const VecD far = hn::IfThenElse(hit, depths(group_.scratch.far, r), depths(group_.scratch.end, r));
      const MaskD not_proven = hn::Le(depths(group_.scratch.second, r), far);
      const MaskD in_doubt = hn::AndNot(not_proven, hn::Le(depths(group_.scratch.doubt, r), far));
      group_.unanswered.whole |= (bits_of(doubles, not_proven) & alive) << r;
      group_.unanswered.part |= (bits_of(doubles, in_doubt) & alive) << r;
      hit = hn::AndNot(not_proven, hit);
    }
    if (!hn::AllFalse(doubles, hit)) write_hits(hit, index, r);
  }

  /// The place is where the cell's own field is the isovalue, by its gradient in double; where rounding leads that out
  /// of the cell, or the cell is flat, it is the facet's.
  HWY_INLINE void write_hits(MaskD hit, VecI64 facet, std::size_t r) {
    static_assert(sizeof(FacetField) == 6 * sizeof(double));
    const VecI64 index = hn::IfThenElseZero(hn::RebindMask(longs, hit), facet);
    const VecI64 place = hn::Add(hn::ShiftLeft<2>(index), hn::Add(index, index));
    const double* fields = group_.surface.fields->gradient;
    const auto number = [&](int i) HWY_ATTR { return hn::GatherIndex(doubles, fields + i, place); };
    VecD value = number(3), speed = hn::Zero(doubles), gradient[3];
    for (int a = 0; a < 3; ++a) {
      gradient[a] = number(a);
      const VecD o = hn::Sub(hn::Load(doubles, group_.rays.origin[a] + r), hn::Set(doubles, group_.surface.anchor[a]));
      value = hn::MulAdd(gradient[a], o, value);
      speed = hn::MulAdd(gradient[a], hn::Load(doubles, group_.rays.direction[a] + r), speed);
      hn::BlendedStore(gradient[a], hit, doubles, hits_.gradient[a] + r);
    }
    const VecI64 sizes = hn::BitCast(longs, number(5));
    const VecD cell_size =
        hn::PromoteTo(doubles, hn::BitCast(half_floats, hn::TruncateTo(counts, hn::BitCast(unsigned_longs, sizes))));
    const VecD doubt = hn::PromoteTo(
        doubles,
        hn::BitCast(half_floats, hn::TruncateTo(counts, hn::ShiftRight<32>(hn::BitCast(unsigned_longs, sizes)))));
    const VecD d = hn::Load(doubles, group_.rays.direction[group_.axis_w] + r);
    const VecD to_mesh = hn::Set(doubles, static_cast<double>(group_.sign) / group_.surface.scale);
    const VecD start = hn::Sub(hn::Load(doubles, group_.rays.origin[group_.axis_w] + r),
                               hn::Set(doubles, group_.surface.anchor[group_.axis_w]));
    const VecD t_facet = hn::Div(hn::MulSub(depths(group_.scratch.depth, r), to_mesh, start), d);
    const VecD t_field = hn::Div(hn::Neg(value), speed);
    const VecD off = hn::Abs(hn::Mul(hn::Sub(t_field, t_facet), d));
    const MaskD is_near = hn::And(hn::Le(off, hn::Mul(cell_size, hn::Set(doubles, 0x1p-6))),
                                  hn::Lt(doubt, hn::Set(doubles, static_cast<double>(beyond))));
    const VecD t = hn::Min(hn::Max(hn::IfThenElse(is_near, t_field, t_facet), hn::Load(doubles, group_.rays.t_min + r)),
                           hn::Load(doubles, group_.rays.t_max + r));
    if constexpr (search == FacetSearch::certified)
      hit = prove(hit, is_near, gradient, value, speed, t, cell_size, doubt, r);
    hn::BlendedStore(t, hit, doubles, hits_.t + r);
    hn::BlendedStore(hn::Set(doubles, group_.surface.isovalue), hit, doubles, hits_.value + r);
    const auto cell_and_tet = hn::BitCast(unsigned_longs, number(4));
    const auto hit_counts = mask_of(counts, bits_of(doubles, hit));
    hn::BlendedStore(hn::And(cell_and_tet, hn::Set(unsigned_longs, 0xffffffff)), hn::RebindMask(unsigned_longs, hit),
                     unsigned_longs, hits_.cell + r);
    hn::BlendedStore(hn::TruncateTo(counts, hn::ShiftRight<32>(cell_and_tet)), hit_counts, counts, hits_.tet + r);
    hn::BlendedStore(hn::Set(counts, 1), hit_counts, counts, hits_.root_count + r);
  }

  /// Writes the bounds of hits. With u = 2^-53: the field at the origin is off by 8u of the terms that are added up,
  /// and so is its slope; inside the cell by what the gradient is off by.
  /// @return  those that are good enough: within a quarter of a thousandth of the cell
  HWY_INLINE MaskD prove(MaskD hit, MaskD is_by_field, const VecD* gradient, VecD value, VecD speed, VecD t,
                         VecD cell_size, VecD doubt, std::size_t r) {
    VecD terms = hn::Abs(value), slopes = hn::Zero(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD g = hn::Abs(gradient[a]);
      const VecD o = hn::Sub(hn::Load(doubles, group_.rays.origin[a] + r), hn::Set(doubles, group_.surface.anchor[a]));
      terms = hn::MulAdd(g, hn::Add(hn::Abs(o), hn::Set(doubles, 1 / group_.surface.scale)), terms);
      slopes = hn::MulAdd(g, hn::Abs(hn::Load(doubles, group_.rays.direction[a] + r)), slopes);
    }
    const VecD rounding = hn::Mul(hn::Set(doubles, 0x1p-48), hn::MulAdd(hn::Abs(t), slopes, terms));
    const VecD error = hn::Div(hn::Add(doubt, rounding), hn::Abs(speed));
    const VecD largest = hn::Mul(hn::Set(doubles, 0.25e-3), cell_size);
    const VecD in_depth = hn::Mul(error, hn::Abs(hn::Load(doubles, group_.rays.direction[group_.axis_w] + r)));
    const MaskD is_good = hn::And(is_by_field, hn::Le(in_depth, largest));
    hn::BlendedStore(error, hit, doubles, hits_.error + r);
    group_.unanswered.whole |= bits_of(doubles, hn::AndNot(is_good, hit)) << r;
    return hn::And(hit, is_good);
  }
  FacetGroup& group_;
  const HitArrays hits_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
