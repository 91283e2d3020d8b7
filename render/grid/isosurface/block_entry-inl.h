// Which rays of a group pass a block, and where they enter it.
#if defined(RHORAY_WIDE_BLOCK_ENTRY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_BLOCK_ENTRY_INL_H
#undef RHORAY_WIDE_BLOCK_ENTRY_INL_H
#else
#define RHORAY_WIDE_BLOCK_ENTRY_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/parts.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Inverse slope of an axis along which the ray passes no plane, and the time of planes that are
/// never passed.
inline constexpr float never_passed = 0x1p100f;

/// Computes the slopes of the group's rays and the filter of their blocks. A ray's way is measured
/// along the axis on which this ray moves fastest, whatever the group's axis is.
HWY_INLINE void prepare_ways(const MirroredLattice& lattice, IsosurfaceScratch& scratch) {
  const RayGroup& group = scratch.group;
  BlockFilter& filter = scratch.filter;
  const auto store = [](VecD x, float* to) HWY_ATTR { hn::Store(hn::DemoteTo(half_floats, x), half_floats, to); };
  int longest = lattice.node_count[0];
  for (int a = 1; a < 3; ++a) longest = lattice.node_count[a] > longest ? lattice.node_count[a] : longest;
  const VecD extent = hn::Set(doubles, 16.0 * longest);
  for (std::size_t r = 0; r < group.count; r += double_lanes) {
    VecD inverse[3], fastest = hn::Zero(doubles), t_per_way = hn::Set(doubles, 0x1p1000);
    for (int a = 0; a < 3; ++a) {
      inverse[a] = hn::Abs(hn::Load(doubles, group.inverse[a] + r));
      fastest = hn::Max(fastest, speed(group, a, r));
      t_per_way = hn::Min(t_per_way, inverse[a]);
    }
    hn::Store(fastest, doubles, scratch.way_per_t + r);
    hn::Store(t_per_way, doubles, scratch.t_per_way + r);
    for (int a = 0; a < 3; ++a) {
      store(hn::Mul(speed(group, a, r), t_per_way), scratch.slope[a] + r);
      const VecD moving = hn::Min(hn::Mul(fastest, inverse[a]), hn::Set(doubles, double{never_passed} / 2));
      const VecD inverse_slope = hn::IfThenElse(has_finite_inverse(hn::Load(doubles, group.direction[a] + r)), moving,
                                                hn::Set(doubles, double{never_passed}));
      store(inverse_slope, scratch.inverse_slope[a] + r);
      // Times, in single precision, of planes up to `extent` away: at most 4 roundings of the
      // terms.
      const VecD o = hn::Load(doubles, group.plane_origin[a] + r);
      const VecD from = lattice.is_mirrored(a) ? hn::Sub(hn::Set(doubles, lattice.plane(a, 0)), o) : o;
      const VecD margin = hn::Mul(hn::Add(hn::Abs(from), extent), hn::Set(doubles, 0x1p-21));
      store(hn::Mul(hn::Neg(hn::Add(from, margin)), inverse_slope), filter.near[a] + r);
      store(hn::Mul(hn::Sub(margin, from), inverse_slope), filter.far[a] + r);
    }
    const VecD first = hn::Mul(hn::Load(doubles, group.t_in + r), fastest);
    const VecD last = hn::Mul(hn::Load(doubles, group.t_out + r), fastest);
    store(hn::NegMulAdd(hn::Abs(first), hn::Set(doubles, 0x1p-21), first), filter.first + r);
    store(hn::MulAdd(hn::Abs(last), hn::Set(doubles, 0x1p-21), last), filter.last + r);
  }
}

/// Those of some rays of the group that may pass the block: all that do, and few more.
/// @param note  (first ray, enters, leaves): how far along their ways they do so, at the earliest
///              and at the latest
template <class Note>
HWY_INLINE std::uint64_t rays_that_may_pass(const IsosurfaceScratch& scratch, std::uint64_t rays, const int* block,
                                            const Note& note) {
  const BlockFilter& filter = scratch.filter;
  VecF low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = hn::Set(floats, static_cast<float>(4 * block[a]));
    high[a] = hn::Set(floats, static_cast<float>(4 * block[a] + 4));
  }
  std::uint64_t found = 0;
  for (std::size_t r = 0; r < scratch.group.count; r += float_lanes) {
    if ((rays >> r & first_rays(float_lanes)) == 0) continue;
    VecF enters = hn::Load(floats, filter.first + r), leaves = hn::Load(floats, filter.last + r);
    for (int a = 0; a < 3; ++a) {
      const VecF inverse = hn::Load(floats, scratch.inverse_slope[a] + r);
      enters = hn::Max(enters, hn::MulAdd(low[a], inverse, hn::Load(floats, filter.near[a] + r)));
      leaves = hn::Min(leaves, hn::MulAdd(high[a], inverse, hn::Load(floats, filter.far[a] + r)));
    }
    note(r, enters, leaves);
    found |= bits_of(floats, hn::Le(enters, leaves)) << r;
  }
  return found & rays;
}
HWY_INLINE std::uint64_t rays_that_may_pass(const IsosurfaceScratch& scratch, std::uint64_t rays, const int* block) {
  return rays_that_may_pass(scratch, rays, block, [](std::size_t, VecF, VecF) {});
}

