// The samples of a block as 16-bit words in registers, where permutations look up the corners of
// cells. On some processors (Zen 4) gathers take several times as long.
#if defined(RHORAY_WIDE_MAXIMUM_WORDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_WORDS_INL_H
#undef RHORAY_WIDE_MAXIMUM_WORDS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_WORDS_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/parts.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#undef RHORAY_HAS_WORD_TABLES
#if HWY_TARGET <= HWY_AVX3 && HWY_TARGET != HWY_SCALAR
#define RHORAY_HAS_WORD_TABLES 1
#else
#define RHORAY_HAS_WORD_TABLES 0
#endif

/// Addresses of the squares of a block and of those beside them, on the axes x and y. At the
/// lattice's end, where there are none beside, the block's own square is repeated.
struct SquarePlaces {
  std::uint64_t near[2], far[2];
  std::size_t ends;

  HWY_INLINE SquarePlaces(const SampleSource& source, const int* place) : ends(0) {
    for (int a = 0; a < 2; ++a) {
      const bool is_last = 4 * place[a] + 4 >= source.count[a];
      near[a] = source.address[a][4 * place[a]];
      far[a] = is_last ? near[a] : source.address[a][4 * place[a] + 4];
      ends |= static_cast<std::size_t>(is_last) << a;
    }
  }
};

/// @param z  layer of the block
HWY_INLINE std::uint64_t layer_address(const SampleSource& source, const int* place, int z) {
  const int at = 4 * place[2] + z, last = source.count[2] - 1;
  return source.address[2][at < last ? at : last];
}

#if RHORAY_HAS_WORD_TABLES

inline constexpr hn::FixedTag<std::uint16_t, 32> words{};
using VecW = hn::Vec<decltype(words)>;

/// Words of two vectors, by number from 0 to 63; higher bits of a number are ignored.
HWY_INLINE VecW look_up(VecW low, VecW high, VecW number) {
  return VecW{_mm512_permutex2var_epi16(low.raw, number.raw, high.raw)};
}

/// The 5 x 5 x 5 samples of a block, (x, y, z) at x + 5 y + 25 z, each as its distance below the
/// block's largest. Words are looked up in pairs: the lower word by the lower half of a number and
/// the other one by the upper half.
struct WordTable {
  static constexpr bool is_plain = true;     ///< corners are looked up faster than a bound
  static constexpr bool is_below = true;     ///< coefficients are distances below the largest value
  static constexpr float lowest = -0x1p17F;  ///< less than any value
  /// Factor that applies a distance to both words of a pair.
  static constexpr std::int32_t both = 0x10001;

  VecW part[4];
  std::int32_t first;      ///< of the lowest cell: its corner and the next one on the axis u
  std::int32_t stride[3];  ///< on the axes w, u, v, times `both`

  HWY_INLINE Coefficients coefficients(VecI cell, const Point& p, const Point& q) const {
    VecF below[8];
    const VecI beyond = hn::Add(cell, hn::Set(ints, stride[0])), along_v = hn::Set(ints, stride[2]);
    read_pair(cell, below);
    read_pair(hn::Add(cell, along_v), below + 2);
    read_pair(beyond, below + 4);
    read_pair(hn::Add(beyond, along_v), below + 6);
    return HWY_NAMESPACE::coefficients(below, p, q);
  }

  HWY_INLINE VecW at(VecW number) const {
    const auto is_high = hn::TestBit(number, hn::Set(words, 64));
    return hn::IfThenElse(is_high, look_up(part[2], part[3], number), look_up(part[0], part[1], number));
  }

 private:
  HWY_INLINE void read_pair(VecI cells, VecF* below) const {
    const VecW pair = at(hn::BitCast(words, cells));
    constexpr hn::RebindToUnsigned<Ints> unsigned_ints;
    below[0] = hn::ConvertTo(floats, hn::And(hn::BitCast(ints, pair), hn::Set(ints, 0xffff)));
    below[1] = hn::ConvertTo(floats, hn::BitCast(ints, hn::ShiftRight<16>(hn::BitCast(unsigned_ints, pair))));
  }
};

/// Sources of the words of a block's layer z: numbers 0 to 15 are those of its square of 4 x 4
/// samples, 16 to 31 those of the square beside it, 32 to 35 the row beyond, and 40 the sample
/// beyond both. The first index is 1 if the block is the lattice's last one on x, plus 2 if it is
/// the last on y: there the last samples are repeated.
inline constexpr auto layer_places = [] {
  std::array<std::array<std::uint16_t, 32>, 4> places{};
  for (std::size_t ends = 0; ends < 4; ++ends)
    for (std::size_t i = 0; i < 25; ++i) {
      const std::size_t x = (ends & 1) != 0 && i % 5 == 4 ? 3 : i % 5, y = (ends & 2) != 0 && i / 5 == 4 ? 3 : i / 5;
      places[ends][i] = static_cast<std::uint16_t>(y < 4 ? (x < 4 ? x + 4 * y : 16 + 4 * y) : (x < 4 ? 32 + x : 40));
    }
  return places;
}();

/// Sources of the words of a table's part: two layers of 25 words, where the second has numbers
/// from 32.
inline constexpr auto part_places = [] {
  std::array<std::array<std::uint16_t, 32>, 4> places{};
  for (std::size_t i = 0; i < 125; ++i) {
    const std::size_t layer = i / 25, first = i / 32 * 32 / 25;
    places[i / 32][i % 32] = static_cast<std::uint16_t>(i % 25 + 32 * (layer - first));
  }
  return places;
}();

/// Loads contiguous samples.
template <class T, class Tag>
HWY_INLINE hn::Vec<Tag> load_words(Tag tag, const T* from) {
  using Wide = std::conditional_t<std::is_signed_v<T>, std::int16_t, std::uint16_t>;
  constexpr hn::Rebind<Wide, Tag> wide;
  constexpr hn::Rebind<T, Tag> stored;
  if constexpr (sizeof(T) == 2)
    return hn::BitCast(tag, hn::LoadU(stored, from));
  else
    return hn::BitCast(tag, hn::PromoteTo(wide, hn::LoadU(stored, from)));
}

/// Reads the samples of a block from squares of 4 x 4 samples.
/// @param place  position of the block in the volume
template <class T>
HWY_NOINLINE void fetch_words(const SampleSource& source, const int* place, double highest, WordTable& table) {
  const T* samples = static_cast<const T*>(source.samples);
  const SquarePlaces at(source, place);
  constexpr hn::FixedTag<std::uint16_t, 16> square;
  constexpr hn::FixedTag<std::uint16_t, 8> row;
  const VecW from = hn::LoadU(words, layer_places[at.ends].data());
  VecW layer[5];
  for (int z = 0; z < 5; ++z) {
    const T* here = samples + layer_address(source, place, z);
    const VecW squares = hn::Combine(words, load_words(square, here + at.near[1] + at.far[0]),
                                     load_words(square, here + at.near[1] + at.near[0]));
    const auto beyond = hn::Combine(square, load_words(row, here + at.far[1] + at.far[0]),
                                    load_words(row, here + at.far[1] + at.near[0]));
    layer[z] = look_up(squares, hn::ZeroExtendVector(words, beyond), from);
  }
  const VecW top = hn::Set(words, static_cast<std::uint16_t>(static_cast<std::int32_t>(highest)));
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t first = 32 * i / 25;
    table.part[i] = hn::Sub(top, look_up(layer[first], layer[first + 1], hn::LoadU(words, part_places[i].data())));
  }
}

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
