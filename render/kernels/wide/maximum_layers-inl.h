// What 32 rays meet at five planes of samples and between them, in 16 bits.
#if defined(RHORAY_WIDE_MAXIMUM_LAYERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_LAYERS_INL_H
#undef RHORAY_WIDE_MAXIMUM_LAYERS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_LAYERS_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/maximum_columns-inl.h"
#include "render/kernels/wide/maximum_cubic-inl.h"
#include "render/kernels/wide/maximum_parts.h"
#include "render/kernels/wide/maximum_planes-inl.h"
#include "render/kernels/wide/maximum_words-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// The cells between planes, each where its lowest sample is.
struct LayerCells {
  static constexpr bool is_plain = true, is_below = true;

  const std::int32_t* below;

  HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
    VecF corners[8];
    read_four(below, cell, corners);
    read_four(below + MaximumPlanes::edge, cell, corners + 2);
    return HWY_NAMESPACE::coefficients(corners, p, q);
  }

 private:
  /// Two corners, and the two behind them.
  HWY_INLINE static void read_four(const std::int32_t* from, VecI cell, VecF* corners) {
    const VecI low{_mm512_i32gather_epi64(hn::LowerHalf(half_ints, cell).raw, from, 4)};
    const VecI high{_mm512_i32gather_epi64(hn::UpperHalf(half_ints, cell).raw, from, 4)};
    const VecI near = hn::ConcatEven(ints, high, low), far = hn::ConcatOdd(ints, high, low);
    const VecI low_half = hn::Set(ints, 0xffff);
    const auto upper = [](VecI x) HWY_ATTR {
      constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
      return hn::BitCast(ints, hn::ShiftRight<16>(hn::BitCast(unsigned_ints, x)));
    };
    corners[0] = hn::ConvertTo(floats, hn::And(near, low_half));
    corners[1] = hn::ConvertTo(floats, hn::And(far, low_half));
    corners[4] = hn::ConvertTo(floats, upper(near)), corners[5] = hn::ConvertTo(floats, upper(far));
  }
};

/// Where the even words of two vectors lie, one behind the other, and the odd ones.
alignas(64) inline constexpr auto even_words = places_of<std::uint16_t, 32>([](std::size_t i) { return 2 * i; });
alignas(64) inline constexpr auto odd_words = places_of<std::uint16_t, 32>([](std::size_t i) { return 2 * i + 1; });

/// The lower halves of two vectors' numbers, one behind the other.
HWY_INLINE VecS lower_words(VecI low, VecI high) {
  return VecS{_mm512_permutex2var_epi16(low.raw, hn::Load(words, even_words.data()).raw, high.raw)};
}
/// The upper halves.
HWY_INLINE VecS upper_words(VecI low, VecI high) {
  return VecS{_mm512_permutex2var_epi16(low.raw, hn::Load(words, odd_words.data()).raw, high.raw)};
}

/// Eight rows of eight words, eight of sixteen, or sixteen of sixteen, in registers.
template <std::size_t vectors>
struct Rows {
  static constexpr int edge = vectors == 2 ? 8 : MaximumPlanes::edge;  ///< words in a row
  static constexpr int bits = vectors == 2 ? 3 : 4;                    ///< of a number, that tell the word in its row

  VecW part[vectors];

  /// @param from   rows of sixteen
  /// @param first  for rows of eight: the number of the first word in its row
  HWY_INLINE Rows(const std::uint16_t* from, VecW first) {
    if constexpr (vectors == 2) {
      const VecW places = hn::Add(hn::Load(words, rows_of_eight.data()), first);
      for (std::size_t i = 0; i < 2; ++i)
        part[i] = look_up(hn::Load(words, from + 64 * i), hn::Load(words, from + 64 * i + 32), places);
    } else {
      for (std::size_t i = 0; i < vectors; ++i) part[i] = hn::Load(words, from + 32 * i);
    }
  }
  HWY_INLINE VecS at(VecW number) const {
    VecW found = look_up(part[0], part[1], number);
    if constexpr (vectors > 2) {
      const auto is_behind = hn::TestBit(number, hn::Set(words, 64));
      found = hn::IfThenElse(is_behind, look_up(part[2], part[3], number), found);
      if constexpr (vectors == 8) {
        const VecW beyond =
            hn::IfThenElse(is_behind, look_up(part[6], part[7], number), look_up(part[4], part[5], number));
        found = hn::IfThenElse(hn::TestBit(number, hn::Set(words, 128)), beyond, found);
      }
    }
    return hn::BitCast(shorts, found);
  }

