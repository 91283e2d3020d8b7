// Which rays pass none of the parts of a block that must be searched.
#if defined(RHORAY_WIDE_SHELL_SLABS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_SHELL_SLABS_INL_H
#undef RHORAY_WIDE_SHELL_SLABS_INL_H
#else
#define RHORAY_WIDE_SHELL_SLABS_INL_H
#endif

#include <cmath>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/grid/all_hits/parts.h"
#include "render/grid/isosurface/cell_walk-inl.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// What a block contains of a surface.
struct SeenInBlock {
  /// As in BlockSamples; none active: the surface is not in the block.
  std::uint64_t active, inside;
  double isovalue;  ///< minus the number subtracted from the samples
};

/// Coordinates of the samples of a block.
struct SamplePlaces {
  alignas(64) float at[3][128];

  constexpr SamplePlaces() : at{} {
    for (std::size_t i = 0; i < BlockSamples::size; ++i) {
      at[0][i] = static_cast<float>(i % 5);
      at[1][i] = static_cast<float>(i / 5 % 5);
      at[2][i] = static_cast<float>(i / 25);
    }
  }
};
inline constexpr SamplePlaces sample_places;

/// Heights at the lowest corners of a block's cells.
class CellHeights {
 public:
  explicit HWY_INLINE CellHeights(const float* normal) {
    const VecI three = hn::Set(ints, 3);
    for (std::size_t i = 0; i < 64; i += float_lanes) {
      const VecI bit = hn::Iota(ints, static_cast<std::int32_t>(i));
      const VecI cell[3] = {hn::And(bit, three), hn::And(hn::ShiftRight<2>(bit), three), hn::ShiftRight<4>(bit)};
      VecF& h = height_[i / float_lanes];
      h = hn::Zero(floats);
      for (int a = 0; a < 3; ++a) h = hn::MulAdd(hn::ConvertTo(floats, cell[a]), hn::Set(floats, normal[a]), h);
    }
  }
  HWY_INLINE float least(std::uint64_t cells) const {
    const VecF none = hn::Set(floats, std::numeric_limits<float>::infinity());
    VecF least = none;
    for (std::size_t i = 0; i < 64; i += float_lanes)
      least = hn::Min(least, hn::IfThenElse(mask_of(floats, cells >> i), height_[i / float_lanes], none));
    return hn::GetLane(hn::MinOfLanes(floats, least));
  }
  HWY_INLINE float most(std::uint64_t cells) const {
    const VecF none = hn::Set(floats, -std::numeric_limits<float>::infinity());
    VecF most = none;
    for (std::size_t i = 0; i < 64; i += float_lanes)
      most = hn::Max(most, hn::IfThenElse(mask_of(floats, cells >> i), height_[i / float_lanes], none));
    return hn::GetLane(hn::MaxOfLanes(floats, most));
  }

 private:
  VecF height_[64 / float_lanes];
};

HWY_INLINE float smaller(float a, float b) {
  return b < a ? b : a;
}
HWY_INLINE float larger(float a, float b) {
  return b > a ? b : a;
}

