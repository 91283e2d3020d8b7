// Walks rays side by side from cell to cell of a box, in single precision.
#if defined(RHORAY_WIDE_MAXIMUM_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_WALK_INL_H
#undef RHORAY_WIDE_MAXIMUM_WALK_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_WALK_INL_H
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/grid/largest/candidates-inl.h"
#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// A box of cells in the mirrored lattice. Axes are in the order w, u, v: the major one, then the
/// minor ones in rising order.
struct CellBox {
  double low_w;   ///< where it begins on the major axis
  float last[3];  ///< index of its last cell on each axis
  /// Index of its lowest cell in its arrays, and the distances between neighbours.
  std::int32_t first, stride[3];
  double highest, unit;  ///< values are (value - highest) * unit
  float error;           ///< more than values are off, in that unit
  float margin;          ///< more than positions are off
  bool is_come_to;       ///< rays reach it through other cells, with data
};

/// Rays in coordinates from the box's lowest corner: positions on the minor axes as functions of
/// that on the major one.
struct Ways {
  VecI ray;
  VecF from, to;  ///< parts in the box; lanes whose part has no length do nothing
  VecF start[2], slope[2], inverse[2];
  VecF reached, reached_at;  ///< in the box's unit and coordinates
};

/// How rays are spread over the lanes of a vector. Where there are few, each occurs several times,
/// with a part of a block of 4 cells each time.
struct Spread {
  HWY_ALIGN std::int32_t lane[float_lanes];  ///< lane of the ray
  /// Of the part, on the major axis; none where first > last.
  HWY_ALIGN float first[float_lanes], last[float_lanes];
};

/// By the number of rays.
inline constexpr auto spreads = [] {
  std::array<Spread, float_lanes + 1> by_rays{};
  for (std::size_t rays = 1; rays <= float_lanes; ++rays) {
    Spread& spread = by_rays[rays];
    const std::size_t parts = 4 * rays <= float_lanes ? 4 : 2 * rays <= float_lanes ? 2 : 1;
    for (std::size_t lane = 0; lane < float_lanes; ++lane) {
      const std::size_t part = lane / rays;
      spread.lane[lane] = static_cast<std::int32_t>(lane % rays);
      if (part >= parts) {
        spread.first[lane] = 8, spread.last[lane] = 0;
        continue;
      }
      // At both ends positions may be a little outside.
      const float length = 4.0F / static_cast<float>(parts);
      spread.first[lane] = part == 0 ? -1 : length * static_cast<float>(part);
      spread.last[lane] = part + 1 == parts ? 5 : length * static_cast<float>(part + 1);
    }
  }
  return by_rays;
}();

/// A vector of the rays at a box.
HWY_INLINE Ways ways_at_box(const RaysAtBlock& at_block, std::size_t first) {
  const auto read = [&](const float* x) HWY_ATTR { return hn::Load(floats, x + first); };
  Ways ways;
  ways.ray = hn::Load(ints, at_block.ray + first);
  ways.from = read(at_block.from), ways.to = read(at_block.to);
  for (int m = 0; m < 2; ++m) {
    ways.start[m] = read(at_block.start[m]), ways.slope[m] = read(at_block.slope[m]);
    ways.inverse[m] = read(at_block.inverse[m]);
  }
  ways.reached = read(at_block.reached), ways.reached_at = read(at_block.reached_at);
  return ways;
}

/// Spreads the first lanes' ways through a block of 4 cells over all lanes, in parts side by side.
HWY_INLINE void spread_out(const Spread& spread, Ways& ways) {
  const auto lanes_of_floats = hn::IndicesFromVec(floats, hn::Load(ints, spread.lane));
  const auto repeat = [&](VecF& x) HWY_ATTR { x = hn::TableLookupLanes(x, lanes_of_floats); };
  for (VecF* x : {&ways.from, &ways.to, &ways.reached, &ways.reached_at}) repeat(*x);
  for (int m = 0; m < 2; ++m) repeat(ways.start[m]), repeat(ways.slope[m]), repeat(ways.inverse[m]);
  ways.ray = hn::TableLookupLanes(ways.ray, hn::IndicesFromVec(ints, hn::Load(ints, spread.lane)));
  ways.from = hn::Max(ways.from, hn::Load(floats, spread.first));
  ways.to = hn::Min(ways.to, hn::Load(floats, spread.last));
}

