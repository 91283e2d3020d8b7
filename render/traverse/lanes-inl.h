// Shared by the sources that are compiled once per machine: numbers of lanes, bits of masks.
// Included again for each machine.
#if defined(RHORAY_WIDE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_LANES_INL_H
#undef RHORAY_WIDE_LANES_INL_H
#else
#define RHORAY_WIDE_LANES_INL_H
#endif

#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using Floats = hn::CappedTag<float, 16>;
using Ints = hn::RebindToSigned<Floats>;
using HalfFloats = hn::Rebind<float, Doubles>;  ///< as many floats as doubles
using HalfInts = hn::Rebind<std::int32_t, Doubles>;
using VecD = hn::Vec<Doubles>;
using VecF = hn::Vec<Floats>;
using VecI = hn::Vec<Ints>;
using MaskD = hn::Mask<Doubles>;
using MaskF = hn::Mask<Floats>;

inline constexpr Doubles doubles{};
inline constexpr Floats floats{};
inline constexpr Ints ints{};
inline constexpr HalfFloats half_floats{};
inline constexpr HalfInts half_ints{};

inline constexpr std::size_t double_lanes = hn::MaxLanes(doubles);
inline constexpr std::size_t float_lanes = hn::MaxLanes(floats);

/// The lanes of a mask as bits; the first lane is the lowest bit.
template <class D>
HWY_INLINE std::uint64_t bits_of(D tag, hn::Mask<D> mask) {
#if HWY_TARGET <= HWY_AVX3 && HWY_TARGET != HWY_SCALAR
  (void)tag;
  return static_cast<std::uint64_t>(mask.raw);
#else
  HWY_ALIGN std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(tag, mask, bytes);
  std::uint64_t bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
#endif
}

/// The mask given by the lowest bits.
template <class D>
HWY_INLINE hn::Mask<D> mask_of(D tag, std::uint64_t bits) {
  HWY_ALIGN std::uint8_t bytes[8];
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(tag, bytes);
}

template <class D>
HWY_INLINE hn::Mask<D> no_lane(D tag) {
  return hn::FirstN(tag, 0);
}

/// Writes the chosen lanes of a vector side by side; there must be room for all lanes. This avoids
/// CompressStore: what it compiles to on AVX-512 takes more than a hundred cycles on some
/// processors (Zen 4).
/// @return  number of chosen lanes
template <class Tag>
HWY_INLINE std::size_t store_chosen(Tag tag, hn::Vec<Tag> v, hn::Mask<Tag> chosen, hn::TFromD<Tag>* to) {
  hn::StoreU(hn::Compress(v, chosen), tag, to);
  return hn::CountTrue(tag, chosen);
}

/// Number of vectors of doubles that hold as many lanes as one of floats.
inline constexpr std::size_t parts_of_floats = float_lanes / double_lanes;

/// The lanes of floats that belong to vector `part` of doubles.
HWY_INLINE VecD as_doubles(VecF x, std::size_t part) {
#if HWY_TARGET == HWY_SCALAR
  (void)part;
  return hn::PromoteTo(doubles, x);
#else
  return hn::PromoteTo(doubles, part == 0 ? hn::LowerHalf(half_floats, x) : hn::UpperHalf(half_floats, x));
#endif
}

HWY_INLINE VecF as_floats(const VecD* parts) {
#if HWY_TARGET == HWY_SCALAR
  return hn::DemoteTo(floats, parts[0]);
#else
  return hn::Combine(floats, hn::DemoteTo(half_floats, parts[1]), hn::DemoteTo(half_floats, parts[0]));
#endif
}

/// True in lanes that hold finite numbers.
HWY_INLINE MaskD is_finite(VecD x) {
  return hn::Le(hn::Abs(x), hn::Set(doubles, 1.7976931348623157e308));
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
