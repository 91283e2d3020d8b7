// Functions that read samples of one type, chosen once per batch.
#if defined(RHORAY_WIDE_READING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_READING_INL_H
#undef RHORAY_WIDE_READING_INL_H
#else
#define RHORAY_WIDE_READING_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "formats/packed_file.h"
#include "render/grid/isosurface/corners-inl.h"
#include "render/grid/isosurface/fetch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Functions that read samples of one type.
struct Reading {
  void (*fetch)(const SampleSource&, const int*, double, BlockSamples&);
  /// Null for types whose values need not fit float.
  void (*fetch_values)(const SampleSource&, const int*, BlockSamples&);
  void (*ask_for)(const SampleSource&, const int*);
  void (*load_corners)(const SampleSource&, const int*, double, std::uint64_t, CornersScratch&);
};

template <class T>
constexpr Reading reading{fetch_block<T>, is_single<T> ? fetch_values<T> : nullptr, ask_for_block<T>, load_corners<T>};

HWY_INLINE Reading reading_of(formats::ElementType type) {
  switch (type) {
    case formats::ElementType::U8:
      return reading<std::uint8_t>;
    case formats::ElementType::I8:
      return reading<std::int8_t>;
    case formats::ElementType::U16:
      return reading<std::uint16_t>;
    case formats::ElementType::I16:
      return reading<std::int16_t>;
    case formats::ElementType::U32:
      return reading<std::uint32_t>;
    case formats::ElementType::I32:
      return reading<std::int32_t>;
    case formats::ElementType::F32:
      return reading<float>;
    default:
      return reading<double>;
  }
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
