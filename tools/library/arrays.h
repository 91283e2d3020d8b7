#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "formats/file_description.h"
#include "rhoray/array_view.h"
#include "rhoray/types.h"

namespace rhoray::v0_1::inside {

std::string text_of(std::span<const std::int64_t> shape);  ///< "[3, 4]"

/// The same type in packed files.
constexpr formats::ElementType inside_of(ElementType type) {
  return static_cast<formats::ElementType>(type);
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

/// Refuses an array that is not F32 or F64, or whose shape is not [rows, columns] (columns 0:
/// [rows]).
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
