// Planes of samples across the major axis as 16-bit words, around the rays of a search, for lookup
// by permutations.
#if defined(RHORAY_WIDE_MAXIMUM_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_PLANES_INL_H
#undef RHORAY_WIDE_MAXIMUM_PLANES_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_PLANES_INL_H
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/largest/parts.h"
#include "render/grid/largest/words-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

inline constexpr hn::FixedTag<std::int16_t, 32> shorts{};
using VecS = hn::Vec<decltype(shorts)>;

/// A rectangle of bricks across the major axis, in samples of the mirrored lattice.
struct PlaneWindow {
  /// Samples on an axis, at most.
  static constexpr int narrow = MaximumPlanes::edge / 2, wide = MaximumPlanes::edge;

  /// On the minor axes: where a brick of the volume begins or, mirrored, ends.
  int first[2];
  int bricks[2];

  PlaneWindow() = default;
  /// A window around the cells from first to last.
  HWY_INLINE PlaneWindow(const MirroredLattice& lattice, const int* minor, const int* first_cell,
                         const int* last_cell) {
    for (int m = 0; m < 2; ++m) {
      const int shift = lattice.is_mirrored(minor[m]) ? 1 : 0;
      first[m] = ((first_cell[m] - shift) & ~3) + shift;
      bricks[m] = ((last_cell[m] + 1 - first[m]) >> 2) + 1;
    }
  }

  HWY_INLINE bool is_narrow() const { return fits(narrow); }
  HWY_INLINE bool fits() const { return fits(wide); }
  /// Samples in a row of the planes that hold it.
  HWY_INLINE int edge() const { return is_narrow() ? narrow : wide; }

 private:
  HWY_INLINE bool fits(int edge) const { return 4 * bricks[0] <= edge && 4 * bricks[1] <= edge; }
};

/// Words are (highest - sample) * 2^shift, rounded down: from 0 to less than 2^15 for samples in
/// this range.
struct WordScale {
  std::int32_t lowest, highest;
  int shift;  ///< -1 or more

  HWY_INLINE WordScale(std::int32_t lowest_sample, std::int32_t highest_sample)
      : lowest(lowest_sample),
        highest(highest_sample),
        shift(highest > lowest ? std::countl_zero(static_cast<std::uint32_t>(highest - lowest)) - 17 : 0) {}
  HWY_INLINE double unit() const { return shift < 0 ? 0.5 : static_cast<double>(1 << shift); }
};

/// Reads planes from a volume in which bricks of 4 x 4 x 4 samples are contiguous.
class PlaneReader {
 public:
  PlaneReader(const MaximumField& field, const MirroredLattice& lattice, const int* axes)
      : field_(field), lattice_(lattice), axes_{axes[0], axes[1], axes[2]} {
    const auto step = [&](int axis) { return lattice.is_mirrored(axis) ? -(1 << 2 * axis) : 1 << 2 * axis; };
    const auto low = [&](int axis) { return lattice.is_mirrored(axis) ? 3 << 2 * axis : 0; };
    const int lowest = low(axes[1]) + low(axes[2]);
    for (int i = 0; i < 16; ++i)
      in_brick_[static_cast<std::size_t>(i)] =
          static_cast<std::uint16_t>(lowest + i % 4 * step(axes[1]) + i / 4 * step(axes[2]));
  }

  /// Reads planes, from first_plane on.
  template <class T>
  HWY_NOINLINE void read_planes(const PlaneWindow& window, int first_plane, const WordScale& scale,
                                MaximumPlanes& planes) const {
    const auto read_of = [&]<bool is_wide>() HWY_ATTR {
      constexpr std::size_t edge = is_wide ? PlaneWindow::wide : PlaneWindow::narrow, size = edge * edge;
      read<T, is_wide>(window, first_plane, scale, [&](std::size_t k, std::size_t q, VecW row) HWY_ATTR {
        hn::Store(row, words, planes.below + size * k + 32 * q);
      });
    };
    if (window.is_narrow())
      read_of.template operator()<false>();
    else
      read_of.template operator()<true>();
  }

  /// Reads planes of a narrow window, and computes what rays gain between two of them.
  /// @param slope  the rays' largest on the minor axes, at most 1, in parts of 2^15, rounded up
  template <class T>
  HWY_NOINLINE void read_planes_and_rise(const PlaneWindow& window, int first_plane, const WordScale& scale,
                                         const int* slope, MaximumPlanes& planes) const {
    constexpr std::size_t size = PlaneWindow::narrow * PlaneWindow::narrow;
    const std::size_t count = 2 * static_cast<std::size_t>(window.bricks[1]);
    VecS along_u[size / 32], along_v[size / 32], before = hn::Zero(shorts);
    for (std::size_t q = 0; q < count; ++q) along_u[q] = along_v[q] = hn::Zero(shorts);
    read<T, false>(window, first_plane, scale, [&](std::size_t k, std::size_t q, VecW row) HWY_ATTR {
      hn::Store(row, words, planes.below + size * k + 32 * q);
      const VecS here = hn::BitCast(shorts, row);
      const auto add = [](VecS& most, VecS further, VecS from)
                           HWY_ATTR { most = hn::Max(most, hn::Abs(hn::Sub(further, from))); };
      add(along_u[q], next(here), here);
      if (q > 0) add(along_v[q - 1], between(before, here), before);
      if (q + 1 == count) add(along_v[q], between(here, here), here);
      before = here;
    });
    put_rise(along_u, along_v, count, slope, planes.rise);
  }