/// Records what rays have reached in a box.
HWY_NOINLINE void raise(SearchState& state, const CellBox& box, MaskF raised, const Ways& ways) {
  HWY_ALIGN double values[16];
  HWY_ALIGN float values_below[16], places[16];
  HWY_ALIGN std::int32_t rays[16];
  // Single precision has lost more than the rounding of this sum: the error covers both.
  const VecD highest = hn::Set(doubles, box.highest), scale = hn::Set(doubles, 1 / box.unit);
  const VecD zero = hn::Zero(doubles);
  VecD value[parts_of_floats], is_above[parts_of_floats];
  for (std::size_t part = 0; part < parts_of_floats; ++part) {
    value[part] = hn::Add(highest, hn::Mul(as_doubles(ways.reached, part), scale));
    hn::Store(value[part], doubles, values + part * double_lanes);
  }
  const VecF nearest = hn::Min(as_floats(value), hn::Set(floats, std::numeric_limits<float>::max()));
  for (std::size_t part = 0; part < parts_of_floats; ++part)
    is_above[part] = hn::IfThenElse(hn::Gt(as_doubles(nearest, part), value[part]), hn::Set(doubles, 1.0), zero);
  const VecF lower = hn::Min(hn::NegMulAdd(hn::Abs(nearest), hn::Set(floats, 0x1p-23F), nearest),
                             hn::Sub(nearest, hn::Set(floats, std::numeric_limits<float>::min())));
  hn::Store(hn::IfThenElse(hn::Gt(as_floats(is_above), hn::Zero(floats)), lower, nearest), floats, values_below);
  const VecF place = hn::Add(ways.reached_at, hn::Set(floats, static_cast<float>(box.low_w)));
  hn::Store(hn::MulAdd(hn::Abs(place), hn::Set(floats, 0x1p-23F), place), floats, places);
  hn::Store(ways.ray, ints, rays);
  for (std::uint64_t bits = bits_of(floats, raised); bits != 0; bits &= bits - 1) {
    const int lane = std::countr_zero(bits);
    state.set_reached(static_cast<std::size_t>(rays[lane]), values[lane], values_below[lane], places[lane]);
  }
  state.has_risen = true;
}

/// Cells whose largest value is certainly where the ray enters them, through one face and from
/// another cell. On most rays the largest value lies on the plane between two cells, and one of
/// them is enough.
///
/// The cell before has that value too, bit for bit, as the value on a face is both cells'
/// (value_on_face), and its own largest value is no less. It is no farther away and is entered
/// before, so of the two it has the answer. The ray passes the face far from its edges, so it
/// passes no third cell near there. It passes the cell before for so long that this cell is walked
/// through, in this box or in another. There it is added to the suspects unless a larger value was
/// reached. If it is left out as well, its value where it is entered is larger, and the same holds
/// for the cell before it; the cell where the ray begins is not left out. For this reason, cells
/// whose largest value is where the ray leaves them must stay.
///
/// The position p on the axis that is passed is off by little more than two margins. So all in all
/// it is less than 36 margins from where the face is truly passed. This holds where the ray is at
/// least a sixteenth as fast across the face as on all axes together. Values change by 36 margins
/// of the range from there to p, and are off by 3 at p. As the error is 12 of them, coefficients
/// that are eight errors below the first are truly below it: the largest value is where the cell is
/// truly entered.
/// @param p  where they are entered, or a little before
HWY_INLINE MaskF is_left_to_cell_before(const SearchState& state, const CellBox& box, const Ways& ways,
                                        const Coefficients& b, const Point& p) {
  if (!box.is_come_to) return no_lane(floats);
  const VecF falls_from = hn::Sub(b.b0, hn::Set(floats, 8 * box.error));
  const MaskF falls = hn::Lt(hn::Max(hn::Max(b.b1, b.b2), b.b3), falls_from);
  // One of the three coordinates is at the face; the others are clear of its edges.
  const VecF near_edge = hn::Set(floats, state.clear_of_edges), far_edge = hn::Set(floats, 1 - state.clear_of_edges);
  const VecF low = hn::Min(p.u, p.v), high = hn::Max(p.u, p.v);
  const VecF least = hn::Min(low, p.w), middle = hn::Max(low, hn::Min(high, p.w)), most = hn::Max(high, p.w);
  const MaskF is_clear = hn::And(hn::Lt(least, near_edge), hn::And(hn::Gt(middle, near_edge), hn::Lt(most, far_edge)));
  const VecF one = hn::Set(floats, 1.0F), speeds = hn::Add(one, hn::Add(ways.slope[0], ways.slope[1]));
  const VecF on_minor = hn::IfThenElse(hn::Eq(least, p.u), ways.slope[0], ways.slope[1]);
  const VecF across = hn::IfThenElse(hn::Eq(least, p.w), one, on_minor);
  const MaskF is_fast = hn::Ge(hn::Mul(across, hn::Set(floats, 16.0F)), speeds);
  return hn::And(hn::And(falls, is_fast), is_clear);
}

