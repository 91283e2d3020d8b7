// Crossings of a group, kept until its rays are done, then refined and written side by side.
#if defined(RHORAY_WIDE_CROSSINGS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_CROSSINGS_INL_H
#undef RHORAY_WIDE_CROSSINGS_INL_H
#else
#define RHORAY_WIDE_CROSSINGS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/grid/isosurface/margins-inl.h"
#include "render/grid/isosurface/parts.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Largest error of a certified hit's position, in cells, that is accepted without re-evaluation.
inline constexpr float largest_place_error = 1e-3f;

/// Moves a group's numbers to and from the batch.
class GroupNumbers {
 public:
  explicit HWY_INLINE GroupNumbers(const RayGroup& group) : index_(group.index), is_in_order_(group.is_in_order) {}

  /// Writes some lanes of the rays from r on into the batch.
  template <class D, class T>
  HWY_INLINE void write(D tag, hn::Vec<D> numbers, hn::Mask<D> lanes, std::size_t r, T* to) const {
    if (is_in_order_) {
      hn::BlendedStore(numbers, lanes, tag, to + r);
    } else {
      HWY_ALIGN T each[hn::MaxLanes(D())];
      hn::Store(numbers, tag, each);
      for (std::uint64_t bits = bits_of(tag, lanes); bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
        to[index_[r + lane]] = each[lane];
      }
    }
  }

  /// Reads some lanes of the rays from r on.
  HWY_INLINE VecD read(const double* from, MaskD lanes, std::size_t r) const {
    if (is_in_order_) return hn::Load(doubles, from + r);
    HWY_ALIGN double each[double_lanes] = {};
    for (std::uint64_t bits = bits_of(doubles, lanes); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      each[lane] = from[index_[r + lane]];
    }
    return hn::Load(doubles, each);
  }

 private:
  const std::uint32_t* index_;
  bool is_in_order_;
};

/// Keeps the changes of side found in the cells of the rays from r on.
template <Search search>
HWY_INLINE void keep_hits(PendingHits& pending, std::size_t r, const Lanes& lanes, const NextCell& next,
                          const VecF* block_corner, const Corners& corners, const VecF* in, const VecF* out,
                          const Changes& changes) {
  const auto keep = [&](VecF numbers, float* to) HWY_ATTR { hn::BlendedStore(numbers, changes.found, floats, to + r); };
  for (int c = 0; c < 8; ++c) keep(corners.f[c], pending.corner[c]);
  for (int a = 0; a < 3; ++a) {
    keep(in[a], pending.in[a]), keep(out[a], pending.out[a]);
    keep(hn::Add(block_corner[a], next.cell[a]), pending.cell[a]);
  }
  keep(next.way_in, pending.way_in), keep(next.way_out, pending.way_out);
  keep(changes.low, pending.low), keep(changes.high, pending.high);
  if constexpr (search == Search::certified) keep(lanes.way_error, pending.way_error);
  hn::BlendedStore(changes.count, hn::RebindMask(ints, changes.found), ints, pending.root_count + r);
  pending.rays |= bits_of(floats, changes.found) << r;
}

/// Ids of the cells at given positions in the mirrored lattice.
HWY_INLINE VecD cell_ids(const MirroredLattice& lattice, const int* leaf_count, const VecF* cell, std::size_t part) {
  VecD id = hn::Zero(doubles);
  for (int a = 2; a >= 0; --a) {
    VecD at = as_doubles(cell[a], part);
    if (lattice.is_mirrored(a)) at = hn::Sub(hn::Set(doubles, lattice.plane(a, 1)), at);
    id = hn::MulAdd(id, hn::Set(doubles, static_cast<double>(leaf_count[a])), at);
  }
  return id;
}

/// Refines the positions of crossings and writes them.
template <Search search>
class HitWriter {
 public:
  HWY_INLINE HitWriter(const IsosurfaceQuery& surface, const MirroredLattice& lattice, const RayArrays& rays,
                       const HitArrays& hits, const IsosurfaceScratch& scratch)
      : surface_(surface),
        lattice_(lattice),
        rays_(rays),
        hits_(hits),
        scratch_(scratch),
        pending_(scratch.pending),
        numbers_(scratch.group) {}

  /// Writes all kept crossings.
  /// @return  certified: the rays whose hit is not proven, or whose position is not accurate enough
  HWY_INLINE std::uint64_t write() {
    for (std::size_t first = 0; first < scratch_.group.count; first += 2 * float_lanes) {
      const std::uint64_t found = pending_.rays >> first & first_rays(2 * float_lanes);
      if (found == 0) continue;
      // Lanes without a hit hold their old contents: arbitrary numbers, which are not used.
      RootSearch a = search_from(first), b = search_from(first + float_lanes);
      if constexpr (search != Search::preview) refine(a, b);
      write(a, first), write(b, first + float_lanes);
    }
    return doubtful_;
  }

 private:
  HWY_INLINE VecF load(const float* from, std::size_t r) const { return hn::Load(floats, from + r); }
  HWY_INLINE std::uint64_t found_from(std::size_t r) const { return pending_.rays >> r & first_rays(float_lanes); }

  HWY_INLINE RootSearch search_from(std::size_t r) const {
    Corners corners;
    VecF in[3], out[3];
    for (int c = 0; c < 8; ++c) corners.f[c] = load(pending_.corner[c], r);
    for (int a = 0; a < 3; ++a) in[a] = load(pending_.in[a], r), out[a] = load(pending_.out[a], r);
    const MaskF used = mask_of(floats, found_from(r));
    return RootSearch(along(corners, in, out), hn::IfThenElseZero(used, load(pending_.low, r)),
                      hn::IfThenElseZero(used, load(pending_.high, r)));
  }