/// Rays that enter blocks, each its own, in the block's mirrored coordinates, 0 to 4.
struct BlockEntry {
  MaskF passes;
  VecF entry[3];  ///< exact on the planes of entry; at most the upper plane of the last cells
  VecF last[3];   ///< the last cell of the block that the lattice has
  VecF end;       ///< way until the ray leaves the block, or ends; <= 0 where it does not pass
};

/// The first lattice plane of an axis in mirrored coordinates, and the one after its last cell.
struct LatticeEnds {
  double first[3], last[3];

  HWY_INLINE LatticeEnds(const MirroredLattice& lattice, const int* leaf_count) {
    for (int a = 0; a < 3; ++a) {
      first[a] = lattice.is_mirrored(a) ? 16.0 * lattice.node_count[a] - leaf_count[a] : 0;
      last[a] = lattice.is_mirrored(a) ? 16.0 * lattice.node_count[a] : leaf_count[a];
    }
  }
};

/// Which of the rays from r on pass the blocks at `corner`, by the reference's formula in double
/// precision. Stores the time at which they enter.
/// @param corner  lowest corner, in the mirrored lattice, of the block that each ray is at
HWY_INLINE BlockEntry entry_into_blocks(const MirroredLattice& lattice, const LatticeEnds& ends,
                                        IsosurfaceScratch& scratch, std::size_t first_ray, MaskF rays,
                                        const VecF* corner) {
  const RayGroup& group = scratch.group;
  const std::uint64_t asked = bits_of(floats, rays);
  VecD entry[3][parts_of_floats], last[3][parts_of_floats], end[parts_of_floats];
  std::uint64_t passes = 0;
  for (std::size_t part = 0; part < parts_of_floats; ++part) {
    const std::size_t r = first_ray + part * double_lanes;
    VecD t_in = hn::Load(doubles, group.t_in + r), t_out = hn::Load(doubles, group.t_out + r);
    VecD near[3], low[3], first[3];
    for (int a = 0; a < 3; ++a) {
      const VecD o = hn::Load(doubles, group.plane_origin[a] + r), inverse = hn::Load(doubles, group.inverse[a] + r);
      const auto position = [&](VecD k) HWY_ATTR {
        return lattice.is_mirrored(a) ? hn::Sub(hn::Set(doubles, lattice.plane(a, 0)), k) : k;
      };
      const VecD block = as_doubles(corner[a], part);
      const VecD near_plane = hn::Max(block, hn::Set(doubles, ends.first[a]));
      const VecD far_plane = hn::Min(hn::Add(block, hn::Set(doubles, 4.0)), hn::Set(doubles, ends.last[a]));
      near[a] = hn::Mul(hn::Sub(position(near_plane), o), inverse);
      t_in = hn::Max(t_in, near[a]);
      t_out = hn::Min(t_out, hn::Mul(hn::Sub(position(far_plane), o), inverse));
      low[a] = position(block);
      first[a] = hn::Sub(near_plane, block);
      last[a][part] = hn::Sub(hn::Sub(far_plane, block), hn::Set(doubles, 1.0));
    }
    const MaskD enters = hn::And(hn::Lt(t_in, t_out), mask_of(doubles, asked >> (part * double_lanes)));
    passes |= bits_of(doubles, enters) << (part * double_lanes);
    hn::BlendedStore(t_in, enters, doubles, scratch.t_block + r);
    for (int a = 0; a < 3; ++a) {
      const VecD at =
          hn::MulAdd(t_in, hn::Load(doubles, group.direction[a] + r), hn::Load(doubles, group.origin[a] + r));
      const VecD within = lattice.is_mirrored(a) ? hn::Sub(low[a], at) : hn::Sub(at, low[a]);
      entry[a][part] = hn::IfThenElse(hn::Eq(near[a], t_in), first[a], within);
    }
    end[part] = hn::Mul(hn::Sub(t_out, t_in), hn::Load(doubles, scratch.way_per_t + r));
  }
  BlockEntry found{mask_of(floats, passes), {}, {}, as_floats(end)};
  for (int a = 0; a < 3; ++a) {
    found.last[a] = as_floats(last[a]);
    const VecF upper = hn::Add(found.last[a], hn::Set(floats, 1.0f));
    found.entry[a] = hn::Min(hn::Max(as_floats(entry[a]), hn::Zero(floats)), upper);
  }
  return found;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
