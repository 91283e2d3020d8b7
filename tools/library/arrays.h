#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "rhoray/array_view.h"
#include "rhoray/types.h"

namespace rhoray::v0_1::inside {

std::size_t element_bytes(ElementType type);
std::string text_of(std::span<const std::int64_t> shape);  ///< "[3, 4]"

/// Calls act(T()) with the C++ type of elements.
template <class Act>
decltype(auto) for_type(ElementType type, Act&& act) {
  switch (type) {
    case ElementType::U8:
      return act(std::uint8_t{});
    case ElementType::I8:
      return act(std::int8_t{});
    case ElementType::U16:
      return act(std::uint16_t{});
    case ElementType::I16:
      return act(std::int16_t{});
    case ElementType::U32:
      return act(std::uint32_t{});
    case ElementType::I32:
      return act(std::int32_t{});
    case ElementType::U64:
      return act(std::uint64_t{});
    case ElementType::I64:
      return act(std::int64_t{});
    case ElementType::F32:
      return act(float{});
    case ElementType::F64:
      break;
  }
  return act(double{});
}

/// The element at an index of up to two axes. The caller has checked type and shape.
template <class T>
T element(const ArrayView& array, std::int64_t row, std::int64_t column = 0) {
  const auto strides = array.strides_bytes();
  const std::byte* const at =
      static_cast<const std::byte*>(array.first()) + row * strides[0] + (strides.size() > 1 ? column * strides[1] : 0);
  T value;
  std::memcpy(&value, at, sizeof(T));  // strides need not keep alignment
  return value;
}

/// Refuses an array that is not F32 or F64, or whose shape is not [rows, columns] (columns 0: [rows]).
/// @param rows  -1: any
/// @param name  of the array, for messages
void require_floats(const ArrayView& array, std::string_view name, std::int64_t rows, std::int64_t columns);

/// A component of an array for which require_floats holds.
inline double number(const ArrayView& array, std::int64_t row, std::int64_t column = 0) {
  return array.type() == ElementType::F32 ? static_cast<double>(element<float>(array, row, column))
                                          : element<double>(array, row, column);
}
inline Vec3 vector(const ArrayView& array, std::int64_t row) {
  return {number(array, row, 0), number(array, row, 1), number(array, row, 2)};
}

bool is_finite(const Vec3& v);

}  // namespace rhoray::v0_1::inside