  HWY_INLINE void write(const RootSearch& searched, std::size_t first) {
    std::uint64_t found = found_from(first);
    if (found == 0) return;
    const CubicLanes& cubic = searched.cubic();
    const MaskF used = mask_of(floats, found);
    const Roots roots = search == Search::preview
                            ? secant_step(cubic, hn::IfThenElseZero(used, load(pending_.high, first)))
                            : searched.roots();
    Corners corners;
    VecF p[3], gradient[3];
    for (int c = 0; c < 8; ++c) corners.f[c] = load(pending_.corner[c], first);
    const VecF rest = hn::Sub(hn::Set(floats, 1.0f), roots.s);
    for (int a = 0; a < 3; ++a)
      p[a] = between(load(pending_.in[a], first), load(pending_.out[a], first), roots.s, rest);
    gradient_at(corners, p, gradient);
    const VecF way_in = load(pending_.way_in, first), length = hn::Sub(load(pending_.way_out, first), way_in);
    const VecF way = hn::MulAdd(roots.s, length, way_in);
    VecF way_error = hn::Zero(floats);
    if constexpr (search == Search::certified) {
      const VecF of_ways = load(pending_.way_error, first);
      const VecF of_root = error_of_root(cubic, margin_of(corners, of_ways), roots.s);
      way_error = hn::MulAdd(of_root, length, hn::Add(of_ways, of_ways));
      // Squared: how far the ray moves while it moves by 1 along its fastest axis.
      VecF per_way = hn::Zero(floats);
      for (int a = 0; a < 3; ++a) {
        const VecF slope = load(scratch_.slope[a], first);
        per_way = hn::MulAdd(slope, slope, per_way);
      }
      constexpr float largest = largest_place_error * largest_place_error * (1 - 0x1p-20f);
      const MaskF placed = hn::Le(hn::Mul(hn::Mul(way_error, way_error), per_way), hn::Set(floats, largest));
      const std::uint64_t misplaced = found & ~bits_of(floats, placed);
      doubtful_ |= misplaced << first;
      found &= ~misplaced;
    }
    for (std::size_t part = 0; part < parts_of_floats; ++part)
      write_places(first + part * double_lanes, mask_of(doubles, found >> (part * double_lanes)), part, way, way_error,
                   gradient);
    const auto counted = hn::RebindMask(ints, used);
    numbers_.write(ints, hn::Load(ints, pending_.root_count + first), counted, first,
                   reinterpret_cast<std::int32_t*>(hits_.root_count));
    numbers_.write(ints, roots.iterations, counted, first, reinterpret_cast<std::int32_t*>(hits_.iteration_count));
  }

  /// Writes the results that are in double precision, for some rays from r on.
  HWY_INLINE void write_places(std::size_t r, MaskD lanes, std::size_t part, VecF way, VecF way_error,
                               const VecF* gradient) {
    const VecD t_per_way = hn::Load(doubles, scratch_.t_per_way + r);
    const VecD t = hn::Add(hn::Load(doubles, scratch_.t_block + r), hn::Mul(as_doubles(way, part), t_per_way));
    if constexpr (search == Search::certified) {
      const VecD place = as_doubles(way_error, part);
      const VecD error = hn::Add(hn::Mul(place, t_per_way), hn::Mul(hn::Set(doubles, 0x1p-49), hn::Abs(t)));
      // A ray's own ends are exact: a hit that may lie beyond them is not certain.
      const MaskD within = hn::And(hn::Ge(hn::Sub(t, error), numbers_.read(rays_.t_min, lanes, r)),
                                   hn::Le(hn::Add(t, error), numbers_.read(rays_.t_max, lanes, r)));
      doubtful_ |= bits_of(doubles, hn::AndNot(within, lanes)) << r;
      lanes = hn::And(lanes, within);
      numbers_.write(doubles, error, lanes, r, hits_.error);
    }
    numbers_.write(doubles, hn::Min(t, hn::Load(doubles, scratch_.group.t_out + r)), lanes, r, hits_.t);
    numbers_.write(doubles, hn::Set(doubles, surface_.isovalue), lanes, r, hits_.value);
    for (int a = 0; a < 3; ++a) {
      const VecD along_axis = as_doubles(gradient[a], part);
      numbers_.write(doubles, lattice_.is_mirrored(a) ? hn::Neg(along_axis) : along_axis, lanes, r, hits_.gradient[a]);
    }
    VecF cell[3];
    for (int a = 0; a < 3; ++a) cell[a] = load(pending_.cell[a], r - part * double_lanes);
    constexpr hn::Rebind<std::int64_t, Doubles> whole;
    numbers_.write(whole, hn::ConvertTo(whole, cell_ids(lattice_, surface_.leaf_count, cell, part)),
                   hn::RebindMask(whole, lanes), r, reinterpret_cast<std::int64_t*>(hits_.cell));
  }

  const IsosurfaceQuery& surface_;
  const MirroredLattice& lattice_;
  const RayArrays& rays_;
  const HitArrays& hits_;
  const IsosurfaceScratch& scratch_;
  const PendingHits& pending_;
  const GroupNumbers numbers_;
  std::uint64_t doubtful_ = 0;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
