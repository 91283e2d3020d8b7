#include <bit>

#include "render/kernels/wide/isosurface_parts.h"
#include "render/march/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/kernels/wide/isosurface.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/kernels/wide/fetch-inl.h"
#include "render/kernels/wide/group-inl.h"
#include "render/kernels/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// An inverse slope of an axis along which the ray passes no plane, and the time of planes that are never passed.
inline constexpr float never_passed = 0x1p100f;

using Fetch = void (*)(const SampleSource&, const int*, double, BlockSamples&);
Fetch fetch_of(formats::ElementType type) {
  switch (type) {
    case formats::ElementType::U8:
      return fetch_block<std::uint8_t>;
    case formats::ElementType::I8:
      return fetch_block<std::int8_t>;
    case formats::ElementType::U16:
      return fetch_block<std::uint16_t>;
    case formats::ElementType::I16:
      return fetch_block<std::int16_t>;
    case formats::ElementType::U32:
      return fetch_block<std::uint32_t>;
    case formats::ElementType::I32:
      return fetch_block<std::int32_t>;
    case formats::ElementType::F32:
      return fetch_block<float>;
    default:
      return fetch_block<double>;
  }
}

struct Vec3F {
  VecF x, y, z;
};

/// (1 - w) a + w b: exact at w = 0 and w = 1, and of the sign of a and b where they agree.
HWY_INLINE VecF between(VecF a, VecF b, VecF w, VecF rest) {
  return hn::MulAdd(w, b, hn::Mul(rest, a));
}

/// The eight corners of a cell.
struct Corners {
  VecF f[8];
};

/// A cubic by its Bernstein coefficients.
struct CubicLanes {
  VecF b[4];

  struct Jet {
    VecF value, slope;
  };
  HWY_INLINE Jet at(VecF s) const {
    const VecF r = hn::Sub(hn::Set(floats, 1.0f), s);
    const VecF c0 = between(b[0], b[1], s, r), c1 = between(b[1], b[2], s, r), c2 = between(b[2], b[3], s, r);
    const VecF d0 = between(c0, c1, s, r), d1 = between(c1, c2, s, r);
    return {between(d0, d1, s, r), hn::Mul(hn::Set(floats, 3.0f), hn::Sub(d1, d0))};
  }
};

/// The field along a straight line between two points of a cell (`along` in cells/trilinear.h).
HWY_INLINE CubicLanes along(const Corners& corners, const VecF* in, const VecF* out) {
  const VecF one = hn::Set(floats, 1.0f);
  VecF w[3][2], rest[3][2];
  for (int a = 0; a < 3; ++a) {
    w[a][0] = in[a], w[a][1] = out[a];
    rest[a][0] = hn::Sub(one, in[a]), rest[a][1] = hn::Sub(one, out[a]);
  }
  VecF g[8];  // a + 2 b + 4 c
  for (int a = 0; a < 2; ++a) {
    VecF x[4];
    for (int e = 0; e < 4; ++e) x[e] = between(corners.f[2 * e], corners.f[2 * e + 1], w[0][a], rest[0][a]);
    for (int b = 0; b < 2; ++b) {
      const VecF near = between(x[0], x[1], w[1][b], rest[1][b]), far = between(x[2], x[3], w[1][b], rest[1][b]);
      for (int c = 0; c < 2; ++c) g[a + 2 * b + 4 * c] = between(near, far, w[2][c], rest[2][c]);
    }
  }
  const VecF third = hn::Set(floats, 1.0f / 3.0f);
  return {{g[0], hn::Mul(hn::Add(hn::Add(g[1], g[2]), g[4]), third),
           hn::Mul(hn::Add(hn::Add(g[3], g[5]), g[6]), third), g[7]}};
}

/// Derivatives along the axes at a point of the cell.
HWY_INLINE void gradient_at(const Corners& corners, const VecF* p, VecF* gradient) {
  const VecF one = hn::Set(floats, 1.0f);
  const VecF* f = corners.f;
  const VecF rest[3] = {hn::Sub(one, p[0]), hn::Sub(one, p[1]), hn::Sub(one, p[2])};
  const auto bilinear = [&](VecF a, VecF b, VecF c, VecF d, int u, int v) HWY_ATTR {
    return between(between(a, b, p[u], rest[u]), between(c, d, p[u], rest[u]), p[v], rest[v]);
  };
  gradient[0] = bilinear(hn::Sub(f[1], f[0]), hn::Sub(f[3], f[2]), hn::Sub(f[5], f[4]), hn::Sub(f[7], f[6]), 1, 2);
  gradient[1] = bilinear(hn::Sub(f[2], f[0]), hn::Sub(f[3], f[1]), hn::Sub(f[6], f[4]), hn::Sub(f[7], f[5]), 0, 2);
  gradient[2] = bilinear(hn::Sub(f[4], f[0]), hn::Sub(f[5], f[1]), hn::Sub(f[6], f[2]), hn::Sub(f[7], f[3]), 0, 1);
}

