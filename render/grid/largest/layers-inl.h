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

#include "render/grid/largest/columns-inl.h"
#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/parts.h"
#include "render/grid/largest/planes-inl.h"
#include "render/grid/largest/words-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// The cells between planes; a cell's index is that of its lowest sample.
struct LayerCells {
  static constexpr bool is_plain = true, is_below = true;

  const std::int32_t* below;
  std::ptrdiff_t edge;  ///< samples in a row

  HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
    VecF corners[8];
    read_four(below, cell, corners);
    read_four(below + edge, cell, corners + 2);
    return HWY_NAMESPACE::coefficients(corners, p, q);
  }

 private:
  /// Reads two corners and the two behind them.
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

/// Indices of the even words of two consecutive vectors, and of the odd ones.
alignas(64) inline constexpr auto even_words = places_of<std::uint16_t, 32>([](std::size_t i) { return 2 * i; });
alignas(64) inline constexpr auto odd_words = places_of<std::uint16_t, 32>([](std::size_t i) { return 2 * i + 1; });

/// The lower halves of two vectors' numbers, one vector after the other.
HWY_INLINE VecS lower_words(VecI low, VecI high) {
  return VecS{_mm512_permutex2var_epi16(low.raw, hn::Load(words, even_words.data()).raw, high.raw)};
}
/// The upper halves.
HWY_INLINE VecS upper_words(VecI low, VecI high) {
  return VecS{_mm512_permutex2var_epi16(low.raw, hn::Load(words, odd_words.data()).raw, high.raw)};
}

/// The words at the corners of 32 cells of a plane, (u, v).
struct CornerWords {
  VecS f00, f10, f01, f11;
};

/// Planes of narrow windows: eight rows of eight words, eight of sixteen, or sixteen of sixteen, in
/// registers. @tparam knows_rise what rays gain in a plane is known
template <std::size_t vectors, bool knows_rise>
class Rows {
 public:
  static constexpr bool has_rise = knows_rise;
  /// Of a position's 16 bits, those that are the fraction of a cell.
  static constexpr int part_bits = 11;
  static constexpr std::size_t plane_size = PlaneWindow::narrow * PlaneWindow::narrow;

  /// @param from   rows of sixteen
  /// @param first  for rows of eight: the index of the first word in its row
  HWY_INLINE Rows(const std::uint16_t* from, std::uint16_t first) {
    if constexpr (vectors == 2) {
      const VecW places = hn::Add(hn::Load(words, rows_of_eight.data()), hn::Set(words, first));
      for (std::size_t i = 0; i < 2; ++i)
        part_[i] = look_up(hn::Load(words, from + 64 * i), hn::Load(words, from + 64 * i + 32), places);
    } else {
      for (std::size_t i = 0; i < vectors; ++i) part_[i] = hn::Load(words, from + 32 * i);
    }
  }

  /// Numbers of the lowest corners of cells.
  HWY_INLINE static VecW number(VecW u, VecW v) {
    const VecW row = hn::AndNot(hn::Set(words, edge - 1), hn::ShiftRight<part_bits - bits>(v));
    return hn::Add(row, hn::ShiftRight<part_bits>(u));
  }
  HWY_INLINE VecS at(VecW number) const {
    VecW found = look_up(part_[0], part_[1], number);
    if constexpr (vectors > 2) {
      const auto is_behind = hn::TestBit(number, hn::Set(words, 64));
      found = hn::IfThenElse(is_behind, look_up(part_[2], part_[3], number), found);
      if constexpr (vectors == 8) {
        const VecW beyond =
            hn::IfThenElse(is_behind, look_up(part_[6], part_[7], number), look_up(part_[4], part_[5], number));
        found = hn::IfThenElse(hn::TestBit(number, hn::Set(words, 128)), beyond, found);
      }
    }
    return hn::BitCast(shorts, found);
  }
  HWY_INLINE CornerWords corners(VecW lowest) const {
    const auto further = [&](std::uint16_t by) HWY_ATTR { return at(hn::Add(lowest, hn::Set(words, by))); };
    return {at(lowest), further(1), further(edge), further(edge + 1)};
  }

 private:
  static constexpr int edge = vectors == 2 ? 8 : PlaneWindow::narrow;  ///< words in a row
  /// Of a number, the bits that select the word in its row.
  static constexpr int bits = vectors == 2 ? 3 : 4;

  alignas(64) static constexpr auto rows_of_eight = places_of<std::uint16_t, 32>([](std::size_t i) {
    return i / 8 * 16 + i % 8;
  });

