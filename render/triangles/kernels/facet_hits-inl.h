// Writes hits of rays at facets in double precision.
#if defined(RHORAY_WIDE_FACET_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_HITS_INL_H
#undef RHORAY_WIDE_FACET_HITS_INL_H
#else
#define RHORAY_WIDE_FACET_HITS_INL_H
#endif

#include <bit>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/triangles/kernels/facet_group-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Writes the hits of a group's rays.
template <FacetSearch search>
class FacetHits {
 public:
  HWY_INLINE FacetHits(FacetGroup& group, const HitArrays& hits)
      : group_(group),
        hits_(hits),
        reach_(1 / group.surface.scale),
        to_mesh_(static_cast<double>(group.sign) * reach_) {}

  /// @param visits  of nodes and blocks, for each of these lanes
  HWY_INLINE void write(std::uint64_t lanes_alive, std::uint64_t visits) {
    const std::uint64_t rays_alive = rays_of(lanes_alive);
    for (std::size_t r = 0; r < group_.ray_count; r += double_lanes)
      if (const std::uint64_t bits = rays_alive >> r & ((std::uint64_t{1} << double_lanes) - 1); bits != 0)
        write_rays(bits, r, visits);
  }

 private:
  HWY_INLINE static VecD depths(const float* of_lanes, std::size_t r) {
    return hn::PromoteTo(doubles, load_from_lanes(half_floats, of_lanes, r));
  }

  /// @param alive  one bit for each of the rays from r on
  HWY_INLINE void write_rays(std::uint64_t alive, std::size_t r, std::uint64_t visits) {
    hn::BlendedStore(hn::Set(counts, static_cast<std::uint32_t>(visits)), mask_of(counts, alive), counts,
                     hits_.cost + r);
    const VecI64 index = hn::PromoteTo(longs, load_from_lanes(half_ints, group_.scratch.facet, r));
    MaskD hit = hn::And(mask_of(doubles, alive),
                        hn::RebindMask(doubles, hn::Ne(index, hn::Set(longs, FacetScratch::no_facet))));
    if constexpr (search == FacetSearch::certified) {
      const VecD far = hn::IfThenElse(hit, depths(group_.scratch.far, r), depths(group_.lines.end, r));
      const MaskD not_proven = hn::Le(depths(group_.scratch.second, r), far);
      const MaskD in_doubt = hn::AndNot(not_proven, hn::Le(depths(group_.scratch.doubt, r), far));
      group_.answered.whole |= (bits_of(doubles, not_proven) & alive) << r;
      group_.answered.part |= (bits_of(doubles, in_doubt) & alive) << r;
      hit = hn::AndNot(not_proven, hit);
    }
    if (!hn::AllFalse(doubles, hit)) write_hits(hit, index, r);
  }

  /// The FacetField of each facet that a ray hit, by component.
  struct Fields {
    VecD number[sizeof(FacetField) / sizeof(double)];

    HWY_INLINE VecD gradient(int axis) const { return number[axis]; }
    HWY_INLINE VecD value() const { return number[3]; }
    HWY_INLINE hn::Vec<UnsignedLongs> cell_and_tet() const { return hn::BitCast(unsigned_longs, number[4]); }
    HWY_INLINE VecD cell_size() const { return float_in(hn::BitCast(unsigned_longs, number[5])); }
    HWY_INLINE VecD doubt() const { return float_in(hn::ShiftRight<32>(hn::BitCast(unsigned_longs, number[5]))); }

   private:
    HWY_INLINE static VecD float_in(hn::Vec<UnsignedLongs> bits) {
      return hn::PromoteTo(doubles, hn::BitCast(half_floats, hn::TruncateTo(counts, bits)));
    }
  };

  /// Adjacent rays hit few different facets, so loading facet by facet is faster than six gathers.
  HWY_INLINE Fields fields_of(MaskD hit, VecI64 facet) const {
    static_assert(sizeof(FacetField) == 6 * sizeof(double));
    Fields fields;
    for (VecD& numbers : fields.number) numbers = hn::Zero(doubles);
    HWY_ALIGN std::int64_t facets[double_lanes];
    hn::Store(facet, longs, facets);
    for (std::uint64_t left = bits_of(doubles, hit); left != 0;) {
      const std::int64_t one = facets[std::countr_zero(left)];
      const MaskD same = hn::And(hit, hn::RebindMask(doubles, hn::Eq(facet, hn::Set(longs, one))));
      const double* field = group_.surface.fields[one].gradient;
      for (std::size_t i = 0; i < 6; ++i)
        fields.number[i] = hn::IfThenElse(same, hn::Set(doubles, field[i]), fields.number[i]);
      left &= ~bits_of(doubles, same);
    }
    return fields;
  }