HWY_INLINE MaskF is_inside(VecF difference) {
  return hn::Ge(difference, hn::Zero(floats));
}

/// Where a cubic first changes side, in lanes in which it does.
struct Roots {
  MaskF found;
  VecF s;
  VecI iterations, count;
};

/// One monotone piece on which the side changes, or none.
struct Piece {
  VecF lo, hi, f_lo, f_hi;
  MaskF lo_critical, hi_critical;
};

/// Newton's method kept inside a bracket, as bracketed_root of cells/cubic.h does it, until all lanes are done.
HWY_INLINE void refine(const CubicLanes& cubic, const Piece& piece, MaskF wanted, Roots& roots) {
  constexpr float resolution = 1.19e-7f;
  const VecF half = hn::Set(floats, 0.5f), least = hn::Set(floats, resolution);
  const VecF zero = hn::Zero(floats);
  VecF largest = hn::Abs(cubic.b[0]);
  for (int i = 1; i < 4; ++i) largest = hn::Max(largest, hn::Abs(cubic.b[i]));
  const VecF noise = hn::Mul(largest, hn::Set(floats, 0x1p-23f));
  VecF lo = piece.lo, hi = piece.hi;
  const MaskF inside_lo = is_inside(piece.f_lo);

  // Where the parabola with its vertex at the one critical end is zero, or else the straight line.
  const VecF width = hn::Sub(hi, lo), rise = hn::Sub(piece.f_lo, piece.f_hi);
  VecF guess = hn::MulAdd(width, hn::Div(piece.f_lo, rise), lo);
  const MaskF by_parabola = hn::Xor(piece.lo_critical, piece.hi_critical);
  if (!hn::AllFalse(floats, hn::And(by_parabola, wanted))) {
    const VecF from_lo = hn::MulAdd(width, hn::Sqrt(hn::Max(zero, hn::Div(piece.f_lo, rise))), lo);
    const VecF from_hi = hn::NegMulAdd(width, hn::Sqrt(hn::Max(zero, hn::Div(piece.f_hi, hn::Neg(rise)))), hi);
    guess = hn::IfThenElse(by_parabola, hn::IfThenElse(piece.lo_critical, from_lo, from_hi), guess);
  }
  const MaskF in_piece = hn::And(hn::Ge(guess, lo), hn::Le(guess, hi));
  VecF s = hn::IfThenElse(in_piece, guess, hn::Mul(half, hn::Add(lo, hi)));

  VecF step_before = width;
  MaskF active = hn::And(wanted, hn::Gt(width, least));
  for (int step = 0; step < 100 && !hn::AllFalse(floats, active); ++step) {
    const CubicLanes::Jet f = cubic.at(s);
    roots.iterations = hn::Add(roots.iterations, hn::IfThenElseZero(hn::RebindMask(ints, active), hn::Set(ints, 1)));
    const MaskF at_lo_side = hn::Not(hn::Xor(is_inside(f.value), inside_lo));
    lo = hn::IfThenElse(hn::And(active, at_lo_side), s, lo);
    hi = hn::IfThenElse(hn::AndNot(at_lo_side, active), s, hi);
    const VecF newton = hn::Sub(s, hn::Div(f.value, f.slope));
    const VecF size = hn::Abs(hn::Sub(newton, s));
    const MaskF is_newton = hn::And(hn::And(hn::Ge(newton, lo), hn::Le(newton, hi)),
                                    hn::Le(size, hn::Mul(half, step_before)));
    const VecF next = hn::IfThenElse(is_newton, newton, hn::Mul(half, hn::Add(lo, hi)));
    const MaskF at_zero = hn::Le(hn::Abs(f.value), noise);
    active = hn::AndNot(at_zero, active);
    step_before = hn::Abs(hn::Sub(next, s));
    s = hn::IfThenElse(active, next, s);
    active = hn::And(active, hn::And(hn::Gt(step_before, least), hn::Gt(hn::Sub(hi, lo), least)));
  }
  roots.s = hn::IfThenElse(wanted, s, roots.s);
}

