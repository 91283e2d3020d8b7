// Which rays through a block pass a column of its cells that may hold more than they have reached.
// Where rays run close to the major axis, most pass one to four of its 16 columns.
#if defined(RHORAY_WIDE_MAXIMUM_COLUMNS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_COLUMNS_INL_H
#undef RHORAY_WIDE_MAXIMUM_COLUMNS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_COLUMNS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/largest/words-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// Sample numbers, in a table, of the words of a block's first plane across the major axis, (u, v)
/// at u + 5 v. Those of the next plane are higher by `step`.
struct PlanePlaces {
  HWY_ALIGN std::array<std::uint16_t, 32> number{};
  std::uint16_t step = 0;

  PlanePlaces() = default;
  HWY_INLINE PlanePlaces(std::int32_t lowest, const std::int32_t* stride)
      : step(static_cast<std::uint16_t>(stride[0])) {
    for (std::int32_t i = 0; i < 25; ++i)
      number[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(lowest + i % 5 * stride[1] + i / 5 * stride[2]);
  }
};

template <class Number, std::size_t count, class Place>
constexpr std::array<Number, count> places_of(const Place& place) {
  std::array<Number, count> places{};
  for (std::size_t i = 0; i < count; ++i) places[i] = static_cast<Number>(place(i));
  return places;
}
/// For samples (u, v) at u + 5 v: the next one on u, and both ends of columns on v.
inline constexpr auto sample_beside = places_of<std::uint16_t, 32>([](std::size_t i) { return (i + 1) % 32; });
inline constexpr auto column_low_corner =
    places_of<std::uint16_t, 32>([](std::size_t i) { return i % 4 + i % 16 / 4 * 5; });
inline constexpr auto column_high_corner =
    places_of<std::uint16_t, 32>([](std::size_t i) { return i % 4 + (i % 16 / 4 + 1) * 5; });
/// For columns: the next ones on u and on v.
alignas(64) inline constexpr std::array<std::array<std::int32_t, 16>, 2> next_column{
    places_of<std::int32_t, 16>([](std::size_t i) { return i % 4 < 3 ? i + 1 : i; }),
    places_of<std::int32_t, 16>([](std::size_t i) { return i / 4 < 3 ? i + 4 : i; })};

/// Words of a vector, by number from 0 to 31; higher bits of a number are ignored.
HWY_INLINE VecW look_up(VecW table, VecW number) {
  return VecW{_mm512_permutexvar_epi16(number.raw, table.raw)};
}

/// Upper bounds of the values in a block's columns along the major axis, column (u, v) at u + 4 v:
/// the largest corner.
class Columns {
 public:
  HWY_INLINE Columns(const WordTable& table, const PlanePlaces& places) {
    VecW number = hn::Load(words, places.number.data());
    VecW below = table.at(number);
    for (int plane = 1; plane < 5; ++plane) {
      number = hn::Add(number, hn::Set(words, places.step));
      below = hn::Min(below, table.at(number));
    }
    below = hn::Min(below, look_up(below, hn::LoadU(words, sample_beside.data())));
    below = hn::Min(look_up(below, hn::LoadU(words, column_low_corner.data())),
                    look_up(below, hn::LoadU(words, column_high_corner.data())));
    const auto lower_half = hn::LowerHalf(hn::FixedTag<std::uint16_t, 16>(), below);
    one_ = hn::Neg(hn::ConvertTo(floats, hn::PromoteTo(ints, lower_half)));
    four_ =
        hn::Max(one_, hn::TableLookupLanes(one_, hn::IndicesFromVec(floats, hn::Load(ints, next_column[0].data()))));
    four_ =
        hn::Max(four_, hn::TableLookupLanes(four_, hn::IndicesFromVec(floats, hn::Load(ints, next_column[1].data()))));
  }

  /// For parts of rays in the block: the largest bound of the columns between those that they begin
  /// and end in, or of a few more. Positions on the minor axes are functions of that on the major
  /// one, relative to the block's corner; they rise.
  HWY_INLINE VecF largest_on(VecF from, VecF to, const VecF* start, const VecF* slope) const {
    VecI first[2], last[2];
    for (int m = 0; m < 2; ++m) {
      const auto column_at = [&](VecF w) HWY_ATTR {
        // Clamped to the block also where a part extends far outside it, from an eye very far away.
        const VecF place = hn::MulAdd(slope[m], w, start[m]);
        const VecF inside = hn::Min(hn::Max(place, hn::Zero(floats)), hn::Set(floats, 3.0F));
        return VecI{_mm512_cvttps_epi32(inside.raw)};
      };
      first[m] = column_at(from), last[m] = column_at(to);
    }
    // For more than two columns side by side, use squares of four.
    const auto is_far = hn::Gt(hn::Max(hn::Sub(last[0], first[0]), hn::Sub(last[1], first[1])), hn::Set(ints, 1));
    const VecI one = hn::IfThenElseZero(is_far, hn::Set(ints, 1));
    for (int m = 0; m < 2; ++m) last[m] = hn::Max(hn::Sub(last[m], one), first[m]);
    const VecI table = hn::ShiftLeft<4>(one);
    const VecI first_row = hn::Add(hn::ShiftLeft<2>(first[1]), table),
               last_row = hn::Add(hn::ShiftLeft<2>(last[1]), table);
    const auto of = [&](VecI row, VecI column) HWY_ATTR {
      return VecF{_mm512_permutex2var_ps(one_.raw, hn::Add(row, column).raw, four_.raw)};
    };
    return hn::Max(hn::Max(of(first_row, first[0]), of(first_row, last[0])),
                   hn::Max(of(last_row, first[0]), of(last_row, last[0])));
  }

 private:
  VecF one_;   ///< by column
  VecF four_;  ///< of the four columns from there on
};

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