  VecW part_[vectors];
};

/// Planes of wide windows: thirty-two rows of thirty-two words, in memory.
class WideRows {
 public:
  static constexpr bool has_rise = false;
  static constexpr int part_bits = 10;
  static constexpr std::size_t plane_size = PlaneWindow::wide * PlaneWindow::wide;

  HWY_INLINE WideRows(const std::uint16_t* from, std::uint16_t) : from_(from) {}

  HWY_INLINE static VecW number(VecW u, VecW v) {
    constexpr int bits = 5;  // bits that select the word in its row
    const VecW row = hn::AndNot(hn::Set(words, PlaneWindow::wide - 1), hn::ShiftRight<part_bits - bits>(v));
    return hn::Add(row, hn::ShiftRight<part_bits>(u));
  }
  HWY_INLINE CornerWords corners(VecW lowest) const {
    constexpr hn::FixedTag<std::uint16_t, 16> half;
    const VecI low = hn::PromoteTo(ints, hn::LowerHalf(half, lowest)),
               high = hn::PromoteTo(ints, hn::UpperHalf(half, lowest));
    // Two adjacent words.
    const auto pairs = [&](VecI number, std::ptrdiff_t further)
                           HWY_ATTR { return VecI{_mm512_i32gather_epi32(number.raw, from_ + further, 2)}; };
    const VecI near_low = pairs(low, 0), near_high = pairs(high, 0);
    const VecI far_low = pairs(low, PlaneWindow::wide), far_high = pairs(high, PlaneWindow::wide);
    return {lower_words(near_low, near_high), upper_words(near_low, near_high), lower_words(far_low, far_high),
            upper_words(far_low, far_high)};
  }

 private:
  const std::uint16_t* from_;
};

/// The rows of a window that contain some rays, and where rays pass.
struct RowsOfWindow {
  std::size_t first_word;
  std::uint16_t first_column;  ///< for rows of eight
  double low[2];               ///< of the first sample, on the minor axes
  int cells[2];                ///< from there to the last one that rays pass
  bool is_at_end;              ///< the last of these is the lattice's last cell
};

/// For 32 rays and the layers between five planes, in words below the highest value.
struct LayerValues {
  static constexpr std::size_t layers = MaximumPlanes::planes - 1;

  VecS reached[layers];  ///< the value at one of its planes is no lower
  /// No value is higher; the maximum where the layer is left to the one before.
  VecS least[layers];
};

/// The bound of a layer's values holds for the line through the positions that a ray is taken to be
/// at, at both planes. These errors are in words; no two words of a window are farther apart than
/// 2^15. The errors are multiplied by `far`. It is 1 where those positions are off by 2^-12, and
/// more where they have fewer bits and where the lattice ends.
///
/// * Values on that line are off by 16, and at planes by 2 for rounding.
/// * Its slopes are off by 2^-11 and, rounded, 2^-15. So what words gain along the ray in a cell,
///   in one plane less than in the other, is off by 68, 2^16 of that on each axis, and the twist by
///   as much. The bound is off by a quarter, 34, and less than 4 for rounding.
/// * Between cells the gain is off by 68, 2^15 of it on each axis in both planes. Where it comes
///   from corners it is off by three times 2^15 of it on each axis, 102: less than 28 quarters. Its
///   rounding is less than 8.
/// * On the true line the gain differs by less than 128: 16 on each axis in each plane, as the
///   twist is 2^16; 48 where another cell is passed than the assumed ones; 8 as slopes are rounded.
///   Values at planes differ by 36 together. If they fall by so much more than can be gained, less
///   than 48 quarters, no value of the layer reaches the one where the ray enters it.
struct LayerErrors {
  std::int16_t value, bound, within, crossing, falling;

  HWY_INLINE explicit LayerErrors(int far)
      : value(static_cast<std::int16_t>(16 * far + 2)),
        bound(static_cast<std::int16_t>(50 * far + 6)),
        within(8),
        crossing(static_cast<std::int16_t>(28 * far + within)),
        falling(static_cast<std::int16_t>(48 * far)) {}
};

