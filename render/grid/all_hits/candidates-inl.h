// Candidate cells for transparent surfaces: all that rays have ahead in their blocks at once,
// whichever ray's they are, so that every lane has one.
#if defined(RHORAY_WIDE_SHELL_LOOKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_SHELL_LOOKS_INL_H
#undef RHORAY_WIDE_SHELL_LOOKS_INL_H
#else
#define RHORAY_WIDE_SHELL_LOOKS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/all_hits/hits-inl.h"
#include "render/grid/all_hits/slabs-inl.h"
#include "render/grid/isosurface/block_corners-inl.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/grid/isosurface/cubic-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Rays on their way through the cells of a block, each in its own block, with what Lanes has of
/// one surface for each surface.
template <int surfaces>
struct AllHitsLanes : Lanes {
  VecI active_of[surfaces][2], inside_out_of[surfaces][2], seen_of[surfaces];
  VecF error;  ///< as in BlockSlabs
  MaskF inside_of[surfaces], has_side_of[surfaces];
};

/// For each of 64 bits, in two words, whether an odd number of lower bits is set; and the parity of
/// all bits.
struct PrefixParity {
  VecI word[2];
  MaskF of_all;

  explicit HWY_INLINE PrefixParity(const VecI* bits) {
    VecI up_to[2];
    for (int w = 0; w < 2; ++w) {
      VecI x = bits[w];
      x = hn::Xor(x, hn::ShiftLeft<1>(x)), x = hn::Xor(x, hn::ShiftLeft<2>(x)), x = hn::Xor(x, hn::ShiftLeft<4>(x));
      x = hn::Xor(x, hn::ShiftLeft<8>(x)), x = hn::Xor(x, hn::ShiftLeft<16>(x));
      up_to[w] = x;
    }
    const VecI of_first = hn::ShiftRight<31>(up_to[0]);  // all of its bits
    word[0] = hn::ShiftLeft<1>(up_to[0]);
    word[1] = hn::Xor(hn::ShiftLeft<1>(up_to[1]), of_first);
    of_all = hn::RebindMask(floats, hn::Lt(hn::Xor(up_to[1], of_first), hn::Zero(ints)));
  }
};

/// Searches the cells of rays that pass their blocks. Every cell is searched as if the ray came to
/// it on the side on which the cell's own field begins. For most rays each such side is the one
/// that the changes before have led to, and so is the side of the cells between. Then the result is
/// that of searching one cell after another. The few other rays are left to be searched in that
/// way.
template <int surfaces>
class AllHitsCandidates {
 public:
  HWY_INLINE AllHitsCandidates(const TransparentSurfaces& shells, const LatticeEnds& ends, const BlockCorners& corners,
                               bool has_values, GridAllHitsScratch& scratch, HitLists* hits, KernelCounters& counters)
      : shells_(shells),
        ends_(ends),
        corners_(corners),
        has_values_(has_values),
        scratch_(scratch),
        cells_(scratch.cells),
        hits_(hits),
        counters_(counters) {}

  /// Corners of some lanes' cells, minus a surface's isovalue.
  /// @param values  at the corners, where values are kept
  HWY_INLINE Corners corners_less_isovalue(int s, const Corners& values, const VecF* cell, VecI samples,
                                           MaskF asked) const {
    return has_values_ ? less_its_isovalue(s, values) : corners_.of(cell, samples, scratch_.blocks[s], asked);
  }

