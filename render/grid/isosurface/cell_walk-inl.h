// Which cells of their blocks rays pass, and in which order, without stepping from cell to cell.
#if defined(RHORAY_WIDE_CELL_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_CELL_WALK_INL_H
#undef RHORAY_WIDE_CELL_WALK_INL_H
#else
#define RHORAY_WIDE_CELL_WALK_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/block_entry-inl.h"
#include "render/grid/isosurface/margins-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Rays on their way through the cells of a block, each in its own block.
struct Lanes {
  VecF entry[3], slope[3], inverse_slope[3], end;
  VecF last[3];  ///< the last cell
  /// Certified: error of plane times, along the way, and of the points there; else 0.
  VecF way_error;
  VecF range;          ///< certified: range of the block's samples (BlockSamples)
  VecI samples;        ///< offset of the block's samples
  VecI active[2];      ///< cells with corners on both sides, in two words
  VecI inside_out[2];  ///< cells whose lowest corner is inside
  VecI present[2];     ///< cells with data, where the volume has gaps
  VecI left[2];        ///< cells that the ray may still pass
  MaskF inside, has_side;
  MaskF walking;

  /// The cell of an axis in which the ray enters; in the lattice's upper face, the cell below it.
  HWY_INLINE VecF first_cell(int axis) const { return hn::Min(hn::Floor(entry[axis]), last[axis]); }
};

/// A cell that each ray may pass next.
struct NextCell {
  MaskF exists;
  VecI bit;                  ///< the cell's bit in its word
  hn::Mask<Ints> in_second;  ///< true: that is the second word
  VecF cell[3];              ///< 0 to 3
  VecF near[3], far[3];      ///< distances along the way to its planes
  VecF way_in, way_out;
};

/// Bound on the errors of the times of planes inside the block, measured along the way, and of the
/// ray's points at these times.
///
/// An entry is rounded to single precision (2 u of up to 4), a slope and its inverse by u of
/// themselves. So the way to a plane is off by at most 2 u times the inverse slope and 12 u (three
/// roundings of a way of at most 4). The error that double precision makes at the entry is added.
/// The difference of two is off by twice that, and a little of second order. A point at such a time
/// is off by no more than that: by the time's own error and 8 u, or, where it is taken to lie on
/// the plane of another time, by both their errors. Slow axes, whose inverse slope is above
/// `slow_from`, count only where the ray may pass one of their planes inside.
inline constexpr float slow_from = 16;

/// @param r  first of the rays
HWY_INLINE VecF error_of_ways(const IsosurfaceScratch& scratch, const BlockEntry& at, const Lanes& lanes,
                              std::size_t r) {
  const VecF position_error = hn::Load(floats, scratch.position_error + r);
  VecF steepest = hn::Load(floats, scratch.steepest + r);
  const VecF reach = hn::MulAdd(hn::Set(floats, 4.0f), position_error, hn::Set(floats, 0x1p-20f));
  for (int a = 0; a < 3; ++a) {
    const std::uint64_t slow = scratch.slow[a] >> r & first_rays(float_lanes);
    if (slow == 0) continue;
    // The cells between which the ray certainly is, inside the block.
    const VecF low = hn::Floor(hn::Max(hn::Sub(at.entry[a], reach), hn::Zero(floats)));
    const VecF leaves_at = hn::MulAdd(lanes.end, lanes.slope[a], hn::Add(at.entry[a], reach));
    const VecF high = hn::Floor(hn::Min(leaves_at, hn::Add(at.last[a], hn::Set(floats, 0.5f))));
    const MaskF counts = hn::And(mask_of(floats, slow), hn::Lt(low, high));
    steepest = hn::Max(steepest, hn::IfThenElseZero(counts, lanes.inverse_slope[a]));
  }
  const VecF in_single =
      hn::MulAdd(steepest, hn::Set(floats, 4.25f * rounding_unit), hn::Set(floats, 26 * rounding_unit));
  return hn::MulAdd(hn::Mul(hn::Set(floats, 4.0f), position_error), steepest, in_single);
}

/// How far along its way a ray passes plane k of an axis.
HWY_INLINE VecF way_to_plane(const Lanes& lanes, int axis, VecF k) {
  return hn::Mul(hn::Sub(k, lanes.entry[axis]), lanes.inverse_slope[axis]);
}

/// The same for the upper plane of a cell. The upper plane of the block's last cell is not passed
/// inside.
HWY_INLINE VecF way_to_upper_plane(const Lanes& lanes, int axis, VecF cell) {
  const VecF at = way_to_plane(lanes, axis, hn::Add(cell, hn::Set(floats, 1.0f)));
  return hn::IfThenElse(hn::Ge(cell, lanes.last[axis]), hn::Set(floats, never_passed), at);
}

