// Crossings with transparent surfaces as they are found, refined side by side and written, each at
// its index in its ray's list.
#if defined(RHORAY_WIDE_SHELL_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_SHELL_HITS_INL_H
#undef RHORAY_WIDE_SHELL_HITS_INL_H
#else
#define RHORAY_WIDE_SHELL_HITS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/all_hits/parts.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/grid/isosurface/fetch-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Moves some lanes before the others; their order is computed once for many vectors.
class ChosenLanes {
 public:
  explicit HWY_INLINE ChosenLanes(MaskF lanes)
      : numbers_(hn::And(hn::Compress(hn::Iota(ints, 0), hn::RebindMask(ints, lanes)),
                         hn::Set(ints, std::int32_t{float_lanes - 1}))),
        order_(hn::IndicesFromVec(floats, numbers_)),
        order_of_ints_(hn::IndicesFromVec(ints, numbers_)) {}

  HWY_INLINE VecI numbers() const { return numbers_; }  ///< of the lanes
  HWY_INLINE VecF first(VecF v) const { return hn::TableLookupLanes(v, order_); }
  HWY_INLINE VecI first(VecI v) const { return hn::TableLookupLanes(v, order_of_ints_); }

 private:
  VecI numbers_;
  decltype(hn::IndicesFromVec(floats, VecI())) order_;
  decltype(hn::IndicesFromVec(ints, VecI())) order_of_ints_;
};

/// What a search in cells has found, except for the piece of the way on which a change lies.
struct FoundIn {
  const Corners& corners;  ///< as the block's samples are kept
  const NextCell& next;
  const VecF* in;
  const VecF* out;
  const VecF* block_corner;
  /// Ray of the first lane; where cells of all rays are searched together, the first of these
  /// cells.
  std::size_t ray;
  int surface;
};

/// Keeps changes of side of one surface, and makes them crossings, many at a time.
class HitLists {
 public:
  /// @param has_values  blocks keep values, not differences to isovalues
  HWY_INLINE HitLists(const TransparentSurfaces& shells, int surface, const MirroredLattice& lattice, bool has_values,
                      const CrossingArrays* lists, std::size_t first_ray, GridAllHitsScratch& scratch)
      : shells_(shells),
        surface_(surface),
        lattice_(lattice),
        has_values_(has_values),
        list_(lists[surface]),
        first_ray_(first_ray),
        scratch_(scratch),
        found_(scratch.found[surface]) {
    found_.count = 0;
  }

  HWY_INLINE std::size_t count() const { return found_.count; }
  /// The cell of a change that was noted and is not complete.
  HWY_INLINE std::size_t cell_of(std::size_t noted) const { return static_cast<std::size_t>(found_.ray[noted]); }

  /// Keeps changes of side as crossings of known rays.
  /// @param place       index of each among the crossings of its ray
  /// @param root_count  crossings with its surface in its cell
  HWY_INLINE void keep(const FoundIn& at, MaskF lanes, VecF low, VecF high, VecI place, VecI root_count) {
    if (found_.count >= FoundCrossings::full) write();
    const std::size_t first = found_.count;
    put(at, lanes, low, high, place, root_count);
    std::size_t c = first;
    for (std::uint64_t bits = bits_of(floats, lanes); bits != 0; bits &= bits - 1, ++c) {
      const std::size_t ray = at.ray + static_cast<std::size_t>(std::countr_zero(bits));
      found_.ray[c] = static_cast<std::int32_t>(ray);
      found_.t_block[c] = scratch_.ways.t_block[ray];
    }
  }

  /// Keeps changes of side in cells whose rays are set later by `complete`: it is not known yet
  /// which of these changes are crossings.
  /// @param at     its `ray` is the first of the cells
  /// @param place  index among the changes in the cell
  HWY_INLINE void note(const FoundIn& at, MaskF lanes, VecF low, VecF high, VecI place, VecI root_count) {
    const std::size_t first = found_.count;
    const ChosenLanes chosen = put(at, lanes, low, high, place, root_count);
    hn::StoreU(hn::Add(chosen.numbers(), hn::Set(ints, static_cast<std::int32_t>(at.ray))), ints, found_.ray + first);
  }
  /// Makes crossings of the changes noted from `first` on, in cells of the rays from r on.
  /// @param place_of  (cell, index among the changes in it): returns the index among the crossings
  ///                  of its ray; below 0: it is no crossing
  template <class PlaceOf>
  HWY_INLINE void complete(std::size_t first, std::size_t r, const CellsAhead& cells, const PlaceOf& place_of) {
    for (std::size_t c = first; c < found_.count; ++c) {
      const auto cell = static_cast<std::size_t>(found_.ray[c]);
      const std::size_t ray = r + static_cast<std::size_t>(cells.lane[cell]);
      found_.place[c] = place_of(cell, found_.place[c]);
      found_.ray[c] = static_cast<std::int32_t>(ray);
      found_.t_block[c] = scratch_.ways.t_block[ray];
    }
    if (found_.count >= FoundCrossings::full) write();
  }

  /// Refines and writes all kept changes.
  HWY_NOINLINE void write() {
    for (std::size_t first = 0; first < found_.count; first += 2 * float_lanes) {
      const Corners corners_a = corners_at(first), corners_b = corners_at(first + float_lanes);
      RootSearch a = search_from(corners_a, first), b = search_from(corners_b, first + float_lanes);
      refine(a, b);
      write(a, corners_a, first), write(b, corners_b, first + float_lanes);
    }
    found_.count = 0;
  }