  /// Records the crossings of the rays from r on. Rays that are left remain unchanged.
  /// @param went_by  bits of lanes: rays that have passed cells outside, or inside, before their
  ///                 side was known; rays that do so here are added
  /// @param ended    bits of lanes: rays that must go no farther
  /// @param full     of these, rays with a crossing that was not recorded
  /// @return         bits of lanes that are left
  HWY_INLINE std::uint64_t take(AllHitsLanes<surfaces>& lanes, std::size_t r, const VecF* block_corner,
                                const BetweenSlabs& between, std::uint64_t (&went_by)[surfaces][2], bool is_at_border,
                                std::uint64_t& ended, std::uint64_t& full) {
    const std::uint64_t walking = bits_of(floats, lanes.walking);
    list_cells(lanes, block_corner, is_at_border);
    FirstFound first_found;
    for (int s = 0; s < surfaces; ++s) first_found.of[s] = hits_[s].count();
    has_many_ = false;
    for (std::size_t first = 0; first < cells_.count; first += float_lanes)
      look(lanes, first, block_corner, is_at_border);
    note_changes(first_found);
    std::uint64_t unsure = 0;
    const std::uint64_t strays = find_strays(lanes, block_corner, between, went_by, is_at_border, unsure);
    ended = full = walking & unsure;
    const std::uint64_t left = walking & strays & ~unsure;
    if (HWY_LIKELY((left | ended) == 0 && !has_many_ && all_go_on(r, walking)))
      complete_all(first_found, r);
    else
      complete_until_ended(first_found, r, left, ended, full);
    return left;
  }

 private:
  /// For each surface, the index of the first noted change whose ray is not known yet.
  struct FirstFound {
    std::size_t of[surfaces];
  };

  /// Lists all cells that the rays pass and that must be searched; those of each ray are in order.
  HWY_INLINE void list_cells(const AllHitsLanes<surfaces>& lanes, const VecF* block_corner, bool is_at_border) {
    const VecI zero = hn::Zero(ints);
    VecI any[2] = {zero, zero};
    for (int s = 0; s < surfaces; ++s)
      for (int w = 0; w < 2; ++w) {
        active_[s][w] = hn::And(lanes.left[w], lanes.active_of[s][w]);
        any[w] = hn::Or(any[w], active_[s][w]);
        hn::Store(zero, ints, odd_[s][w]);
      }
    cells_.count = 0;
    passed_[0] = passed_[1] = zero;
    for_each_passed(lanes, any, block_corner, is_at_border, [&](const NextCell& cell, MaskF passes) HWY_ATTR {
      const VecF bit = hn::MulAdd(hn::Set(floats, 16.0f), cell.cell[2],
                                  hn::MulAdd(hn::Set(floats, 4.0f), cell.cell[1], cell.cell[0]));
      const ChosenLanes chosen(passes);
      hn::StoreU(chosen.first(hn::ConvertTo(ints, bit)), ints, cells_.bit + cells_.count);
      hn::StoreU(chosen.numbers(), ints, cells_.lane + cells_.count);
      cells_.count += hn::CountTrue(floats, passes);
      const VecI passed = hn::IfThenElseZero(hn::RebindMask(ints, passes), cell.bit);
      passed_[0] = hn::Or(passed_[0], hn::IfThenZeroElse(cell.in_second, passed));
      passed_[1] = hn::Or(passed_[1], hn::IfThenElseZero(cell.in_second, passed));
    });
    hn::StoreU(zero, ints, cells_.lane + cells_.count);
    hn::StoreU(zero, ints, cells_.bit + cells_.count);
  }

  /// Calls act(cell, lanes) for some cells of the rays, as far as they pass them.
  /// @param words  which cells
  template <class Act>
  HWY_INLINE void for_each_passed(const AllHitsLanes<surfaces>& lanes, const VecI* words, const VecF* block_corner,
                                  bool is_at_border, const Act& act) const {
    VecI left[2] = {words[0], words[1]};
    while (!hn::AllTrue(ints, hn::Eq(hn::Or(left[0], left[1]), hn::Zero(ints)))) {
      const NextCell cell = first_of(lanes, left);
      left[0] = hn::Xor(left[0], hn::IfThenZeroElse(cell.in_second, cell.bit));
      left[1] = hn::Xor(left[1], hn::IfThenElseZero(cell.in_second, cell.bit));
      MaskF passes = hn::And(cell.exists, hn::Lt(cell.way_in, cell.way_out));
      if (is_at_border) passes = hn::And(passes, is_in_lattice(ends_, cell, block_corner));
      act(cell, passes);
    }
  }