/// Finds the cells that the rays may pass on a part of their ways, a few more than they do: layer
/// by layer along z, the rectangle around the points where the ray enters and leaves the layer.
HWY_INLINE void find_cells(Lanes& lanes, VecF first_way, VecF last_way) {
  constexpr float reach = 0x1p-18f;  // more than all errors of a point
  const VecF zero = hn::Zero(floats), above = hn::Add(hn::Set(floats, reach), lanes.way_error), below = hn::Neg(above);
  VecF way[5];  // of planes 1 to 3, unclipped
  VecF corner[5][2];
  for (int a = 0; a < 2; ++a) {
    corner[0][a] = hn::MulAdd(first_way, lanes.slope[a], lanes.entry[a]);
    corner[4][a] = hn::MulAdd(last_way, lanes.slope[a], lanes.entry[a]);
  }
  for (int k = 1; k < 4; ++k) {
    way[k] = way_to_upper_plane(lanes, 2, hn::Set(floats, static_cast<float>(k - 1)));
    const VecF inside = hn::Min(hn::Max(way[k], first_way), last_way);
    for (int a = 0; a < 2; ++a) corner[k][a] = hn::MulAdd(inside, lanes.slope[a], lanes.entry[a]);
  }
  const auto cell_below = [&](VecF at) HWY_ATTR { return hn::ConvertTo(ints, hn::Max(hn::Add(at, below), zero)); };
  const auto cell_above = [&](VecF at, VecF last)
                              HWY_ATTR { return hn::ConvertTo(ints, hn::Min(hn::Add(at, above), last)); };
  const VecF last_x = hn::Add(lanes.last[0], hn::Set(floats, 0.5f)),
             last_y = hn::Add(lanes.last[1], hn::Set(floats, 0.5f));
  VecI layers[4];
  for (int k = 0; k < 4; ++k) {
    const VecI low_x = cell_below(corner[k][0]), high_x = cell_above(corner[k + 1][0], last_x);
    const VecI low_y = hn::ShiftLeft<2>(cell_below(corner[k][1]));
    const VecI high_y = hn::ShiftLeft<2>(cell_above(corner[k + 1][1], last_y));
    const VecI columns = hn::Sub(hn::Shl(hn::Set(ints, 0x2222), high_x), hn::Shl(hn::Set(ints, 0x1111), low_x));
    const VecI rows = hn::Sub(hn::Shl(hn::Set(ints, 16), high_y), hn::Shl(hn::Set(ints, 1), low_y));
    layers[k] = hn::And(columns, rows);
  }
  const VecF slack = hn::Add(lanes.way_error, lanes.way_error);
  const VecF before = hn::Sub(first_way, slack), behind = hn::Add(last_way, slack);
  for (int k = 0; k < 4; ++k) {
    MaskF passes = k == 0 ? lanes.walking : hn::And(lanes.walking, hn::Lt(way[k], behind));
    if (k < 3) passes = hn::And(passes, hn::Gt(way[k + 1], before));
    layers[k] = hn::IfThenElseZero(hn::RebindMask(ints, passes), layers[k]);
  }
  lanes.left[0] = hn::Or(layers[0], hn::ShiftLeft<16>(layers[1]));
  lanes.left[1] = hn::Or(layers[2], hn::ShiftLeft<16>(layers[3]));
}

/// The number of cells that a ray passes until it leaves the block.
HWY_INLINE VecF cells_passed(const Lanes& lanes) {
  VecF cells = hn::Set(floats, 1.0f);
  for (int a = 0; a < 3; ++a) {
    const VecF last = hn::MulAdd(lanes.end, lanes.slope[a], lanes.entry[a]);
    cells = hn::Add(cells, hn::Min(hn::Floor(hn::Max(last, hn::Zero(floats))), lanes.last[a]));
    cells = hn::Sub(cells, lanes.first_cell(a));
  }
  return cells;
}

/// Finds the cells that the rays may pass on their whole ways.
/// @return  the number of cells that a ray passes until it leaves the block
HWY_INLINE VecF find_cells(Lanes& lanes) {
  find_cells(lanes, hn::Zero(floats), lanes.end);
  return cells_passed(lanes);
}

/// Sets how far along its way a ray passes the planes of a cell, and the cell.
HWY_INLINE void find_ways(const Lanes& lanes, NextCell& next) {
  next.way_in = hn::Zero(floats), next.way_out = lanes.end;
  for (int a = 0; a < 3; ++a) {
    next.near[a] = way_to_plane(lanes, a, next.cell[a]);
    next.far[a] = way_to_upper_plane(lanes, a, next.cell[a]);
    next.way_in = hn::Max(next.way_in, next.near[a]);
    next.way_out = hn::Min(next.way_out, next.far[a]);
  }
}