/// Planes across the block's mean gradient. A sample lies above the plane through the origin of
/// values by some number. So does the field between samples, since their weights add up to 1: it is
/// known to within the range of these numbers. In addition, nothing changes below the lowest and
/// above the highest of the cells that must be searched.
/// @param f        its samples, as in BlockSamples, minus any number
/// @param present  cells that the lattice has
template <int surfaces>
HWY_INLINE BlockSlabs slabs_of(const float* f, std::uint64_t present, const SeenInBlock (&of)[surfaces]) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr int end[3] = {4, 20, 100};
  BlockSlabs slabs{};
  for (int a = 0; a < 3; ++a) {
    const int u = end[a == 0 ? 1 : 0], v = end[a == 2 ? 1 : 2];
    for (const int at : {0, u, v, u + v}) slabs.normal[a] += (f[at + end[a]] - f[at]) * 0.0625f;
    slabs.size += std::abs(slabs.normal[a]);
  }
  VecF low = hn::Set(floats, infinity), high = hn::Neg(low);
  for (std::size_t i = 0; i < 128; i += float_lanes) {
    VecF beyond = hn::Load(floats, f + i);
    for (int a = 0; a < 3; ++a)
      beyond = hn::NegMulAdd(hn::Load(floats, sample_places.at[a] + i), hn::Set(floats, slabs.normal[a]), beyond);
    // The last three are no samples.
    const MaskF counts = hn::FirstN(floats, i < BlockSamples::size ? BlockSamples::size - i : 0);
    low = hn::Min(low, hn::IfThenElse(counts, beyond, low)), high = hn::Max(high, hn::IfThenElse(counts, beyond, high));
  }
  const float least = hn::GetLane(hn::MinOfLanes(floats, low)), most = hn::GetLane(hn::MaxOfLanes(floats, high));
  const CellHeights heights(slabs.normal);
  float rise = 0, fall = 0;  // in a cell, beyond its lowest corner
  for (const float n : slabs.normal) (n < 0 ? fall : rise) += n;
  slabs.low = infinity, slabs.high = -infinity, slabs.error = 0;
  for (int s = 0; s < surfaces; ++s) {
    float &below = slabs.below[s], &above = slabs.above[s];
    below = -infinity, above = infinity;
    if (of[s].active == 0) continue;
    const auto isovalue = static_cast<float>(of[s].isovalue);
    // Each number that is used here, in heights along rays or in fields along them, is rounded
    // fewer than 64 times. None is larger than this, and neither are samples.
    const float largest = 4 * slabs.size + std::abs(least) + std::abs(most) + std::abs(isovalue);
    float error = infinity;
    if (largest > 0x1p-80f && largest < 0x1p80f) {
      error = 0x1p-17f * largest;
      const float first = heights.least(of[s].active), last = heights.most(of[s].active);
      const std::uint64_t rest = present & ~of[s].active;
      below = isovalue - most - error, above = isovalue - least + error;
      if (heights.least(rest & of[s].inside) >= first) below = larger(below, first + fall - error);
      if (heights.most(rest & ~of[s].inside) <= last) above = smaller(above, last + rise + error);
    }
    slabs.low = smaller(slabs.low, below), slabs.high = larger(slabs.high, above);
    slabs.error = larger(slabs.error, error);
  }
  return slabs;
}

/// Prepares positions on the rays.
HWY_INLINE void prepare_places(const MirroredLattice& lattice, GridAllHitsScratch& scratch) {
  const RayGroup& group = scratch.ways.group;
  int longest = 0;
  for (const int count : lattice.node_count) longest = count > longest ? count : longest;
  for (std::size_t r = 0; r < group.count; r += double_lanes) {
    VecD size = hn::Zero(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD start = mirrored_origin(lattice, group, a, r);
      size = hn::Max(size, hn::Abs(start));
      hn::Store(hn::DemoteTo(half_floats, start), half_floats, scratch.start[a] + r);
    }
    // Neither a start nor a way to the other end of the lattice is larger than this. There are
    // fewer than 16 roundings, including those of heights.
    const VecD error = hn::Mul(hn::Add(size, hn::Set(doubles, 16.0 * longest)), hn::Set(doubles, 0x1p-20));
    hn::Store(hn::DemoteTo(half_floats, error), half_floats, scratch.place_error + r);
  }
}