  /// Looks up what is known of each cell's ray.
  class OfCells {
   public:
    explicit HWY_INLINE OfCells(VecI lane)
        : from_(hn::IndicesFromVec(floats, lane)), from_ints_(hn::IndicesFromVec(ints, lane)) {}

    HWY_INLINE VecF operator()(VecF of_rays) const { return hn::TableLookupLanes(of_rays, from_); }
    HWY_INLINE VecI operator()(VecI of_rays) const { return hn::TableLookupLanes(of_rays, from_ints_); }
    /// One of 64 bits, in two words.
    HWY_INLINE MaskF operator()(const VecI* of_rays, VecI bit) const {
      const VecI low = hn::TableLookupLanes(of_rays[0], from_ints_),
                 high = hn::TableLookupLanes(of_rays[1], from_ints_);
      const VecI word = hn::IfThenElse(hn::Lt(bit, hn::Set(ints, 32)), low, high), one = hn::Set(ints, 1);
      const VecI mask = hn::Shl(one, hn::And(bit, hn::Set(ints, 31)));
      return hn::RebindMask(floats, hn::Ne(hn::And(word, mask), hn::Zero(ints)));
    }

   private:
    decltype(hn::IndicesFromVec(floats, VecI())) from_;
    decltype(hn::IndicesFromVec(ints, VecI())) from_ints_;
  };

  HWY_INLINE OfCells of_cells(std::size_t first) const { return OfCells(hn::Load(ints, cells_.lane + first)); }

  /// Searches the cells from `first` on.
  HWY_INLINE void look(const AllHitsLanes<surfaces>& lanes, std::size_t first, const VecF* block_corner,
                       bool is_at_border) {
    const OfCells of = of_cells(first);
    const VecI bit = hn::Load(ints, cells_.bit + first);
    Lanes ways;
    VecF corner_of[3];
    for (int a = 0; a < 3; ++a) {
      ways.entry[a] = of(lanes.entry[a]);
      ways.last[a] = is_at_border ? of(lanes.last[a]) : hn::Set(floats, 3.0f);
      ways.slope[a] = of(lanes.slope[a]), ways.inverse_slope[a] = of(lanes.inverse_slope[a]);
      corner_of[a] = shells_.only_places ? hn::Zero(floats) : of(block_corner[a]);
    }
    ways.end = of(lanes.end), ways.samples = of(lanes.samples);
    NextCell cell;
    const VecI three = hn::Set(ints, 3);
    cell.cell[0] = hn::ConvertTo(floats, hn::And(bit, three));
    cell.cell[1] = hn::ConvertTo(floats, hn::And(hn::ShiftRight<2>(bit), three));
    cell.cell[2] = hn::ConvertTo(floats, hn::ShiftRight<4>(bit));
    find_ways(ways, cell);
    const MaskF looks = hn::FirstN(floats, cells_.count - first);
    VecF in[3], out[3];
    ends_in_cell(ways, cell, in, out);
    MaskF here[surfaces];
    for (int s = 0; s < surfaces; ++s) {
      here[s] = surfaces > 1 ? hn::And(looks, of(active_[s], bit)) : looks;
      cells_.looks[s][first / float_lanes] = {.looked = bits_of(floats, here[s]), .begins_inside = 0};
      counters_.cells_solved += hn::CountTrue(floats, here[s]);
    }
    if (!has_values_) {
      for (int s = 0; s < surfaces; ++s) {
        const Corners corners = corners_.of(cell.cell, ways.samples, scratch_.blocks[s], here[s]);
        look_closely({corners, cell, in, out, corner_of, first, s}, here[s]);
      }
      return;
    }
    const Corners values = corners_.of(cell.cell, ways.samples, scratch_.blocks[0], looks);
    const CubicLanes cubic = along(values, in, out);
    const VecF error = of(lanes.error);
    for (int s = 0; s < surfaces; ++s) {
      const FoundIn at{values, cell, in, out, corner_of, first, s};
      look_from_afar(at, cubic, error, here[s]);
    }
  }

