#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <type_traits>

#include "rhoray/export.h"

namespace rhoray::RHORAY_ABI {

/// The type of one number: unsigned, signed or floating-point, with its bits.
enum class ElementType : std::uint8_t { U8, I8, U16, I16, U32, I32, U64, I64, F32, F64 };

/// The element type of a C++ type.
template <class T>
constexpr ElementType element_type() {
  static_assert(std::is_floating_point_v<T> || (std::is_integral_v<T> && !std::is_same_v<T, bool>),
                "expected integers or floating-point numbers");
  if constexpr (std::is_floating_point_v<T>) {
    static_assert(sizeof(T) == 4 || sizeof(T) == 8, "expected float or double");
    return sizeof(T) == 4 ? ElementType::F32 : ElementType::F64;
  } else {
    constexpr int pair = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 2 : sizeof(T) == 4 ? 4 : 6;
    return static_cast<ElementType>(pair + (std::is_signed_v<T> ? 1 : 0));
  }
}

/// Numbers of the caller, with up to eight axes, the slowest first, as numpy describes them. It
/// keeps nothing alive: the numbers must outlive the call that takes the view. Nothing may write to
/// them meanwhile.
class RHORAY_API ArrayView {
 public:
  static constexpr std::size_t most_axes = 8;

  /// Stands for an array that is not given.
  ArrayView() = default;

  /// Contiguous values. `shape` must multiply to their number; without a shape there is one axis.
  template <class T>
  ArrayView(std::span<const T> values, std::initializer_list<std::int64_t> shape = {})
      : ArrayView(values.data(), element_type<T>(), values.size(), std::span(shape.begin(), shape.size())) {}

  /// @param first          the element with index 0 on every axis
  /// @param shape          the number of elements of each axis
  /// @param strides_bytes  the distance between neighbours on each axis; may be negative; 0 repeats
  ///                       one value along the axis
  /// Refuses more than eight axes, other numbers of strides than of axes, negative sizes, null with
  /// elements, and more than 2^63 - 1 bytes: of all elements, or between the first and the last.
  ArrayView(const void* first, ElementType type, std::span<const std::int64_t> shape,
            std::span<const std::int64_t> strides_bytes);

  bool is_given() const { return is_given_; }
  const void* first() const { return first_; }
  ElementType type() const { return type_; }
  std::span<const std::int64_t> shape() const { return {shape_.data(), axis_count_}; }
  std::span<const std::int64_t> strides_bytes() const { return {strides_.data(), axis_count_}; }
  std::int64_t count() const;  ///< the number of elements

 private:
  ArrayView(const void* first, ElementType type, std::size_t count, std::span<const std::int64_t> shape);

  const void* first_ = nullptr;
  ElementType type_ = ElementType::F64;
  bool is_given_ = false;
  std::size_t axis_count_ = 0;
  std::array<std::int64_t, most_axes> shape_{}, strides_{};
};

}  // namespace rhoray::RHORAY_ABI