/// The first change of side of cubics that start on the side `inside` (changes_of_side of cells/cubic.h).
HWY_INLINE Roots first_changes(const CubicLanes& cubic, MaskF inside, MaskF asked) {
  const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
  MaskF changed[4];
  for (int i = 0; i < 4; ++i) changed[i] = hn::And(asked, hn::Xor(is_inside(cubic.b[i]), inside));
  Roots roots{no_lane(floats), zero, hn::Zero(ints), hn::Zero(ints)};
  const MaskF any = hn::Or(hn::Or(changed[0], changed[1]), hn::Or(changed[2], changed[3]));
  if (hn::AllFalse(floats, any)) return roots;

  const MaskF false_mask = no_lane(floats);
  Piece piece{zero, one, cubic.b[0], cubic.b[3], false_mask, false_mask};
  // With one change of sign among the coefficients there is one root.
  const MaskF one_root = hn::AndNot(hn::Or(changed[0], hn::AndNot(changed[2], changed[1])), changed[3]);
  const MaskF split = hn::AndNot(one_root, any);
  roots.found = one_root;
  roots.count = hn::IfThenElseZero(hn::RebindMask(ints, one_root), hn::Set(ints, 1));
  MaskF wanted = one_root;
  if (!hn::AllFalse(floats, split)) {
    // The critical points, without cancellation (critical_points of cells/cubic.h).
    VecF d0 = hn::Sub(cubic.b[1], cubic.b[0]), d1 = hn::Sub(cubic.b[2], cubic.b[1]),
         d2 = hn::Sub(cubic.b[3], cubic.b[2]);
    const VecF unit = hn::Max(hn::Abs(d0), hn::Max(hn::Abs(d1), hn::Abs(d2)));
    d0 = hn::Div(d0, unit), d1 = hn::Div(d1, unit), d2 = hn::Div(d2, unit);
    const VecF a = hn::Add(hn::Sub(d0, hn::Add(d1, d1)), d2), half_b = hn::Sub(d1, d0);
    const VecF discriminant = hn::NegMulAdd(d0, d2, hn::Mul(d1, d1));
    const MaskF has_roots = hn::Ge(discriminant, zero);
    const VecF q = hn::Neg(hn::Add(half_b, hn::CopySign(hn::Sqrt(hn::Max(discriminant, zero)), half_b)));
    VecF s0 = hn::Div(q, a), s1 = hn::Div(d0, q);
    const auto in_unit = [&](VecF s) HWY_ATTR {
      return hn::And(has_roots, hn::And(hn::Gt(s, zero), hn::Lt(s, one)));
    };
    s0 = hn::IfThenElse(in_unit(s0), s0, one), s1 = hn::IfThenElse(in_unit(s1), s1, one);
    const VecF ends[3] = {hn::Min(s0, s1), hn::Max(s0, s1), one};

    // From piece to piece; those that are none have both ends at 1, where the side cannot change again.
    MaskF side = hn::Xor(inside, changed[0]);
    roots.found = hn::Or(roots.found, hn::And(split, changed[0]));
    roots.count = hn::Add(roots.count, hn::IfThenElseZero(hn::RebindMask(ints, hn::And(split, changed[0])), hn::Set(ints, 1)));
    VecF lo = zero, f_lo = cubic.b[0];
    MaskF lo_critical = false_mask;
    for (int i = 0; i < 3; ++i) {
      const MaskF at_end = hn::Eq(ends[i], one);
      const VecF f_hi = hn::IfThenElse(at_end, cubic.b[3], cubic.at(ends[i]).value);
      const MaskF hi_critical = hn::Not(at_end);
      const MaskF changes = hn::And(split, hn::Xor(is_inside(f_hi), side));
      const MaskF first = hn::AndNot(roots.found, changes);
      piece.lo = hn::IfThenElse(first, lo, piece.lo), piece.hi = hn::IfThenElse(first, ends[i], piece.hi);
      piece.f_lo = hn::IfThenElse(first, f_lo, piece.f_lo), piece.f_hi = hn::IfThenElse(first, f_hi, piece.f_hi);
      piece.lo_critical = hn::Or(piece.lo_critical, hn::And(first, lo_critical));
      piece.hi_critical = hn::Or(piece.hi_critical, hn::And(first, hi_critical));
      wanted = hn::Or(wanted, first);
      roots.found = hn::Or(roots.found, changes);
      roots.count = hn::Add(roots.count, hn::IfThenElseZero(hn::RebindMask(ints, changes), hn::Set(ints, 1)));
      side = hn::Xor(side, changes);
      lo = ends[i], f_lo = f_hi, lo_critical = hi_critical;
    }
  }
  refine(cubic, piece, wanted, roots);
  return roots;
}

/// Sides at entry and exit, and one secant step.
HWY_INLINE Roots secant_step(VecF at_in, VecF at_out, MaskF inside, MaskF asked) {
  const MaskF changed_in = hn::And(asked, hn::Xor(is_inside(at_in), inside));
  const MaskF changed_out = hn::And(asked, hn::Xor(is_inside(at_out), inside));
  const MaskF found = hn::Or(changed_in, changed_out);
  const VecF s = hn::Div(at_in, hn::Sub(at_in, at_out));
  const VecI once = hn::IfThenElseZero(hn::RebindMask(ints, found), hn::Set(ints, 1));
  return {found, hn::IfThenElseZero(hn::AndNot(changed_in, changed_out), s), once, once};
}