  /// Searches cells for a surface where the field along the ways is known up to errors. Cells in
  /// which it is closer to the isovalue than these errors, where that matters, are searched
  /// closely.
  HWY_INLINE void look_from_afar(const FoundIn& at, const CubicLanes& cubic, VecF error, MaskF here) {
    const VecF isovalue = hn::Set(floats, static_cast<float>(shells_.surface[at.surface].isovalue));
    const VecF low = hn::Sub(isovalue, error), high = hn::Add(isovalue, error);
    const VecF least = hn::Min(hn::Min(cubic.b[0], cubic.b[1]), hn::Min(cubic.b[2], cubic.b[3]));
    const VecF most = hn::Max(hn::Max(cubic.b[0], cubic.b[1]), hn::Max(cubic.b[2], cubic.b[3]));
    const MaskF is_clear = hn::Or(hn::Lt(most, low), hn::Gt(least, high)), open = hn::AndNot(is_clear, here);
    cells_.looks[at.surface][at.ray / float_lanes].begins_inside = bits_of(floats, hn::Ge(cubic.b[0], isovalue));
    if (hn::AllFalse(floats, open)) return;
    // One change, if the coefficients have one change of sign (pieces_of) and both ends are clear.
    const auto is_below = [&](int i) HWY_ATTR { return hn::Lt(cubic.b[i], low); };
    const auto is_above = [&](int i) HWY_ATTR { return hn::Gt(cubic.b[i], high); };
    const MaskF rises = hn::And(hn::And(is_below(0), is_above(3)), hn::Or(is_below(1), is_above(2)));
    const MaskF falls = hn::And(hn::And(is_above(0), is_below(3)), hn::Or(is_above(1), is_below(2)));
    const MaskF once = hn::And(open, hn::Or(rises, falls)), unclear = hn::AndNot(once, open);
    if (!hn::AllFalse(floats, once)) {
      const VecI one = hn::Set(ints, 1);
      hits_[at.surface].note(at, once, hn::Zero(floats), hn::Set(floats, 1.0f), hn::Zero(ints), one);
    }
    if (HWY_UNLIKELY(!hn::AllFalse(floats, unclear))) look_closely(at, unclear);
  }

  /// Searches cells for a surface by the differences to its isovalue, as is done for a ray that
  /// searches one cell after another.
  HWY_NOINLINE void look_closely(const FoundIn& at, MaskF here) {
    const Corners corners = has_values_ ? less_its_isovalue(at.surface, at.corners) : at.corners;
    const CubicLanes cubic = along(corners, at.in, at.out);
    const MaskF side = is_inside(cubic.b[0]);
    CandidateMask& found = cells_.looks[at.surface][at.ray / float_lanes];
    const std::uint64_t looked = bits_of(floats, here);
    found.begins_inside = (found.begins_inside & ~looked) | (bits_of(floats, side) & looked);
    const Pieces pieces = pieces_of(cubic, side, here);
    VecI root_count = hn::Zero(ints), place = root_count;
    for_each_change(cubic, pieces, side,
                    [&](MaskF changed, VecF, VecF) HWY_ATTR { root_count = hn::Add(root_count, ones_in(changed)); });
    has_many_ |= !hn::AllFalse(ints, hn::Gt(root_count, hn::Set(ints, 1)));
    for_each_change(cubic, pieces, side, [&](MaskF changed, VecF low, VecF high) HWY_ATTR {
      if (hn::AllFalse(floats, changed)) return;
      hits_[at.surface].note(at, changed, low, high, place, root_count);
      place = hn::Add(place, ones_in(changed));
    });
  }

  /// Finds, for each ray, the cells with an odd number of changes.
  HWY_INLINE void note_changes(const FirstFound& first) {
    for (int s = 0; s < surfaces; ++s)
      for (std::size_t f = first.of[s]; f < hits_[s].count(); ++f) {
        const std::size_t c = hits_[s].cell_of(f);
        const std::int32_t bit = cells_.bit[c];
        odd_[s][bit / 32][cells_.lane[c]] ^= static_cast<std::int32_t>(std::uint32_t{1} << bit % 32);
      }
  }