  /// Reads planes in pairs.
  template <class T>
  HWY_NOINLINE void read_layers(const PlaneWindow& window, int first_plane, const WordScale& scale,
                                MaximumLayers& layers) const {
    if (window.is_narrow())
      read_layers_of<T, false>(window, first_plane, scale, layers);
    else
      read_layers_of<T, true>(window, first_plane, scale, layers);
  }

 private:
  /// The sample of a plane of the mirrored lattice, clamped to the volume.
  HWY_INLINE int sample_of(int i, int plane) const {
    const int sample = static_cast<int>(lattice_.plane(axes_[i], plane)), last = field_.source.count[axes_[i]] - 1;
    return sample < 0 ? 0 : sample > last ? last : sample;
  }
  /// The first sample of the brick that begins there in the mirrored lattice.
  HWY_INLINE int brick_of(int i, int plane) const {
    const int sample = static_cast<int>(lattice_.plane(axes_[i], plane)) & ~3;
    const int last = (field_.source.count[axes_[i]] - 1) & ~3;
    return sample < 0 ? 0 : sample > last ? last : sample;
  }

  template <class T, bool is_wide>
  HWY_INLINE void read_layers_of(const PlaneWindow& window, int first_plane, const WordScale& scale,
                                 MaximumLayers& layers) const {
    constexpr std::size_t edge = is_wide ? PlaneWindow::wide : PlaneWindow::narrow, size = edge * edge;
    VecW near[size / 32];
    const VecW low = hn::LoadU(words, in_turns[0].data()), high = hn::LoadU(words, in_turns[1].data());
    read<T, is_wide>(window, first_plane, scale, [&](std::size_t k, std::size_t q, VecW far) HWY_ATTR {
      if (k != 0) {
        std::int32_t* const layer = layers.below + size * (k - 1) + 32 * q;
        hn::Store(hn::BitCast(ints, look_up(near[q], far, low)), ints, layer);
        hn::Store(hn::BitCast(ints, look_up(near[q], far, high)), ints, layer + float_lanes);
      }
      near[q] = far;
    });
  }

  /// Calls act(index of the plane, index of the vector in it, words). A vector is two rows of a
  /// narrow window or one of a wide one.
  template <class T, bool is_wide, class Act>
  HWY_INLINE void read(const PlaneWindow& window, int first_plane, const WordScale& scale, const Act& act) const {
    constexpr int most = (is_wide ? PlaneWindow::wide : PlaneWindow::narrow) / 4;
    const std::uint64_t* const address[3] = {field_.source.address[axes_[0]], field_.source.address[axes_[1]],
                                             field_.source.address[axes_[2]]};
    std::uint64_t at_u[most], at_v[most];
    for (int i = 0; i < most; ++i) {
      at_u[i] = address[1][brick_of(1, window.first[0] + 4 * (i < window.bricks[0] ? i : 0))];
      at_v[i] = address[2][brick_of(2, window.first[1] + 4 * (i < window.bricks[1] ? i : 0))];
    }
    const int step_w = 1 << 2 * axes_[0];
    const VecW in_brick = hn::Load(words, in_brick_.data());
    for (int k = 0; k < MaximumPlanes::planes; ++k) {
      const int sample = sample_of(0, first_plane + k);
      const VecW at = hn::Add(in_brick, hn::Set(words, static_cast<std::uint16_t>((sample & 3) * step_w)));
      const T* const from = static_cast<const T*>(field_.source.samples) + address[0][sample & ~3];
      std::size_t q = 0;
      const auto put = [&](VecW row) HWY_ATTR { act(static_cast<std::size_t>(k), q++, row); };
      for (int j = 0; j < window.bricks[1]; ++j) {
        VecW rows[2];
        read_row<T>(from + at_v[j], at_u, at, scale, rows);
        if constexpr (is_wide) {
          VecW further[2] = {rows[0], rows[1]};
          if (window.bricks[0] > 4) read_row<T>(from + at_v[j], at_u + 4, at, scale, further);
          for (int i = 0; i < 2; ++i) {
            put(hn::ConcatLowerLower(words, further[i], rows[i]));
            put(hn::ConcatUpperUpper(words, further[i], rows[i]));
          }
        } else {
          put(rows[0]), put(rows[1]);
        }
      }
    }
  }