 private:
  alignas(64) static constexpr auto rows_of_eight = places_of<std::uint16_t, 32>([](std::size_t i) {
    return i / 8 * 16 + i % 8;
  });
};

/// The rows of a window in which some rays are, and where the lattice ends.
struct RowsOfWindow {
  std::size_t first_word;
  std::uint16_t first_column;  ///< of rows of eight
  double low[2];               ///< of the first sample, on the minor axes
  std::int16_t last[2];        ///< the last place in the lattice from there, as parts of 2^11
};

/// Of 32 rays and the layers between five planes, in words below the highest value.
struct LayerValues {
  static constexpr std::size_t layers = MaximumPlanes::planes - 1;

  VecS at_planes[layers];  ///< the higher one of those at both of its planes
  VecS least[layers];      ///< no value is higher than this
};

/// Both are off as `error` and `bound_error` say, in words. A place is off by 2^-12, by 2^-11 where the lattice ends:
/// on two axes, of samples less than 2^15 apart, a value by 32; rounding adds less than 2. What lies between two planes
/// may also be beside the cell that a ray is taken to be in, no further than twice 2^-12 on each axis, which is another
/// 16; rounding of the bound is less than 8.
inline constexpr std::int16_t layer_error = 34, layer_bound_error = layer_error + 24;