/// The kernel at work on one group.
template <Search search>
class GroupWalk {
 public:
  HWY_INLINE GroupWalk(const Surface& surface, const MirroredLattice& lattice, const HitArrays& hits,
                       IsosurfaceScratch& scratch, KernelCounters& counters)
      : surface_(surface),
        lattice_(lattice),
        hits_(hits),
        scratch_(scratch),
        group_(scratch.group),
        counters_(counters),
        fetch_(fetch_of(surface.type)),
        alive_(scratch.group.inside) {
    for (int a = 0; a < 3; ++a) {
      const int stride = a == 0 ? 1 : a == 1 ? 5 : 25;
      stride_[a] = lattice.is_mirrored(a) ? -stride : stride;
      if (lattice.is_mirrored(a)) lowest_sample_ += 4 * stride;
    }
  }

  HWY_INLINE void run(Frustum& frustum) {
    prepare_slopes();
    for (std::size_t r = 0; r < group_.count; r += float_lanes)
      hn::Store(hn::Zero(ints), ints, scratch_.state + r);
    int alive_in_frustum = std::popcount(alive_);
    walk_blocks(frustum, lattice_, surface_.nodes, surface_.summits, [&](const int* block) HWY_ATTR {
      pass_block(block);
      if (alive_ == 0) return false;
      if (const int alive = std::popcount(alive_); 2 * alive < alive_in_frustum) {
        frustum = frustum_around(lattice_, group_, alive_);
        alive_in_frustum = alive;
      }
      return true;
    });
    for (std::size_t r = 0; r < group_.count; ++r)
      hits_.cost[group_.index[r]] = static_cast<std::uint32_t>(scratch_.state[r] / RayState::one_visit);
  }

 private:
  HWY_INLINE void prepare_slopes() {
    for (int a = 0; a < 3; ++a)
      for (std::size_t r = 0; r < group_.count; r += double_lanes) {
        const VecD d = speed(group_, a, r), along_major = speed(group_, group_.major, r);
        hn::StoreU(hn::DemoteTo(half_floats, hn::Div(d, along_major)), half_floats, scratch_.slope[a] + r);
        const VecD inverse = hn::Min(hn::Div(along_major, d), hn::Set(doubles, double{never_passed}));
        hn::StoreU(hn::DemoteTo(half_floats, inverse), half_floats, scratch_.inverse_slope[a] + r);
      }
  }

  /// The place in a block's mirrored coordinates at which rays enter it; exactly 0 on the planes that they enter by.
  HWY_INLINE VecD entry_on(int axis, const int* block, std::size_t r, VecD t_in, VecD t_near) const {
    const VecD plane = hn::Set(doubles, lattice_.plane(axis, 4 * block[axis]));
    const VecD at = hn::MulAdd(t_in, hn::Load(doubles, group_.direction[axis] + r),
                               hn::Load(doubles, group_.origin[axis] + r));
    const VecD within = lattice_.is_mirrored(axis) ? hn::Sub(plane, at) : hn::Sub(at, plane);
    const VecD clamped = hn::Min(hn::Max(within, hn::Zero(doubles)), hn::Set(doubles, 4.0));
    return hn::IfThenElse(hn::Eq(t_near, t_in), hn::Zero(doubles), clamped);
  }

  struct Entries {
    MaskD part;
    VecD entry[3], end;
  };

  /// Which of some rays pass the block, and where they enter.
  HWY_INLINE Entries entries(const int* block, std::size_t r) {
    const VecD from = hn::Load(doubles, group_.t_in + r), to = hn::Load(doubles, group_.t_out + r);
    VecD t_in = from, t_out = to, near[3];
    for (int a = 0; a < 3; ++a) {
      const VecD o = hn::Load(doubles, group_.plane_origin[a] + r), inverse = hn::Load(doubles, group_.inverse[a] + r);
      near[a] = hn::Mul(hn::Sub(hn::Set(doubles, lattice_.plane(a, 4 * block[a])), o), inverse);
      const VecD far = hn::Mul(hn::Sub(hn::Set(doubles, lattice_.plane(a, 4 * block[a] + 4)), o), inverse);
      t_in = hn::Max(t_in, near[a]);
      t_out = hn::Min(t_out, far);
    }
    Entries found;
    found.part = hn::And(hn::Lt(t_in, t_out), mask_of(doubles, alive_ >> r));
    if (hn::AllFalse(doubles, found.part)) return found;
    hn::Store(t_in, doubles, scratch_.t_block + r);
    for (int a = 0; a < 3; ++a) found.entry[a] = entry_on(a, block, r, t_in, near[a]);
    found.end = hn::Mul(hn::Sub(t_out, t_in), speed(group_, group_.major, r));
    return found;
  }