  /// The hit is where the cell's own field equals the isovalue, using its gradient in double. Where
  /// rounding would put that outside the cell, or the cell is flat, the hit is on the facet.
  HWY_INLINE void write_hits(MaskD hit, VecI64 facet, std::size_t r) {
    const Fields fields = fields_of(hit, facet);
    VecD value = fields.value(), speed = hn::Zero(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD o = hn::Sub(hn::Load(doubles, group_.rays.origin[a] + r), hn::Set(doubles, group_.surface.anchor[a]));
      value = hn::MulAdd(fields.gradient(a), o, value);
      speed = hn::MulAdd(fields.gradient(a), hn::Load(doubles, group_.rays.direction[a] + r), speed);
      hn::BlendedStore(fields.gradient(a), hit, doubles, hits_.gradient[a] + r);
    }
    const VecD cell_size = fields.cell_size(), doubt = fields.doubt();
    const VecD d = hn::Load(doubles, group_.rays.direction[group_.axis_w] + r);
    const VecD start = hn::Sub(hn::Load(doubles, group_.rays.origin[group_.axis_w] + r),
                               hn::Set(doubles, group_.surface.anchor[group_.axis_w]));
    // The distance along w, in mesh units.
    const VecD way = hn::MulSub(depths(group_.scratch.depth, r), hn::Set(doubles, to_mesh_), start);
    const VecD t_field = hn::Div(hn::Neg(value), speed);
    const VecD off = hn::Abs(hn::MulSub(t_field, d, way));
    const MaskD is_near = hn::And(hn::Le(off, hn::Mul(cell_size, hn::Set(doubles, 0x1p-6))),
                                  hn::Lt(doubt, hn::Set(doubles, static_cast<double>(beyond))));
    VecD t = t_field;
    if (!hn::AllFalse(doubles, hn::AndNot(is_near, hit))) t = hn::IfThenElse(is_near, t, hn::Div(way, d));
    t = hn::Min(hn::Max(t, hn::Load(doubles, group_.rays.t_min + r)), hn::Load(doubles, group_.rays.t_max + r));
    if constexpr (search == FacetSearch::certified)
      hit = prove(hit, is_near, fields, value, speed, t, cell_size, doubt, r);
    hn::BlendedStore(t, hit, doubles, hits_.t + r);
    hn::BlendedStore(hn::Set(doubles, group_.surface.isovalue), hit, doubles, hits_.value + r);
    const auto cell_and_tet = fields.cell_and_tet();
    const auto hit_counts = mask_of(counts, bits_of(doubles, hit));
    hn::BlendedStore(hn::And(cell_and_tet, hn::Set(unsigned_longs, 0xffffffff)), hn::RebindMask(unsigned_longs, hit),
                     unsigned_longs, hits_.cell + r);
    hn::BlendedStore(hn::TruncateTo(counts, hn::ShiftRight<32>(cell_and_tet)), hit_counts, counts, hits_.tet + r);
    hn::BlendedStore(hn::Set(counts, 1), hit_counts, counts, hits_.root_count + r);
    hn::BlendedStore(hn::Zero(counts), hit_counts, counts, hits_.iteration_count + r);
    if constexpr (search == FacetSearch::first)
      hn::BlendedStore(hn::Set(doubles, std::numeric_limits<double>::quiet_NaN()), hit, doubles, hits_.error + r);
    group_.answered.hit |= bits_of(doubles, hit) << r;
  }

  /// Writes the error bounds of hits. With u = 2^-53: the field at the origin has an error of 8u of
  /// the terms that are added up, and so has its slope. Inside the cell the error of the gradient
  /// is added.
  /// @return  hits that are accurate enough: within a quarter of a thousandth of the cell
  HWY_INLINE MaskD prove(MaskD hit, MaskD is_by_field, const Fields& fields, VecD value, VecD speed, VecD t,
                         VecD cell_size, VecD doubt, std::size_t r) {
    VecD terms = hn::Abs(value), slopes = hn::Zero(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD g = hn::Abs(fields.gradient(a));
      const VecD o = hn::Sub(hn::Load(doubles, group_.rays.origin[a] + r), hn::Set(doubles, group_.surface.anchor[a]));
      terms = hn::MulAdd(g, hn::Add(hn::Abs(o), hn::Set(doubles, reach_)), terms);
      slopes = hn::MulAdd(g, hn::Abs(hn::Load(doubles, group_.rays.direction[a] + r)), slopes);
    }
    const VecD rounding = hn::Mul(hn::Set(doubles, 0x1p-48), hn::MulAdd(hn::Abs(t), slopes, terms));
    const VecD error = hn::Div(hn::Add(doubt, rounding), hn::Abs(speed));
    const VecD largest = hn::Mul(hn::Set(doubles, 0.25e-3), cell_size);
    const VecD in_depth = hn::Mul(error, hn::Abs(hn::Load(doubles, group_.rays.direction[group_.axis_w] + r)));
    const MaskD is_good = hn::And(is_by_field, hn::Le(in_depth, largest));
    hn::BlendedStore(error, hit, doubles, hits_.error + r);
    group_.answered.whole |= bits_of(doubles, hn::AndNot(is_good, hit)) << r;
    return hn::And(hit, is_good);
  }

  FacetGroup& group_;
  const HitArrays hits_;
  double reach_;    ///< size of the facets' frame, mesh units
  double to_mesh_;  ///< factor from depths to w, mesh units
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