/// @param vector, second  of the rays' vectors
/// @param low_w           the first plane's place on the major axis
template <std::size_t vectors>
HWY_NOINLINE LayerValues values_between(const LineParts& lines, std::size_t vector, std::size_t second, double low_w,
                                        const MaximumPlanes& planes, const RowsOfWindow& rows) {
  constexpr std::size_t count = MaximumPlanes::planes;
  constexpr int edge = Rows<vectors>::edge, bits = Rows<vectors>::bits;
  // Places and slopes as parts of 2^27, of which the upper words are parts of 2^11.
  const VecD from_w = hn::Set(doubles, low_w);
  VecI place[2][2], step[2][2];
  for (int m = 0; m < 2; ++m)
    for (int half = 0; half < 2; ++half) {
      const std::size_t r = (half == 0 ? vector : second) * float_lanes;
      hn::Vec<HalfInts> at[2];
      for (std::size_t part = 0; part < 2; ++part) {
        const VecD slope = hn::Load(doubles, lines.slope[m] + r + part * double_lanes);
        const VecD start = hn::Load(doubles, lines.start[m] + r + part * double_lanes);
        // Half a part more, as the rest is cut off.
        const VecD low = hn::Set(doubles, (rows.low[m] - 0x1p-12) * LineParts::size_of_one);
        at[part] = hn::Vec<HalfInts>{_mm512_cvtpd_epi32(hn::Sub(hn::MulAdd(slope, from_w, start), low).raw)};
      }
      place[m][half] = hn::Combine(ints, at[1], at[0]), step[m][half] = hn::Load(ints, lines.step[m] + r);
    }
  // As parts of 2^15, rounded up.
  const auto slope_of = [](const VecI* by) HWY_ATTR {
    return hn::Add(upper_words(hn::ShiftLeft<4>(by[0]), hn::ShiftLeft<4>(by[1])), hn::Set(shorts, 1));
  };
  const VecS slope_u = slope_of(step[0]), slope_v = slope_of(step[1]);
  const auto quarter = [&](VecS along_u, VecS along_v) HWY_ATTR {
    return hn::Add(hn::ShiftRight<2>(hn::MulFixedPoint15(along_u, slope_u)),
                   hn::ShiftRight<2>(hn::MulFixedPoint15(along_v, slope_v)));
  };
  const VecS zero = hn::Zero(shorts), fraction = hn::Set(shorts, 0x7fff);
  const VecS last_u = hn::Set(shorts, rows.last[0]), last_v = hn::Set(shorts, rows.last[1]);
  const VecW first_column = hn::Set(words, rows.first_column);
  const Rows<vectors> rises(planes.rise + rows.first_word, first_column);

  VecS below[count];
  // A quarter of the most that values rise in a plane on the way to the next one, and from the last one: within the
  // cell, and in those beside it as well.
  VecS ahead[count], behind[count], around[count];
  VecW cell[count];
  for (std::size_t k = 0; k < count; ++k) {
    const VecS u = hn::Min(hn::Max(upper_words(place[0][0], place[0][1]), zero), last_u);
    const VecS v = hn::Min(hn::Max(upper_words(place[1][0], place[1][1]), zero), last_v);
    for (int m = 0; m < 2; ++m)
      for (int half = 0; half < 2; ++half) place[m][half] = hn::Add(place[m][half], step[m][half]);
    const VecW row = hn::AndNot(hn::Set(words, edge - 1), hn::ShiftRight<11 - bits>(hn::BitCast(words, v)));
    const VecW here = hn::Add(row, hn::ShiftRight<11>(hn::BitCast(words, u)));
    const VecS at_u = hn::And(hn::ShiftLeft<4>(u), fraction), at_v = hn::And(hn::ShiftLeft<4>(v), fraction);
    const Rows<vectors> samples(planes.below[k] + rows.first_word, first_column);
    const auto corner = [&](std::uint16_t further)
                            HWY_ATTR { return samples.at(hn::Add(here, hn::Set(words, further))); };
    const VecS f00 = samples.at(here), f10 = corner(1), f01 = corner(edge), f11 = corner(edge + 1);
    const VecS low_u = hn::Sub(f10, f00), high_u = hn::Sub(f11, f01), low_v = hn::Sub(f01, f00),
               high_v = hn::Sub(f11, f10);
    const VecS low = hn::Add(f00, hn::MulFixedPoint15(low_u, at_u));
    const VecS high = hn::Add(f01, hn::MulFixedPoint15(high_u, at_u));
    below[k] = hn::Add(low, hn::MulFixedPoint15(hn::Sub(high, low), at_v));
    // A value rises where the word falls.
    ahead[k] = hn::Neg(quarter(hn::Min(hn::Min(low_u, high_u), zero), hn::Min(hn::Min(low_v, high_v), zero)));
    behind[k] = quarter(hn::Max(hn::Max(low_u, high_u), zero), hn::Max(hn::Max(low_v, high_v), zero));
    around[k] = rises.at(here);
    cell[k] = here;
  }

  LayerValues values;
  for (std::size_t k = 0; k < LayerValues::layers; ++k) {
    // Between the planes a value is at most (1 - w) (a + w g) + w (b + (1 - w) h), where a and b are those at the
    // planes and g and h how much values rise in them. Its largest exceeds that of a and b by (g + h - d)^2 / (4 (g +
    // h)), where d, how far a and b are apart, is less than g + h. As a function of d that is not above two chords,
    // from d = 0 to its half and from there on.
    const VecS apart = hn::ShiftRight<3>(hn::Abs(hn::Sub(below[k], below[k + 1])));
    const auto stays = hn::RebindMask(shorts, hn::Eq(cell[k], cell[k + 1]));
    const VecS rise = hn::SaturatedAdd(
        hn::IfThenElse(stays, hn::SaturatedAdd(ahead[k], behind[k + 1]), hn::SaturatedAdd(around[k], around[k + 1])),
        hn::Set(shorts, 4));
    const VecS first_chord = hn::Sub(rise, hn::Add(apart, hn::Add(apart, apart))),
               second_chord = hn::Sub(hn::ShiftRight<1>(rise), apart);
    const VecS further = hn::Max(hn::Max(first_chord, second_chord), zero);
    values.at_planes[k] = hn::Min(below[k], below[k + 1]);
    values.least[k] =
        hn::SaturatedSub(hn::SaturatedSub(values.at_planes[k], further), hn::Set(shorts, layer_bound_error));
  }
  return values;
}

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