 private:
  /// Adds all data of changes in some lanes, except their rays.
  HWY_INLINE ChosenLanes put(const FoundIn& at, MaskF lanes, VecF low, VecF high, VecI place, VecI root_count) {
    const std::size_t n = found_.count;
    const ChosenLanes chosen(lanes);
    const auto put_one = [&](VecF numbers, float* to) HWY_ATTR { hn::StoreU(chosen.first(numbers), floats, to + n); };
    for (int c = 0; c < 8; ++c) put_one(at.corners.f[c], found_.corner[c]);
    for (int a = 0; a < 3; ++a) put_one(at.in[a], found_.in[a]), put_one(at.out[a], found_.out[a]);
    if (!shells_.only_places) {
      for (int a = 0; a < 3; ++a) put_one(hn::Add(at.block_corner[a], at.next.cell[a]), found_.cell[a]);
      hn::StoreU(chosen.first(root_count), ints, found_.root_count + n);
    }
    put_one(at.next.way_in, found_.way_in), put_one(at.next.way_out, found_.way_out);
    put_one(low, found_.low), put_one(high, found_.high);
    hn::StoreU(chosen.first(place), ints, found_.place + n);
    found_.count += hn::CountTrue(floats, lanes);
    return chosen;
  }

  /// Arrays are read beyond what is kept, but not beyond their ends; these numbers are not used.
  HWY_INLINE static std::size_t readable(std::size_t first) {
    return first + float_lanes <= FoundCrossings::capacity ? first : FoundCrossings::capacity - float_lanes;
  }
  HWY_INLINE VecF load(const float* from, std::size_t first) const { return hn::LoadU(floats, from + readable(first)); }

  /// Minus the surface's isovalue.
  HWY_INLINE Corners corners_at(std::size_t first) const {
    Corners corners;
    for (int c = 0; c < 8; ++c) corners.f[c] = load(found_.corner[c], first);
    if (!has_values_) return corners;
    for (VecF& f : corners.f) f = less_isovalue(f, shells_.surface[surface_].isovalue, shells_.is_single[surface_]);
    return corners;
  }

  HWY_INLINE RootSearch search_from(const Corners& corners, std::size_t first) const {
    VecF in[3], out[3];
    for (int a = 0; a < 3; ++a) in[a] = load(found_.in[a], first), out[a] = load(found_.out[a], first);
    const MaskF used = hn::FirstN(floats, found_.count > first ? found_.count - first : 0);
    return RootSearch(along(corners, in, out), hn::IfThenElseZero(used, load(found_.low, first)),
                      hn::IfThenElseZero(used, load(found_.high, first)));
  }

  HWY_INLINE void write(const RootSearch& searched, const Corners& corners, std::size_t first) {
    if (first >= found_.count) return;
    const Roots& roots = searched.roots();
    VecF p[3], gradient[3];
    const VecF rest = hn::Sub(hn::Set(floats, 1.0f), roots.s);
    for (int a = 0; a < 3; ++a) p[a] = between(load(found_.in[a], first), load(found_.out[a], first), roots.s, rest);
    gradient_at(corners, p, gradient);
    const VecF way_in = load(found_.way_in, first);
    const VecF way = hn::MulAdd(roots.s, hn::Sub(load(found_.way_out, first), way_in), way_in);
    HWY_ALIGN float ways[float_lanes], gradients[3][float_lanes];
    HWY_ALIGN std::int32_t iterations[float_lanes];
    hn::Store(way, floats, ways);
    for (int a = 0; a < 3; ++a)
      hn::Store(lattice_.is_mirrored(a) ? hn::Neg(gradient[a]) : gradient[a], floats, gradients[a]);
    hn::Store(roots.iterations, ints, iterations);
    const std::size_t count = found_.count - first < float_lanes ? found_.count - first : float_lanes;
    for (std::size_t i = 0; i < count; ++i)
      write_one(first + i, static_cast<double>(ways[i]), {gradients[0][i], gradients[1][i], gradients[2][i]},
                iterations[i]);
  }

  HWY_INLINE void write_one(std::size_t i, double way, const float (&gradient)[3], std::int32_t iterations) {
    if (found_.place[i] < 0) return;
    const IsosurfaceScratch& ways = scratch_.ways;
    const auto ray = static_cast<std::size_t>(found_.ray[i]);
    const std::size_t r = first_ray_ + ways.group.index[ray];
    const HitArrays& to = list_.hits[found_.place[i]];
    const double t = found_.t_block[i] + way * ways.t_per_way[ray];
    to.t[r] = t < ways.group.t_out[ray] ? t : ways.group.t_out[ray];
    for (int a = 0; a < 3; ++a) to.gradient[a][r] = static_cast<double>(gradient[a]);
    if (!shells_.only_places) write_cell(i, iterations, r, to);
  }

  HWY_INLINE void write_cell(std::size_t i, std::int32_t iterations, std::size_t r, const HitArrays& to) {
    to.value[r] = shells_.surface[surface_].isovalue;
    std::uint64_t cell = 0;
    for (int a = 2; a >= 0; --a) {
      const auto mirrored = static_cast<std::int64_t>(found_.cell[a][i]);
      const std::int64_t at = lattice_.is_mirrored(a) ? 16 * lattice_.node_count[a] - 1 - mirrored : mirrored;
      cell = cell * static_cast<std::uint64_t>(shells_.surface[0].leaf_count[a]) + static_cast<std::uint64_t>(at);
    }
    to.cell[r] = cell;
    to.root_count[r] = static_cast<std::uint32_t>(found_.root_count[i]);
    to.iteration_count[r] = static_cast<std::uint32_t>(iterations);
  }

  const TransparentSurfaces& shells_;
  const int surface_;
  const MirroredLattice& lattice_;
  const bool has_values_;
  const CrossingArrays& list_;
  const std::size_t first_ray_;
  GridAllHitsScratch& scratch_;
  FoundCrossings& found_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