/// Separates those rays that may pass a block but meet no change of side in it.
/// @param ahead   its block and what it has of each surface; receives its rays
/// @param enters  of all rays of the group: distance along their ways at which they enter the block
///                at the earliest
/// @param leaves  of all rays of the group: distance at which they leave it at the latest
template <int surfaces>
HWY_INLINE void let_go_by(const MirroredLattice& lattice, const GridAllHitsScratch& scratch, const BlockSlabs& slabs,
                          std::uint64_t rays, const float* enters, const float* leaves, AllHitsBlock& ahead) {
  VecF normal[3];
  double offset = 0;  // of the height where the lattice begins
  ahead.ground = 0, ahead.low = slabs.low, ahead.high = slabs.high, ahead.error = slabs.error;
  for (int a = 0; a < 3; ++a) {
    const bool is_mirrored = lattice.is_mirrored(a);
    const float n = ahead.normal[a] = is_mirrored ? -slabs.normal[a] : slabs.normal[a];
    if (is_mirrored) ahead.ground += 4 * slabs.normal[a];
    // Where the block's own coordinates are 0.
    const double origin = 4.0 * (ahead.block[a] + (is_mirrored ? 1 : 0));
    offset -= static_cast<double>(n) * origin;
    normal[a] = hn::Set(floats, n);
  }
  const VecF from = hn::Set(floats, static_cast<float>(offset)), size = hn::Set(floats, slabs.size);
  std::uint64_t below[surfaces] = {}, above[surfaces] = {};
  for (std::size_t r = 0; r < scratch.ways.group.count; r += float_lanes) {
    if ((rays >> r & first_rays(float_lanes)) == 0) continue;
    VecF height = from, climb = hn::Zero(floats);
    for (int a = 0; a < 3; ++a) {
      height = hn::MulAdd(normal[a], hn::Load(floats, scratch.start[a] + r), height);
      climb = hn::MulAdd(normal[a], hn::Load(floats, scratch.ways.slope[a] + r), climb);
    }
    const VecF at_entry = hn::MulAdd(climb, hn::Load(floats, enters + r), height);
    const VecF at_exit = hn::MulAdd(climb, hn::Load(floats, leaves + r), height);
    const VecF error = hn::Mul(size, hn::Load(floats, scratch.place_error + r));
    const VecF most = hn::Add(hn::Max(at_entry, at_exit), error), least = hn::Sub(hn::Min(at_entry, at_exit), error);
    for (int s = 0; s < surfaces; ++s) {
      below[s] |= bits_of(floats, hn::Lt(most, hn::Set(floats, slabs.below[s]))) << r;
      above[s] |= bits_of(floats, hn::Gt(least, hn::Set(floats, slabs.above[s]))) << r;
    }
  }
  ahead.by = rays;
  for (int s = 0; s < surfaces; ++s)
    if (ahead.is_seen[s]) ahead.by &= below[s] | above[s];
  ahead.rays = rays & ~ahead.by;
  for (int s = 0; s < surfaces; ++s)
    ahead.by_side[s][0] = ahead.by & below[s], ahead.by_side[s][1] = ahead.by & above[s];
}

/// The parts of the ways between the heights of their blocks' slabs.
struct BetweenSlabs {
  VecF from, to;  ///< the part of the way on which changes of side are sought
  /// The part before it is left out: for all surfaces in the block the ray is there...
  MaskF is_cut_in_front;
  MaskF inside_in_front;  ///< inside, or outside
  MaskF is_cut_behind;    ///< the part behind it is left out: the ray is there on the other side

  HWY_INLINE BetweenSlabs(const Lanes& lanes, const VecF* normal, VecF ground, VecF low, VecF high) {
    VecF height = ground, climb = hn::Zero(floats);
    for (int a = 0; a < 3; ++a) {
      height = hn::MulAdd(normal[a], lanes.entry[a], height);
      climb = hn::MulAdd(normal[a], lanes.slope[a], climb);
    }
    const VecF zero = hn::Zero(floats), level = hn::Set(floats, 0x1p-100f);
    climb = hn::IfThenElse(hn::Lt(hn::Abs(climb), level), level, climb);
    const VecF at_low = hn::Div(hn::Sub(low, height), climb), at_high = hn::Div(hn::Sub(high, height), climb);
    const auto on_way = [&](VecF way) HWY_ATTR { return hn::Min(hn::Max(way, zero), lanes.end); };
    from = on_way(hn::Min(at_low, at_high)), to = on_way(hn::Max(at_low, at_high));
    is_cut_in_front = hn::Gt(from, zero), is_cut_behind = hn::Lt(to, lanes.end);
    inside_in_front = hn::Lt(climb, zero);
  }
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