  /// Finds the sides of rays that have searched no cell before: the side that they are known to
  /// have in front of the heights between which they are searched, or that of the first cell
  /// searched.
  /// @param has_side  receives the rays that search a cell
  HWY_INLINE void find_first_sides(int s, std::uint64_t without_side, const BetweenSlabs& between,
                                   std::uint64_t& inside, std::uint64_t& has_side) const {
    const VecI looked = hn::Or(hn::And(passed_[0], active_[s][0]), hn::And(passed_[1], active_[s][1]));
    const std::uint64_t finds = without_side & bits_of(ints, hn::Ne(looked, hn::Zero(ints)));
    const std::uint64_t is_cut = finds & bits_of(floats, between.is_cut_in_front);
    inside |= is_cut & bits_of(floats, between.inside_in_front);
    has_side |= finds;
    std::uint64_t left = finds & ~is_cut;
    for (std::size_t first = 0; left != 0; first += float_lanes) {
      const CandidateMask& found = cells_.looks[s][first / float_lanes];
      for (std::uint64_t bits = found.looked; bits != 0 && left != 0; bits &= bits - 1) {
        const int i = std::countr_zero(bits);
        const std::uint64_t lane = left & std::uint64_t{1} << cells_.lane[first + static_cast<std::size_t>(i)];
        left ^= lane;
        if ((found.begins_inside >> i & 1) != 0) inside |= lane;
      }
    }
  }

  /// Records that some rays have passed what lies in front of the heights between which they are
  /// searched, or behind them.
  HWY_INLINE static void go_by(const BetweenSlabs& between, std::uint64_t rays, std::uint64_t (&went_by)[2]) {
    const std::uint64_t front = rays & bits_of(floats, between.is_cut_in_front),
                        behind = rays & bits_of(floats, between.is_cut_behind),
                        inside_in_front = bits_of(floats, between.inside_in_front);
    went_by[1] |= (front & inside_in_front) | (behind & ~inside_in_front);
    went_by[0] |= (front & ~inside_in_front) | (behind & inside_in_front);
  }