/// The first of some cells.
/// @param looks  which cells, in two words
HWY_INLINE NextCell first_of(const Lanes& lanes, const VecI* looks) {
  const VecI zero = hn::Zero(ints);
  NextCell next;
  next.in_second = hn::Eq(looks[0], zero);
  const VecI word = hn::IfThenElse(next.in_second, looks[1], looks[0]);
  next.bit = hn::And(word, hn::Neg(word));
  next.exists = hn::RebindMask(floats, hn::Ne(word, zero));
  const VecI power =
      hn::And(hn::ShiftRight<23>(hn::BitCast(ints, hn::ConvertTo(floats, next.bit))), hn::Set(ints, 255));
  const VecI bit = hn::Sub(power, hn::Set(ints, 127)), three = hn::Set(ints, 3);
  const VecI z = hn::Add(hn::ShiftRight<4>(bit), hn::IfThenElseZero(next.in_second, hn::Set(ints, 2)));
  next.cell[0] = hn::ConvertTo(floats, hn::And(bit, three));
  next.cell[1] = hn::ConvertTo(floats, hn::And(hn::ShiftRight<2>(bit), three));
  next.cell[2] = hn::ConvertTo(floats, hn::And(z, three));
  find_ways(lanes, next);
  return next;
}

/// Takes the first of some of the cells left: neither this cell nor any before it remains in
/// `left`.
/// @param looks  which cells, in two words
HWY_INLINE NextCell take_first_of(Lanes& lanes, const VecI* looks) {
  const NextCell next = first_of(lanes, looks);
  // Without it and all before.
  const VecI rest = hn::Not(hn::Or(next.bit, hn::Sub(next.bit, hn::Set(ints, 1))));
  lanes.left[0] = hn::IfThenZeroElse(next.in_second, hn::And(lanes.left[0], rest));
  lanes.left[1] = hn::IfThenElse(next.in_second, hn::And(lanes.left[1], rest), lanes.left[1]);
  return next;
}

/// Those of the cells left that must be searched: active cells, and cells on the other side than
/// the ray's. The latter detect a change that rounding hides at an edge between cells.
HWY_INLINE void find_looks(const Lanes& lanes, const VecI* active, const VecI* inside_out, MaskF inside, MaskF has_side,
                           VecI* looks) {
  const VecI side = hn::VecFromMask(ints, hn::RebindMask(ints, inside));
  const VecI known = hn::VecFromMask(ints, hn::RebindMask(ints, has_side));
  for (int w = 0; w < 2; ++w)
    looks[w] = hn::And(lanes.left[w], hn::Or(active[w], hn::And(hn::Xor(inside_out[w], side), known)));
}

/// Takes the first of the cells left that must be searched.
HWY_INLINE NextCell take_next_cell(Lanes& lanes) {
  VecI looks[2];
  find_looks(lanes, lanes.active, lanes.inside_out, lanes.inside, lanes.has_side, looks);
  return take_first_of(lanes, looks);
}

/// Blocks in which the lattice ends.
HWY_INLINE MaskF is_cut_off(const LatticeEnds& ends, const VecF* block_corner) {
  MaskF cut_off = no_lane(floats);
  for (int a = 0; a < 3; ++a) {
    const VecF first = hn::Set(floats, static_cast<float>(ends.first[a]));
    const VecF last = hn::Set(floats, static_cast<float>(ends.last[a] - 4));
    cut_off = hn::Or(cut_off, hn::Or(hn::Lt(block_corner[a], first), hn::Gt(block_corner[a], last)));
  }
  return cut_off;
}

/// Cells that the lattice has; those found to be near a ray's way may lie beyond its ends.
HWY_INLINE MaskF is_in_lattice(const LatticeEnds& ends, const NextCell& next, const VecF* block_corner) {
  MaskF exists = hn::FirstN(floats, float_lanes);
  for (int a = 0; a < 3; ++a) {
    const VecF at = hn::Add(block_corner[a], next.cell[a]);
    exists = hn::And(exists, hn::Ge(at, hn::Set(floats, static_cast<float>(ends.first[a]))));
    exists = hn::And(exists, hn::Lt(at, hn::Set(floats, static_cast<float>(ends.last[a]))));
  }
  return exists;
}

/// The points, in the cell's coordinates, at which the rays enter and leave it; exact on the planes
/// that they pass.
HWY_INLINE void ends_in_cell(const Lanes& lanes, const NextCell& next, VecF* in, VecF* out) {
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
  for (int a = 0; a < 3; ++a) {
    const auto place = [&](VecF way) HWY_ATTR {
      return hn::Min(hn::Max(hn::Sub(hn::MulAdd(way, lanes.slope[a], lanes.entry[a]), next.cell[a]), zero), one);
    };
    in[a] = hn::IfThenZeroElse(hn::Eq(next.near[a], next.way_in), place(next.way_in));
    out[a] = hn::IfThenElse(hn::Eq(next.far[a], next.way_out), one, place(next.way_out));
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