  /// Reads four rows of 16 samples from four adjacent bricks.
  template <class T>
  HWY_INLINE static void read_row(const T* from, const std::uint64_t* at_u, VecW at, const WordScale& scale,
                                  VecW* rows) {
    __m512i square[4];
    for (int i = 0; i < 4; ++i) {
      const T* const brick = from + at_u[i];
      square[i] = look_up(load_words(words, brick), load_words(words, brick + 32), at).raw;
    }
    const VecW low{_mm512_inserti64x4(square[0], _mm512_castsi512_si256(square[1]), 1)};
    const VecW high{_mm512_inserti64x4(square[2], _mm512_castsi512_si256(square[3]), 1)};
    const VecW top = hn::Set(words, static_cast<std::uint16_t>(scale.highest));
    for (std::size_t i = 0; i < 2; ++i) {
      const VecW below = hn::Sub(top, look_up(low, high, hn::LoadU(words, rows_of_squares[i].data())));
      rows[i] = scale.shift < 0 ? hn::ShiftRight<1>(below)
                                : VecW{_mm512_sll_epi16(below.raw, _mm_cvtsi32_si128(scale.shift))};
    }
  }

  /// Sources of the words of two rows of 16, in adjacent squares of 4 x 4.
  static constexpr auto rows_of_squares = [] {
    std::array<std::array<std::uint16_t, 32>, 2> places{};
    for (std::size_t i = 0; i < 64; ++i) {
      const std::size_t x = i % 16, y = i / 16;
      places[y / 2][i % 32] = static_cast<std::uint16_t>(x / 4 * 16 + y * 4 + x % 4);
    }
    return places;
  }();

  /// Words of two consecutive vectors, starting in the middle of the first.
  HWY_INLINE static VecS between(VecS low, VecS high) { return VecS{_mm512_alignr_epi64(high.raw, low.raw, 4)}; }
  /// The next word, and the last one, on the axis u.
  HWY_INLINE static VecS next(VecS x) {
    return VecS{_mm512_permutexvar_epi16(hn::Load(words, next_word.data()).raw, x.raw)};
  }
  HWY_INLINE static VecS last(VecS x) {
    return VecS{_mm512_permutexvar_epi16(hn::Load(words, last_word.data()).raw, x.raw)};
  }
  alignas(64) static constexpr auto next_word = [] {
    std::array<std::uint16_t, 32> places{};
    for (std::size_t i = 0; i < 32; ++i) places[i] = static_cast<std::uint16_t>((i + 1) % 32);
    return places;
  }();
  alignas(64) static constexpr auto last_word = [] {
    std::array<std::uint16_t, 32> places{};
    for (std::size_t i = 0; i < 32; ++i) places[i] = static_cast<std::uint16_t>((i + 31) % 32);
    return places;
  }();

  /// Computes the most that values rise along a ray near a plane. In its plane a ray passes the
  /// cell where it is and the neighbouring ones, on its way from the plane before or to the next
  /// one: on each axis it moves by less than a cell. There a value changes by no more than the
  /// largest difference of neighbouring samples on each axis, times how far the ray moves on it.
  /// @param u, v  those differences, at the index of their lower sample
  HWY_INLINE static void put_rise(VecS* u, VecS* v, std::size_t count, const int* slope, std::uint16_t* rise) {
    const VecS slope_u = hn::Set(shorts, static_cast<std::int16_t>(slope[0])),
               slope_v = hn::Set(shorts, static_cast<std::int16_t>(slope[1]));
    // For u, the differences of three cells in a row, and of four rows; for v, those of four
    // samples in a row, and of three rows.
    for (std::size_t q = 0; q < count; ++q) {
      u[q] = hn::Max(u[q], hn::Max(next(u[q]), last(u[q])));
      const VecS pair = hn::Max(v[q], next(v[q]));
      v[q] = hn::Max(last(pair), next(pair));
    }
    VecS above_u = u[0], above_v = v[0];
    for (std::size_t q = 0; q < count; ++q) {
      const std::size_t beyond = q + 1 < count ? q + 1 : q;
      const VecS next_u = between(u[q], u[beyond]), next_v = between(v[q], v[beyond]);
      // Rows: the one before and this one, the next two.
      const VecS four = hn::Max(hn::Max(between(above_u, u[q]), u[q]), hn::Max(next_u, u[beyond]));
      const VecS three = hn::Max(hn::Max(between(above_v, v[q]), v[q]), next_v);
      above_u = u[q], above_v = v[q];
      const VecS sum = hn::Add(hn::ShiftRight<2>(hn::MulFixedPoint15(four, slope_u)),
                               hn::ShiftRight<2>(hn::MulFixedPoint15(three, slope_v)));
      hn::Store(hn::BitCast(words, sum), words, rise + 32 * q);
    }
  }

  /// Words of two vectors, interleaved.
  static constexpr auto in_turns = [] {
    std::array<std::array<std::uint16_t, 32>, 2> places{};
    for (std::size_t i = 0; i < 64; ++i) places[i / 32][i % 32] = static_cast<std::uint16_t>(i / 2 + i % 2 * 32);
    return places;
  }();

  const MaximumField& field_;
  const MirroredLattice& lattice_;
  int axes_[3];
  HWY_ALIGN std::array<std::uint16_t, 32> in_brick_{};
};

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