/// Adds what may hold a larger value than was found to the suspects, whose last box is this one.
/// @param cells  cells.coefficients(cell, p, q): along the way from p to q; with cells.is_below
///               they are distances below the box's highest value. Where the cells are not plain,
///               some may be without data, and there is cells.bound(cell): no value in the cell is
///               larger
template <class Cells>
HWY_INLINE void walk_cells(SearchState& state, CandidateRefinement& looks, const CellBox& box, const Cells& cells,
                           Ways ways) {
  Suspects& suspects = state.scratch.suspects;
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0F);
  const VecF never = hn::Set(floats, std::numeric_limits<float>::infinity());
  const VecF error = hn::Set(floats, box.error);
  const VecF last_w = hn::Set(floats, box.last[0]), last_u = hn::Set(floats, box.last[1]),
             last_v = hn::Set(floats, box.last[2]);
  const VecI stride_w = hn::Set(ints, box.stride[0]), stride_u = hn::Set(ints, box.stride[1]),
             stride_v = hn::Set(ints, box.stride[2]);
  const VecF start_u = ways.start[0], start_v = ways.start[1], slope_u = ways.slope[0], slope_v = ways.slope[1];

  const auto clamped = [&](VecF x, VecF last) HWY_ATTR { return hn::Min(hn::Max(hn::Floor(x), zero), last); };
  // The part in the box, up to rounding; what is beyond belongs to another box.
  const float around = box.margin + static_cast<float>(state.exact_margin);
  VecF from = hn::Max(ways.from, hn::Set(floats, -around));
  VecF to = hn::Min(ways.to, hn::Set(floats, box.last[0] + 1 + around));
  for (int m = 0; m < 2; ++m) {
    const VecF first = hn::Set(floats, -around), last = hn::Set(floats, box.last[1 + m] + 1 + around);
    from = hn::Max(from, hn::Mul(hn::Sub(first, ways.start[m]), ways.inverse[m]));
    to = hn::Min(to, hn::Mul(hn::Sub(last, ways.start[m]), ways.inverse[m]));
  }
  VecF p_w = from, p_u = hn::MulAdd(slope_u, from, start_u), p_v = hn::MulAdd(slope_v, from, start_v);
  VecF cell_w = clamped(p_w, last_w), cell_u = clamped(p_u, last_u), cell_v = clamped(p_v, last_v);
  p_w = hn::Sub(p_w, cell_w), p_u = hn::Sub(p_u, cell_u), p_v = hn::Sub(p_v, cell_v);
  VecI cell =
      hn::Add(hn::Add(hn::Set(ints, box.first), hn::Mul(hn::ConvertTo(ints, cell_w), stride_w)),
              hn::Add(hn::Mul(hn::ConvertTo(ints, cell_u), stride_u), hn::Mul(hn::ConvertTo(ints, cell_v), stride_v)));
  // Where the next plane of an axis is passed, on the major axis; never beyond the box's last cell.
  const auto next_on_major = [&]() HWY_ATTR {
    return hn::IfThenElse(hn::Lt(cell_w, last_w), hn::Add(cell_w, one), never);
  };
  const auto next_on_minor = [&](VecF c, VecF last, VecF start, VecF inverse) HWY_ATTR {
    return hn::IfThenElse(hn::Lt(c, last), hn::Mul(hn::Sub(hn::Add(c, one), start), inverse), never);
  };
  VecF next_w = next_on_major(), next_u = next_on_minor(cell_u, last_u, start_u, ways.inverse[0]),
       next_v = next_on_minor(cell_v, last_v, start_v, ways.inverse[1]);

  MaskF active = hn::Le(from, to), raised = no_lane(floats);
  for (;;) {
    const VecF leave = hn::Min(hn::Min(next_w, to), hn::Min(next_u, next_v));
    const VecF q_w = hn::Sub(leave, cell_w), q_u = hn::Sub(hn::MulAdd(slope_u, leave, start_u), cell_u),
               q_v = hn::Sub(hn::MulAdd(slope_v, leave, start_v), cell_v);
    MaskF wanted = active;
    if constexpr (!Cells::is_plain)
      wanted = hn::And(
          active, SearchState::may_improve(hn::Add(cells.bound(cell), error), from, ways.reached, ways.reached_at));
    if (Cells::is_plain || !hn::AllFalse(floats, wanted)) {
      const Coefficients found = cells.coefficients(cell, {p_u, p_v, p_w}, {q_u, q_v, q_w});
      // Without data all coefficients are NaN, or far below the values of the box.
      VecF hull = Cells::is_below ? hn::Neg(found.smallest()) : found.largest();
      if constexpr (!Cells::is_plain) hull = hn::IfThenElseZero(hn::Ge(hull, hn::Set(floats, Cells::lowest)), hull);
      const VecF highest_here = hn::Add(hull, error);
      // Few vectors pass this first, cheaper test.
      MaskF suspect = hn::And(wanted, hn::Ge(highest_here, ways.reached));
      if (!hn::AllFalse(floats, suspect))
        suspect = hn::And(suspect, SearchState::may_improve(highest_here, from, ways.reached, ways.reached_at));
      if (!hn::AllFalse(floats, suspect)) {
        const Coefficients b = Cells::is_below ? found.negated() : found;
        const MaskF kept = hn::AndNot(is_left_to_cell_before(state, box, ways, b, {p_u, p_v, p_w}), suspect);
        if (suspects.count + float_lanes > Suspects::capacity) looks.decide();
        const std::size_t at = suspects.count;
        store_chosen(ints, ways.ray, hn::RebindMask(ints, kept), suspects.ray + at);
        store_chosen(floats, from, kept, suspects.from + at);
        store_chosen(floats, leave, kept, suspects.to + at);
        suspects.count = at + store_chosen(floats, highest_here, kept, suspects.bound + at);

        // A value that is certainly reached: at a point well inside the cell and well inside the
        // ray.
        const VecF s = b.likely_maximum();
        const auto is_inside = [&](VecF p, VecF q) HWY_ATTR {
          const VecF half = hn::Set(floats, 0.5F);
          return hn::Le(hn::Abs(hn::Sub(hn::MulAdd(s, hn::Sub(q, p), p), half)),
                        hn::Set(floats, 0.5F - 3 * box.margin));
        };
        const VecF length = hn::Sub(leave, from);
        const MaskF inside = hn::And(hn::And(is_inside(p_u, q_u), is_inside(p_v, q_v)),
                                     hn::And(is_inside(p_w, q_w), hn::Ge(length, hn::Set(floats, 128 * state.margin))));
        const VecF value = hn::Sub(b.at(s), error);
        MaskF rises = hn::And(suspect, hn::And(inside, hn::Gt(value, ways.reached)));
        if constexpr (!Cells::is_plain)
          rises = hn::And(rises, hn::Le(hn::Abs(hn::Add(hn::Add(b.b0, b.b1), hn::Add(b.b2, b.b3))),
                                        hn::Set(floats, -4 * Cells::lowest)));
        ways.reached = hn::IfThenElse(rises, value, ways.reached);
        const VecF place = hn::MulAdd(s, length, from);
        ways.reached_at = hn::IfThenElse(rises, hn::Add(place, hn::Set(floats, state.margin)), ways.reached_at);
        raised = hn::Or(raised, rises);
      }
    }
    active = hn::And(active, hn::Lt(leave, to));
    if (hn::AllFalse(floats, active)) break;
    const MaskF passes_w = hn::Le(next_w, leave), passes_u = hn::Le(next_u, leave), passes_v = hn::Le(next_v, leave);
    const VecF step_w = hn::IfThenElseZero(passes_w, one), step_u = hn::IfThenElseZero(passes_u, one),
               step_v = hn::IfThenElseZero(passes_v, one);
    cell = hn::Add(cell, hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, passes_w), stride_w),
                                 hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, passes_u), stride_u),
                                         hn::IfThenElseZero(hn::RebindMask(ints, passes_v), stride_v))));
    cell_w = hn::Add(cell_w, step_w), cell_u = hn::Add(cell_u, step_u), cell_v = hn::Add(cell_v, step_v);
    p_w = hn::Sub(q_w, step_w), p_u = hn::Sub(q_u, step_u), p_v = hn::Sub(q_v, step_v);
    next_w = next_on_major(), next_u = next_on_minor(cell_u, last_u, start_u, ways.inverse[0]),
    next_v = next_on_minor(cell_v, last_v, start_v, ways.inverse[1]);
    from = leave;
  }
  if (!hn::AllFalse(floats, raised)) raise(state, box, raised, ways);
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