  /// The rays that pass the block, side by side.
  HWY_INLINE void list_rays(const int* block) {
    RaysInBlock& list = scratch_.rays_in_block;
    list.count = 0;
    for (std::size_t r = 0; r < group_.count; r += float_lanes) {
      if ((alive_ >> r & first_rays(float_lanes)) == 0) continue;
      MaskF part;
      VecF entry[3], end;
#if HWY_TARGET == HWY_SCALAR
      const Entries all = entries(block, r);
      part = mask_of(floats, bits_of(doubles, all.part));
      if (hn::AllFalse(floats, part)) continue;
      for (int a = 0; a < 3; ++a) entry[a] = hn::DemoteTo(floats, all.entry[a]);
      end = hn::DemoteTo(floats, all.end);
#else
      const Entries low = entries(block, r), high = entries(block, r + double_lanes);
      const std::uint64_t bits = bits_of(doubles, low.part) | bits_of(doubles, high.part) << double_lanes;
      if (bits == 0) continue;
      part = mask_of(floats, bits);
      for (int a = 0; a < 3; ++a)
        entry[a] = hn::Combine(floats, hn::DemoteTo(half_floats, high.entry[a]), hn::DemoteTo(half_floats, low.entry[a]));
      end = hn::Combine(floats, hn::DemoteTo(half_floats, high.end), hn::DemoteTo(half_floats, low.end));
#endif
      const std::size_t at = list.count;
      for (int a = 0; a < 3; ++a) {
        hn::StoreU(hn::Compress(entry[a], part), floats, list.entry[a] + at);
        hn::StoreU(hn::Compress(hn::Load(floats, scratch_.slope[a] + r), part), floats, list.slope[a] + at);
        hn::StoreU(hn::Compress(hn::Load(floats, scratch_.inverse_slope[a] + r), part), floats,
                   list.inverse_slope[a] + at);
      }
      hn::StoreU(hn::Compress(end, part), floats, list.end + at);
      const VecI rays = hn::Iota(ints, static_cast<std::int32_t>(r));
      hn::StoreU(hn::Compress(rays, hn::RebindMask(ints, part)), ints, list.ray + at);
      list.count += hn::CountTrue(floats, part);
    }
  }

  HWY_INLINE const BlockSamples& samples_of(const int* mirrored) {
    const int block[3] = {lattice_.block(0, mirrored[0]), lattice_.block(1, mirrored[1]), lattice_.block(2, mirrored[2])};
    const auto x = static_cast<std::uint64_t>(block[0]), y = static_cast<std::uint64_t>(block[1]),
               z = static_cast<std::uint64_t>(block[2]);
    const std::uint64_t key = x | y << 21 | z << 42;
    const std::size_t place = (x & 7) | (y & 3) << 3 | (z & 3) << 5;
    BlockSamples& samples = scratch_.blocks[place];
    if (scratch_.block_key[place] != key) {
      scratch_.block_key[place] = key;
      fetch_(surface_.source, block, surface_.isovalue, samples);
    }
    return samples;
  }

  HWY_INLINE void pass_block(const int* block) {
    list_rays(block);
    const RaysInBlock& list = scratch_.rays_in_block;
    if (list.count == 0) return;
    counters_.macrocells_visited += list.count;
    const BlockSamples& samples = samples_of(block);
    const std::uint64_t active = mirrored_bits(samples.active, lattice_.octant);
    if (active == 0) return;
    // The cell's lowest corner is another one in the mirrored block; in a cell that is not active all are of one side.
    const std::uint64_t inside = mirrored_bits(samples.inside, lattice_.octant);
    for (std::size_t first = 0; first < list.count; first += float_lanes)
      walk_cells(block, samples, active, inside, first);
  }

  /// Lanes of rays on their way through the cells of a block.
  struct Lanes {
    VecF entry[3], slope[3], inverse_slope[3], end;
    VecF cell[3];     ///< 0 to 3
    VecF next[3];     ///< how far along the major axis the next plane of each axis inside the block is
    VecF way_in;      ///< how far the ray is where it enters the cell
    MaskF at_low[3];  ///< the entry lies on the cell's lower plane
    VecI bit;         ///< of the cell
    VecI state;
    MaskF inside, has_side;
    MaskF walking;
  };

  HWY_INLINE VecF next_plane(const Lanes& lanes, int axis) const {
    const VecF one = hn::Set(floats, 1.0f), never = hn::Set(floats, never_passed);
    const VecF at = hn::Mul(hn::Sub(hn::Add(lanes.cell[axis], one), lanes.entry[axis]), lanes.inverse_slope[axis]);
    const MaskF is_last = hn::Ge(lanes.cell[axis], hn::Set(floats, 3.0f));
    return hn::IfThenElse(hn::Or(is_last, hn::Ge(lanes.inverse_slope[axis], never)), never, at);
  }