/// @param vector, second  indices of the rays' vectors
/// @param low_w           the first plane's position on the major axis
/// @param clear           distance from a cell's edges at which rays pass no other cell, in parts
///                        of 2^15
template <class AnyRows>
HWY_NOINLINE LayerValues values_between(const LineParts& lines, std::size_t vector, std::size_t second, double low_w,
                                        const MaximumPlanes& planes, const RowsOfWindow& rows, int clear) {
  constexpr std::size_t count = MaximumPlanes::planes;
  constexpr int part_bits = AnyRows::part_bits;
  // Positions and slopes as integers whose upper words are positions with part_bits for the
  // fraction of a cell.
  constexpr double scale = 0x1p16 * (1 << part_bits) / LineParts::size_of_one;
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
        const VecD low = hn::Set(doubles, (rows.low[m] - 0.5 / (1 << part_bits)) * LineParts::size_of_one);
        const VecD from_low = hn::Sub(hn::MulAdd(slope, from_w, start), low);
        at[part] = hn::Vec<HalfInts>{
            _mm512_cvtpd_epi32(scale == 1 ? from_low.raw : hn::Mul(from_low, hn::Set(doubles, scale)).raw)};
      }
      place[m][half] = hn::Combine(ints, at[1], at[0]);
      step[m][half] = hn::ShiftRight<11 - part_bits>(hn::Load(ints, lines.step[m] + r));
    }
  constexpr int to_fraction = 15 - part_bits;  // bits
  // In parts of 2^15, rounded up.
  const auto slope_of = [](const VecI* by) HWY_ATTR {
    return hn::Add(upper_words(hn::ShiftLeft<to_fraction>(by[0]), hn::ShiftLeft<to_fraction>(by[1])),
                   hn::Set(shorts, 1));
  };
  const VecS slope_u = slope_of(step[0]), slope_v = slope_of(step[1]), slope_uv = hn::MulFixedPoint15(slope_u, slope_v);
  const VecS zero = hn::Zero(shorts), fraction = hn::Set(shorts, 0x7fff), middle = hn::Set(shorts, 0x4000);
  const auto last_of = [&](int m) HWY_ATTR {
    return hn::Set(shorts, static_cast<std::int16_t>((rows.cells[m] << part_bits) - 1));
  };
  const VecS last_u = last_of(0), last_v = last_of(1);
  const std::uint16_t* const rise = AnyRows::has_rise ? planes.rise : planes.below;
  [[maybe_unused]] const AnyRows rises(rise + rows.first_word, rows.first_column);

  VecS u[count], v[count], below[count];
  VecW cell[count];
  // Quarters, in a plane, of how fast words rise along the ray and of how that changes from one end
  // to the other, within the cell. Also a quarter of the most that values rise on the way to the
  // next plane or from the last one, including the neighbouring cells. Where that is not known, the
  // largest word of the cell's corners.
  VecS along[count], twist[count], around[count];
  VecS off_middle[count];  // from the middle of the cell, on the axis where it is larger
  for (std::size_t k = 0; k < count; ++k) {
    u[k] = hn::Min(hn::Max(upper_words(place[0][0], place[0][1]), zero), last_u);
    v[k] = hn::Min(hn::Max(upper_words(place[1][0], place[1][1]), zero), last_v);
    for (int m = 0; m < 2; ++m)
      for (int half = 0; half < 2; ++half) place[m][half] = hn::Add(place[m][half], step[m][half]);
    cell[k] = AnyRows::number(hn::BitCast(words, u[k]), hn::BitCast(words, v[k]));
    const VecS at_u = hn::And(hn::ShiftLeft<to_fraction>(u[k]), fraction),
               at_v = hn::And(hn::ShiftLeft<to_fraction>(v[k]), fraction);
    const AnyRows samples(planes.below + k * AnyRows::plane_size + rows.first_word, rows.first_column);
    const auto [f00, f10, f01, f11] = samples.corners(cell[k]);
    const VecS low_u = hn::Sub(f10, f00), high_u = hn::Sub(f11, f01);
    const VecS low = hn::Add(f00, hn::MulFixedPoint15(low_u, at_u));
    const VecS on_v = hn::Sub(hn::Add(f01, hn::MulFixedPoint15(high_u, at_u)), low);
    below[k] = hn::Add(low, hn::MulFixedPoint15(on_v, at_v));
    const VecS half_low_u = hn::ShiftRight<1>(low_u), half_twist = hn::Sub(hn::ShiftRight<1>(high_u), half_low_u);
    const VecS half_on_u = hn::Add(half_low_u, hn::MulFixedPoint15(half_twist, at_v));
    along[k] = hn::Add(hn::ShiftRight<1>(hn::MulFixedPoint15(half_on_u, slope_u)),
                       hn::ShiftRight<2>(hn::MulFixedPoint15(on_v, slope_v)));
    twist[k] = hn::ShiftRight<1>(hn::MulFixedPoint15(half_twist, slope_uv));
    if constexpr (AnyRows::has_rise)
      around[k] = rises.at(cell[k]);
    else
      around[k] = hn::Max(hn::Max(f00, f10), hn::Max(f01, f11));
    off_middle[k] = hn::Max(hn::Abs(hn::Sub(at_u, middle)), hn::Abs(hn::Sub(at_v, middle)));
  }

  const LayerErrors errors((rows.is_at_end ? 2 : 1) << (11 - part_bits));
  const VecS value_error = hn::Set(shorts, errors.value), bound_error = hn::Set(shorts, errors.bound),
             crossing_error = hn::Set(shorts, errors.crossing), within_error = hn::Set(shorts, errors.within),
             falling_error = hn::Set(shorts, errors.falling);
  const VecS inside = hn::Set(shorts, static_cast<std::int16_t>(0x4000 - clear));
  LayerValues values;
  for (std::size_t k = 0; k < LayerValues::layers; ++k) {
    // Words at the share t of the way are a + d t - (h - g - r t - s (1 - t)) t (1 - t). Here a is
    // the word at the first plane and d the difference to the other; g and h are how fast words
    // rise in both planes, and r and s how that changes. Let R be the largest value of the bracket.
    // If |d| < R, no word is less than both a and a + d by more than (R - |d|)^2 / (4 R); otherwise
    // none is less than both. As a function of d this is not above two chords, from d = 0 to R / 2
    // and from there on.
    const VecS in_cell = hn::SaturatedSub(hn::SaturatedSub(along[k + 1], along[k]), hn::Min(twist[k], twist[k + 1]));
    const VecS within = hn::SaturatedAdd(in_cell, within_error);
    VecS gain;  // a quarter of R, or more
    if constexpr (AnyRows::has_rise) {
      const VecS between = hn::SaturatedAdd(hn::SaturatedAdd(around[k], around[k + 1]), crossing_error);
      gain = hn::IfThenElse(hn::RebindMask(shorts, hn::Eq(cell[k], cell[k + 1])), within, between);
    } else {
      // No word is less than 0. So consider, in a plane, the way from where the ray leaves the
      // cell, compared with what the cell's corners predict for all of the plane. Behind one edge
      // no word is less than predicted by more than twice the largest at its corners. Behind two
      // edges the bound is three times as much, because the twist is another one there. The ways
      // behind in both planes together are no longer than the way from one to the other.
      const VecS part = hn::Set(shorts, (1 << part_bits) - 1);
      const auto leaves_u = hn::Gt(u[k + 1], hn::Or(u[k], part)), leaves_v = hn::Gt(v[k + 1], hn::Or(v[k], part));
      const auto way = [&](auto leaves, VecS by)
                           HWY_ATTR { return hn::BitCast(words, hn::IfThenElseZero(leaves, by)); };
      const VecS half_way = hn::BitCast(shorts, hn::AverageRound(way(leaves_u, slope_u), way(leaves_v, slope_v)));
      const VecS behind_one = hn::MulFixedPoint15(hn::Max(around[k], around[k + 1]), half_way);
      const VecS behind_two = hn::IfThenElseZero(hn::And(leaves_u, leaves_v), hn::ShiftRight<1>(behind_one));
      gain = hn::SaturatedAdd(hn::SaturatedAdd(in_cell, crossing_error), hn::SaturatedAdd(behind_one, behind_two));
    }
    gain = hn::Max(gain, zero);
    const VecS falls = hn::Sub(below[k + 1], below[k]), apart = hn::ShiftRight<3>(hn::Abs(falls));
    const VecS first_chord = hn::Sub(gain, hn::Add(apart, hn::Add(apart, apart))),
               second_chord = hn::Sub(hn::ShiftRight<1>(gain), apart);
    const VecS further = hn::Max(hn::Max(first_chord, second_chord), zero);
    const VecS at_planes = hn::Min(below[k], below[k + 1]);
    values.reached[k] = hn::SaturatedAdd(at_planes, value_error);
    const VecS least = hn::SaturatedSub(hn::SaturatedSub(at_planes, further), bound_error);
    // Where the largest value is certainly the one at the first plane, the layer before has it as
    // well and is enough: as for cells (is_left_to_cell_before), where neither this cell nor those
    // behind it have one as large.
    const auto only_falls = hn::Gt(hn::ShiftRight<2>(falls), hn::SaturatedAdd(gain, falling_error));
    const auto is_left = hn::And(only_falls, hn::Lt(off_middle[k], inside));
    values.least[k] = hn::IfThenElse(is_left, hn::Set(shorts, 0x7fff), least);
  }
  return values;
}

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
