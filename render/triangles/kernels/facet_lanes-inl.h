// Helpers that the wide kernel of facets needs beyond lanes-inl.h: tags, bounds, and rays sorted by
// their direction of movement.
#if defined(RHORAY_WIDE_FACET_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_LANES_INL_H
#undef RHORAY_WIDE_FACET_LANES_INL_H
#else
#define RHORAY_WIDE_FACET_LANES_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/traverse/lanes-inl.h"
#include "render/triangles/kernels/facet_parts.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

inline constexpr std::size_t pack = FacetScratch::pack, packs = FacetScratch::packs, lanes = FacetScratch::lanes;
inline constexpr std::uint64_t pack_bits = (std::uint64_t{1} << pack) - 1;

using Longs = hn::RebindToSigned<Doubles>;
using UnsignedLongs = hn::RebindToUnsigned<Doubles>;
using Counts = hn::Rebind<std::uint32_t, Doubles>;
using VecI64 = hn::Vec<Longs>;
inline constexpr Longs longs{};
inline constexpr UnsignedLongs unsigned_longs{};
inline constexpr Counts counts{};

/// Larger than any relevant number in the facets' frame, and small enough that sums stay finite.
inline constexpr float beyond = 1e30f;

/// The depth of something that is nowhere.
inline constexpr float never = 4 * beyond;

/// The margin by which bounds of a group are widened: more than the rounding of positions and of
/// the bounds themselves.
inline constexpr float bound_margin = 0x1p-20f;

HWY_INLINE Directions directions_of(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                    double farthest) {
  Directions bits{};
  const VecD largest_start = hn::Set(doubles, farthest / surface.scale);
  for (std::size_t r = 0; r < count; r += double_lanes) {
    VecD size[3], d[3], start_sum = hn::Zero(doubles);  // a sum that contains a NaN is a NaN
    for (int a = 0; a < 3; ++a) {
      d[a] = hn::Load(doubles, rays.direction[a] + r);
      size[a] = hn::Abs(d[a]);
      const VecD start = hn::Sub(hn::Load(doubles, rays.origin[a] + r), hn::Set(doubles, surface.anchor[a]));
      start_sum = hn::Add(start_sum, hn::Abs(start));
    }
    const MaskD x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
    const MaskD y = hn::AndNot(x, hn::Ge(size[1], size[2]));
    const VecD largest = hn::Max(size[0], hn::Max(size[1], size[2]));
    const VecD size_sum = hn::Add(size[0], hn::Add(size[1], size[2]));
    const VecD t_min = hn::Load(doubles, rays.t_min + r), t_max = hn::Load(doubles, rays.t_max + r);
    // A ray that ends before it begins hits nothing.
    const MaskD asked = hn::AndNot(hn::Gt(t_min, t_max), hn::FirstN(doubles, count - r));
    const MaskD usable = hn::And(
        hn::And(asked, hn::Le(t_min, t_max)),
        hn::And(hn::Le(start_sum, largest_start),
                hn::And(hn::Gt(largest, hn::Set(doubles, 0x1p-400)), hn::Lt(size_sum, hn::Set(doubles, 0x1p400)))));
    const MaskD along[3] = {x, y, hn::Not(hn::Or(x, y))};
    for (int a = 0; a < 3; ++a) {
      bits.along[a] |= bits_of(doubles, hn::And(usable, along[a])) << r;
      bits.down[a] |= bits_of(doubles, hn::Lt(d[a], hn::Zero(doubles))) << r;
    }
    bits.strange |= bits_of(doubles, hn::AndNot(usable, asked)) << r;
  }
  return bits;
}

/// Returns the lanes of a chunk's rays.
HWY_INLINE std::uint64_t lanes_of(std::uint64_t rays) {
  std::uint64_t in_lanes = 0;
  for (std::size_t quad = 0; quad < lanes / 4; ++quad) in_lanes |= (rays >> 4 * quad & 15) << lane_of(4 * quad);
  return in_lanes;
}

/// Returns the rays of a chunk's lanes.
HWY_INLINE std::uint64_t rays_of(std::uint64_t in_lanes) {
  std::uint64_t rays = 0;
  for (std::size_t quad = 0; quad < lanes / 4; ++quad) rays |= (in_lanes >> lane_of(4 * quad) & 15) << 4 * quad;
  return rays;
}

/// Loads per-lane numbers of the rays from r on, as many as a vector has doubles. They are loaded
/// from the lanes of the rays: a row of eight rays is in two packs.
template <class Tag>
HWY_INLINE hn::Vec<Tag> load_from_lanes(Tag tag, const hn::TFromD<Tag>* of_lanes, std::size_t r) {
#if HWY_TARGET <= HWY_AVX3
  const hn::Half<Tag> half;
  return hn::Combine(tag, hn::LoadU(half, of_lanes + lane_of(r + 4)), hn::LoadU(half, of_lanes + lane_of(r)));
#else
  static_assert(double_lanes <= 4);
  return hn::LoadU(tag, of_lanes + lane_of(r));
#endif
}
template <class Tag>
HWY_INLINE void store_in_lanes(Tag tag, hn::Vec<Tag> numbers, hn::TFromD<Tag>* of_lanes, std::size_t r) {
#if HWY_TARGET <= HWY_AVX3
  const hn::Half<Tag> half;
  hn::StoreU(hn::LowerHalf(half, numbers), half, of_lanes + lane_of(r));
  hn::StoreU(hn::UpperHalf(half, numbers), half, of_lanes + lane_of(r + 4));
#else
  static_assert(double_lanes <= 4);
  hn::StoreU(numbers, tag, of_lanes + lane_of(r));
#endif
}

HWY_INLINE float least_of(VecF v) {
  return hn::GetLane(hn::MinOfLanes(floats, v));
}
HWY_INLINE float largest_of(VecF v) {
  return hn::GetLane(hn::MaxOfLanes(floats, v));
}

/// Returns the largest element of each of four vectors.
HWY_INLINE void largest_of_each(const VecF (&v)[4], float* out) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < 4; ++i) out[i] = hn::GetLane(v[i]);
#else
  // Transpose blocks of four lanes so that each vector gets one lane, then compare the blocks.
  const auto paired = [](VecF a, VecF b) HWY_ATTR {
    return hn::Max(hn::InterleaveLower(floats, a, b), hn::InterleaveUpper(floats, a, b));
  };
  const VecF each = paired(paired(v[0], v[2]), paired(v[1], v[3]));
  HWY_ALIGN float blocks[float_lanes];
  hn::Store(each, floats, blocks);
  const hn::FixedTag<float, 4> four;
  auto largest = hn::Load(four, blocks);
  for (std::size_t i = 4; i < float_lanes; i += 4) largest = hn::Max(largest, hn::Load(four, blocks + i));
  hn::StoreU(largest, four, out);
#endif
}

/// x_a y_b - y_a x_b, without a fused operation. The edge seen from its other end has the same
/// rounded products, so its sign is exactly opposite. Because rounding is monotone, the sign is
/// never the wrong one.
HWY_INLINE VecF edge_function(VecF ax, VecF ay, VecF bx, VecF by) {
  return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