  HWY_INLINE Lanes lanes_from(const int* block, std::size_t first) const {
    const RaysInBlock& list = scratch_.rays_in_block;
    const VecF zero = hn::Zero(floats);
    Lanes lanes;
    lanes.walking = hn::FirstN(floats, list.count - first);
    for (int a = 0; a < 3; ++a) {
      lanes.entry[a] = hn::Load(floats, list.entry[a] + first);
      lanes.slope[a] = hn::Load(floats, list.slope[a] + first);
      lanes.inverse_slope[a] = hn::Load(floats, list.inverse_slope[a] + first);
      // A ray in the lattice's upper face goes through the cells below it.
      const int beyond = lattice_.is_mirrored(a) ? 4 : surface_.leaf_count[a] - 4 * block[a];
      const VecF last = hn::Set(floats, beyond < 4 ? static_cast<float>(beyond - 1) : 3.0f);
      lanes.cell[a] = hn::Min(hn::Floor(hn::Max(lanes.entry[a], zero)), last);
      lanes.next[a] = next_plane(lanes, a);
      lanes.at_low[a] = hn::Eq(lanes.entry[a], lanes.cell[a]);
    }
    lanes.end = hn::Load(floats, list.end + first);
    lanes.way_in = zero;
    const VecF bit = hn::MulAdd(lanes.cell[2], hn::Set(floats, 16.0f),
                                hn::MulAdd(lanes.cell[1], hn::Set(floats, 4.0f), lanes.cell[0]));
    lanes.bit = hn::ConvertTo(ints, bit);
    const VecI rays = hn::IfThenElseZero(hn::RebindMask(ints, lanes.walking), hn::Load(ints, list.ray + first));
    lanes.state = hn::GatherIndex(ints, scratch_.state, rays);
    lanes.state = hn::Add(lanes.state, hn::Set(ints, RayState::one_visit));
    lanes.inside = hn::RebindMask(floats, hn::TestBit(lanes.state, hn::Set(ints, RayState::inside)));
    lanes.has_side = hn::RebindMask(floats, hn::TestBit(lanes.state, hn::Set(ints, RayState::has_side)));
    return lanes;
  }

  /// How far the ray is where it leaves the cell.
  HWY_INLINE VecF way_out(const Lanes& lanes) const {
    return hn::Min(hn::Min(hn::Min(lanes.next[0], lanes.next[1]), lanes.next[2]), lanes.end);
  }