  /// Finds the sides of the rays behind their blocks.
  /// @param unsure  receives bits of lanes: rays that have passed cells on both sides, or on
  ///                another side than they first have here, and rays that have no side yet and then
  ///                come to a cell on another side than its own
  /// @return        bits of lanes that come to a cell on another side than its own
  HWY_INLINE std::uint64_t find_strays(AllHitsLanes<surfaces>& lanes, const VecF* block_corner,
                                       const BetweenSlabs& between, std::uint64_t (&went_by)[surfaces][2],
                                       bool is_at_border, std::uint64_t& unsure) const {
    std::uint64_t strays = 0, has_all_sides = ~std::uint64_t{0};
    MaskF inside_behind[surfaces], has_side_behind[surfaces];
    VecI off[2] = {hn::Zero(ints), hn::Zero(ints)};  // cells between the searched ones
    for (int s = 0; s < surfaces; ++s) {
      std::uint64_t has_side = bits_of(floats, lanes.has_side_of[s]);
      std::uint64_t inside = bits_of(floats, lanes.inside_of[s]) & has_side;
      const MaskF without_side = hn::AndNot(lanes.has_side_of[s], lanes.walking);
      const MaskF is_seen = hn::RebindMask(floats, hn::Ne(lanes.seen_of[s], hn::Zero(ints)));
      if (!hn::AllFalse(floats, without_side)) {
        const std::uint64_t had_side = has_side;
        find_first_sides(s, bits_of(floats, without_side), between, inside, has_side);
        const std::uint64_t still_without = bits_of(floats, hn::And(without_side, is_seen)) & ~has_side;
        has_all_sides &= ~bits_of(floats, without_side);
        go_by(between, still_without, went_by[s]);
        unsure |= still_without & went_by[s][0] & went_by[s][1];
        unsure |= has_side & ~had_side & ((inside & went_by[s][0]) | (~inside & went_by[s][1]));
      }
      const VecI changes[2] = {hn::Load(ints, odd_[s][0]), hn::Load(ints, odd_[s][1])};
      const PrefixParity odd(changes);
      const MaskF begins_inside = mask_of(floats, inside);
      has_side_behind[s] = mask_of(floats, has_side);
      const VecI begins = hn::VecFromMask(ints, hn::RebindMask(ints, begins_inside));
      const VecI side[2] = {hn::Xor(odd.word[0], begins), hn::Xor(odd.word[1], begins)};
      const VecI known = hn::And(lanes.seen_of[s], hn::VecFromMask(ints, hn::RebindMask(ints, has_side_behind[s])));
      for (int w = 0; w < 2; ++w)
        off[w] = hn::Or(off[w], hn::And(hn::AndNot(lanes.active_of[s][w], lanes.left[w]),
                                        hn::And(hn::Xor(lanes.inside_out_of[s][w], side[w]), known)));
      for (std::size_t first = 0; first < cells_.count; first += float_lanes) {
        const CandidateMask& found = cells_.looks[s][first / float_lanes];
        const MaskF comes_inside = of_cells(first)(side, hn::Load(ints, cells_.bit + first));
        std::uint64_t other = found.looked & (found.begins_inside ^ bits_of(floats, comes_inside));
        for (; other != 0; other &= other - 1)
          strays |= std::uint64_t{1} << cells_.lane[first + static_cast<std::size_t>(std::countr_zero(other))];
      }
      inside_behind[s] = hn::Xor(begins_inside, odd.of_all);
      const MaskF off_in_front = hn::And(between.is_cut_in_front, hn::Xor(begins_inside, between.inside_in_front));
      const MaskF off_behind =  // there the ray is on the other side
          hn::AndNot(hn::Xor(inside_behind[s], between.inside_in_front), between.is_cut_behind);
      strays |= has_side & bits_of(floats, hn::And(is_seen, hn::Or(off_in_front, off_behind)));
    }
    for_each_passed(lanes, off, block_corner, is_at_border,
                    [&](const NextCell&, MaskF passes) HWY_ATTR { strays |= bits_of(floats, passes); });
    unsure |= strays & ~has_all_sides;
    const MaskF is_stray = mask_of(floats, strays);
    for (int s = 0; s < surfaces; ++s) {
      lanes.inside_of[s] = hn::Or(hn::And(is_stray, lanes.inside_of[s]), hn::AndNot(is_stray, inside_behind[s]));
      lanes.has_side_of[s] = hn::Or(hn::And(is_stray, lanes.has_side_of[s]), hn::AndNot(is_stray, has_side_behind[s]));
    }
    return strays;
  }

  HWY_INLINE Corners less_its_isovalue(int s, const Corners& values) const {
    Corners corners;
    for (int c = 0; c < 8; ++c)
      corners.f[c] = less_isovalue(values.f[c], shells_.surface[s].isovalue, shells_.is_single[s]);
    return corners;
  }

  /// Whether all rays go on behind their changes, given that each cell has at most one change for
  /// each surface. If so, the changes are counted.
  HWY_INLINE bool all_go_on(std::size_t r, std::uint64_t walking) {
    VecI count[surfaces], all = hn::Zero(ints);
    for (int s = 0; s < surfaces; ++s) {
      const VecI before = hn::Load(ints, scratch_.count[s] + r);
      constexpr hn::RebindToUnsigned<Ints> words;
      const auto ones_of = [&](int w) HWY_ATTR {
        return hn::BitCast(ints, hn::PopulationCount(hn::BitCast(words, hn::Load(ints, odd_[s][w]))));
      };
      const VecI here = hn::Add(ones_of(0), ones_of(1));
      hn::Store(before, ints, before_[s]);
      count[s] = hn::Add(before, here), all = hn::Add(all, count[s]);
    }
    const auto may_end = hn::Gt(all, hn::Set(ints, shells_.surely_lit));
    if ((walking & bits_of(ints, may_end)) != 0) return false;
    for (int s = 0; s < surfaces; ++s) hn::Store(count[s], ints, scratch_.count[s] + r);
    return true;
  }