  /// Lets some lanes go on to their next cells.
  HWY_INLINE void step(Lanes& lanes, MaskF moved) const {
    const VecF one = hn::Set(floats, 1.0f);
    const VecF first = hn::Min(hn::Min(lanes.next[0], lanes.next[1]), lanes.next[2]);
    const MaskF along_x = hn::Eq(lanes.next[0], first), along_y = hn::AndNot(along_x, hn::Eq(lanes.next[1], first));
    const MaskF along_z = hn::Not(hn::Or(along_x, along_y));
    const MaskF along[3] = {hn::And(moved, along_x), hn::And(moved, along_y), hn::And(moved, along_z)};
    const MaskF leaves = hn::And(moved, hn::Ge(first, lanes.end));
    for (int a = 0; a < 3; ++a) {
      lanes.cell[a] = hn::IfThenElse(along[a], hn::Add(lanes.cell[a], one), lanes.cell[a]);
      lanes.next[a] = hn::IfThenElse(along[a], next_plane(lanes, a), lanes.next[a]);
      lanes.at_low[a] = hn::Or(along[a], hn::AndNot(moved, lanes.at_low[a]));
    }
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[0]), hn::Set(ints, 1)));
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[1]), hn::Set(ints, 4)));
    lanes.bit = hn::Add(lanes.bit, hn::IfThenElseZero(hn::RebindMask(ints, along[2]), hn::Set(ints, 16)));
    lanes.way_in = hn::IfThenElse(moved, first, lanes.way_in);
    lanes.walking = hn::AndNot(leaves, lanes.walking);
  }

  /// The points, in the cell's coordinates, at which the rays enter and leave it.
  HWY_INLINE void ends_in_cell(const Lanes& lanes, VecF way_out_of_cell, VecF* in, VecF* out) const {
    const VecF zero = hn::Zero(floats), one = hn::Set(floats, 1.0f);
    for (int a = 0; a < 3; ++a) {
      const auto place = [&](VecF way) HWY_ATTR {
        return hn::Min(hn::Max(hn::Sub(hn::MulAdd(way, lanes.slope[a], lanes.entry[a]), lanes.cell[a]), zero), one);
      };
      in[a] = hn::IfThenElse(lanes.at_low[a], zero, place(lanes.way_in));
      out[a] = hn::IfThenElse(hn::Eq(lanes.next[a], way_out_of_cell), one, place(way_out_of_cell));
    }
  }

  HWY_INLINE Corners corners_of(const Lanes& lanes, const BlockSamples& samples, MaskF asked) const {
    VecF place = hn::Set(floats, static_cast<float>(lowest_sample_));
    for (int a = 0; a < 3; ++a) place = hn::MulAdd(lanes.cell[a], hn::Set(floats, static_cast<float>(stride_[a])), place);
    const VecI index = hn::ConvertTo(ints, hn::IfThenElse(asked, place, hn::Set(floats, static_cast<float>(lowest_sample_))));
    Corners corners;
    for (int c = 0; c < 8; ++c) {
      const int offset = (c & 1 ? stride_[0] : 0) + (c & 2 ? stride_[1] : 0) + (c & 4 ? stride_[2] : 0);
      corners.f[c] = hn::GatherIndex(floats, samples.difference, hn::Add(index, hn::Set(ints, offset)));
    }
    return corners;
  }

  HWY_INLINE void walk_cells(const int* block, const BlockSamples& samples, std::uint64_t active, std::uint64_t inside,
                             std::size_t first) {
    Lanes lanes = lanes_from(block, first);
    // Cells to look into: the active ones, and those of the other side than the ray's.
    const std::uint64_t from_inside = active | ~inside, from_outside = active | inside;
    const auto words = [](std::uint64_t bits, int high) HWY_ATTR {
      return hn::Set(ints, static_cast<std::int32_t>(bits >> (32 * high)));
    };
    VecI to_look[2];
    const auto choose_cells = [&]() HWY_ATTR {
      const auto is_inside_lane = hn::RebindMask(ints, lanes.inside), has_side = hn::RebindMask(ints, lanes.has_side);
      for (int high = 0; high < 2; ++high)
        to_look[high] = hn::IfThenElse(
            has_side, hn::IfThenElse(is_inside_lane, words(from_inside, high), words(from_outside, high)),
            words(active, high));
    };
    choose_cells();
    VecI visits = hn::Zero(ints);
    std::uint64_t solved = 0;
    MaskF hit = no_lane(floats);
    while (!hn::AllFalse(floats, lanes.walking)) {
      const VecI word = hn::IfThenElse(hn::Gt(lanes.bit, hn::Set(ints, 31)), to_look[1], to_look[0]);
      constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
      const auto bits = hn::Shr(hn::BitCast(unsigned_ints, word),
                                hn::BitCast(unsigned_ints, hn::And(lanes.bit, hn::Set(ints, 31))));
      const MaskF looks = hn::And(
          lanes.walking,
          hn::RebindMask(floats, hn::TestBit(hn::BitCast(ints, bits), hn::Set(ints, 1))));
      const MaskF passes = hn::AndNot(looks, lanes.walking);
      if (!hn::AllFalse(floats, passes)) {
        visits = hn::Add(visits, hn::IfThenElseZero(hn::RebindMask(ints, passes), hn::Set(ints, 1)));
        step(lanes, passes);
        continue;
      }
      visits = hn::Add(visits, hn::IfThenElseZero(hn::RebindMask(ints, looks), hn::Set(ints, 1)));
      solved += hn::CountTrue(floats, looks);
      const std::uint64_t start = surface_.time_phases ? ticks_now() : 0;
      const MaskF found = look_into_cells(block, samples, lanes, looks, first);
      if (surface_.time_phases) counters_.intersection_ticks += ticks_now() - start;
      hit = hn::Or(hit, found);
      lanes.walking = hn::AndNot(found, lanes.walking);
      choose_cells();
      step(lanes, lanes.walking);
    }
    counters_.cells_visited += static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(ints, visits)));
    counters_.cells_solved += solved;
    keep_state(lanes, visits, hit, first);
  }

  /// Searches the cells of some lanes; which of them found a crossing.
  HWY_INLINE MaskF look_into_cells(const int* block, const BlockSamples& samples, Lanes& lanes, MaskF looks,
                                   std::size_t first) {
    const VecF leaves = way_out(lanes);
    VecF in[3], out[3];
    ends_in_cell(lanes, leaves, in, out);
    const Corners corners = corners_of(lanes, samples, looks);
    const CubicLanes cubic = along(corners, in, out);
    const MaskF starts_inside = is_inside(cubic.b[0]);
    const MaskF sets_side = hn::AndNot(lanes.has_side, looks);
    lanes.inside = hn::Or(hn::AndNot(sets_side, lanes.inside), hn::And(sets_side, starts_inside));
    lanes.has_side = hn::Or(lanes.has_side, looks);
    const Roots roots = search == Search::preview ? secant_step(cubic.b[0], cubic.b[3], lanes.inside, looks)
                                                  : first_changes(cubic, lanes.inside, looks);
    if (!hn::AllFalse(floats, roots.found)) write_hits(block, lanes, corners, leaves, in, out, roots, first);
    return roots.found;
  }

  HWY_INLINE void write_hits(const int* block, const Lanes& lanes, const Corners& corners, VecF leaves, const VecF* in,
                             const VecF* out, const Roots& roots, std::size_t first) {
    VecF p[3], gradient[3];
    const VecF rest = hn::Sub(hn::Set(floats, 1.0f), roots.s);
    for (int a = 0; a < 3; ++a) p[a] = between(in[a], out[a], roots.s, rest);
    gradient_at(corners, p, gradient);
    const VecF way = hn::MulAdd(roots.s, hn::Sub(leaves, lanes.way_in), lanes.way_in);
    HWY_ALIGN float ways[16], gradients[3][16], cells[3][16];
    HWY_ALIGN std::int32_t counts[16], iterations[16];
    hn::Store(way, floats, ways);
    for (int a = 0; a < 3; ++a) {
      hn::Store(gradient[a], floats, gradients[a]);
      hn::Store(lanes.cell[a], floats, cells[a]);
    }
    hn::Store(roots.count, ints, counts);
    hn::Store(roots.iterations, ints, iterations);
    for (std::uint64_t bits = bits_of(floats, roots.found); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      const auto ray = static_cast<std::size_t>(scratch_.rays_in_block.ray[first + lane]);
      const std::size_t at = group_.index[ray];
      const double speed_along = group_.direction[group_.major][ray];
      const double t = scratch_.t_block[ray] + ways[lane] / (speed_along < 0 ? -speed_along : speed_along);
      hits_.t[at] = t < group_.t_out[ray] ? t : group_.t_out[ray];
      hits_.value[at] = surface_.isovalue;
      std::uint64_t id = 0;
      for (int a = 2; a >= 0; --a) {
        int cell = 4 * block[a] + static_cast<int>(cells[a][lane]);
        if (lattice_.is_mirrored(a)) cell = 16 * lattice_.node_count[a] - 1 - cell;
        id = id * static_cast<std::uint64_t>(surface_.leaf_count[a]) + static_cast<std::uint64_t>(cell);
        hits_.gradient[a][at] = lattice_.is_mirrored(a) ? -gradients[a][lane] : gradients[a][lane];
      }
      hits_.cell[at] = id;
      hits_.root_count[at] = static_cast<std::uint32_t>(counts[lane]);
      hits_.iteration_count[at] = static_cast<std::uint32_t>(iterations[lane]);
      alive_ &= ~(std::uint64_t{1} << ray);
    }
  }

  HWY_INLINE void keep_state(const Lanes& lanes, VecI visits, MaskF, std::size_t first) {
    const auto bit = [&](MaskF mask, std::int32_t value) HWY_ATTR {
      return hn::IfThenElseZero(hn::RebindMask(ints, mask), hn::Set(ints, value));
    };
    VecI state = hn::AndNot(hn::Set(ints, RayState::one_visit - 1), lanes.state);
    state = hn::Or(state, hn::Or(bit(lanes.inside, RayState::inside), bit(lanes.has_side, RayState::has_side)));
    state = hn::Add(state, hn::Mul(visits, hn::Set(ints, RayState::one_visit)));
    HWY_ALIGN std::int32_t states[16];
    hn::Store(state, ints, states);
    const RaysInBlock& list = scratch_.rays_in_block;
    for (std::size_t lane = 0; lane < float_lanes && first + lane < list.count; ++lane)
      scratch_.state[list.ray[first + lane]] = states[lane];
  }

  const Surface& surface_;
  const MirroredLattice& lattice_;
  const HitArrays& hits_;
  IsosurfaceScratch& scratch_;
  RayGroup& group_;
  KernelCounters& counters_;
  Fetch fetch_;
  std::uint64_t alive_;    ///< rays without a hit
  int stride_[3];          ///< from a cell's lower to its upper sample, by mirrored axis
  int lowest_sample_ = 0;  ///< of the mirrored block
};

/// The rays of a chunk of at most 64.
template <Search search>
void first_crossings(const Surface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                     IsosurfaceScratch& scratch, KernelCounters& counters) {
  for_each_group(rays, count, surface.leaf_count, surface.node_count, scratch.group,
                 [&](RayGroup&, const MirroredLattice& lattice, Frustum& frustum) HWY_ATTR {
                   GroupWalk<search>(surface, lattice, hits, scratch, counters).run(frustum);
                 });
}

FirstCrossings first_crossings_by(Search search) {
  return search == Search::preview ? first_crossings<Search::preview> : first_crossings<Search::bracketed>;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

FirstCrossings first_crossings_on(Machine machine, Search search) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::first_crossings_by(search);
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::first_crossings_by(search);
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::first_crossings_by(search);
#endif
  return HWY_NAMESPACE::first_crossings_by(search);
}

}  // namespace rhoray::render::wide

#endif