  /// Gives the changes their indices among their rays' crossings, where all are counted and all are
  /// crossings.
  HWY_INLINE void complete_all(const FirstFound& first, std::size_t r) {
    for (int s = 0; s < surfaces; ++s)
      hits_[s].complete(first.of[s], r, cells_, [&](std::size_t c, std::int32_t) HWY_ATTR {
        const std::int32_t lane = cells_.lane[c], bit = cells_.bit[c];
        const std::uint64_t changes = static_cast<std::uint32_t>(odd_[s][0][lane]) |
                                      std::uint64_t{static_cast<std::uint32_t>(odd_[s][1][lane])} << 32;
        return before_[s][lane] + std::popcount(changes & ((std::uint64_t{1} << bit) - 1));
      });
  }

  /// The same where some rays end, as far as the rays go.
  /// @param left  lanes whose changes do not count
  HWY_NOINLINE void complete_until_ended(const FirstFound& first, std::size_t r, std::uint64_t left,
                                         std::uint64_t& ended, std::uint64_t& full) {
    for (int s = 0; s < surfaces; ++s) {
      for (std::size_t c = 0; c < cells_.count; ++c) cells_.changes[s][c] = 0;
      for (std::size_t f = first.of[s]; f < hits_[s].count(); ++f) ++cells_.changes[s][hits_[s].cell_of(f)];
    }
    for (std::size_t c = 0; c < cells_.count; ++c) {
      std::int32_t changes = 0;
      for (int s = 0; s < surfaces; ++s) changes += cells_.changes[s][c];
      if (changes != 0) link_one(c, r, left, ended, full);
    }
    for (int s = 0; s < surfaces; ++s)
      hits_[s].complete(first.of[s], r, cells_, [&](std::size_t c, std::int32_t in_cell) HWY_ATTR {
        const std::int32_t before = cells_.place[s][c], place = before + in_cell;
        return before >= 0 && place < std::int32_t{CrossingList::most} ? place : CellsAhead::nowhere;
      });
  }

  HWY_INLINE void link_one(std::size_t c, std::size_t r, std::uint64_t left, std::uint64_t& ended,
                           std::uint64_t& full) {
    const std::uint64_t lane = std::uint64_t{1} << cells_.lane[c];
    const std::size_t ray = r + static_cast<std::size_t>(cells_.lane[c]);
    const bool is_none = ((left | ended) & lane) != 0;
    float light = 1;
    for (int s = 0; s < surfaces; ++s) {
      cells_.place[s][c] = CellsAhead::nowhere;
      if (is_none) continue;
      std::int32_t& count = scratch_.count[s][ray];
      cells_.place[s][c] = count;
      for (std::int32_t change = 0; change < cells_.changes[s][c]; ++change) {
        if (count == CrossingList::most) {
          full |= lane;
          break;
        }
        ++count;
      }
      light *= shells_.passing[s][count];
    }
    if (light < shells_.least_light || (full & lane) != 0) ended |= lane;
  }

  const TransparentSurfaces& shells_;
  const LatticeEnds& ends_;
  const BlockCorners& corners_;
  const bool has_values_;
  GridAllHitsScratch& scratch_;
  CellsAhead& cells_;
  HitLists* const hits_;  ///< by surface
  KernelCounters& counters_;
  VecI active_[surfaces][2];  ///< cells that rays may have to search
  VecI passed_[2];            ///< of these, over all surfaces, the cells that they pass
  /// Of these, by ray, the cells with an odd number of changes.
  HWY_ALIGN std::int32_t odd_[surfaces][2][float_lanes];
  /// Crossings of each ray in front of its block.
  HWY_ALIGN std::int32_t before_[surfaces][float_lanes];
  bool has_many_;  ///< some cell has more than one change of a surface
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
