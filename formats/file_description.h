#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace rhoray::formats {

/// Element types of arrays, named as in safetensors. Everything is little-endian.
enum class ElementType : std::uint8_t { U8, I8, U16, I16, U32, I32, U64, I64, F32, F64 };

std::size_t element_bytes(ElementType type);
std::string_view element_name(ElementType type);  ///< "U8", "F64", ...
/// Reads U8, uint8, f32, float, ...; refuses other texts (ErrorCode::usage).
void read_value(const std::string& text, ElementType& out);

template <class T>
constexpr ElementType element_type_of();  // below

/// Calls act(T{}) with the C++ type that `type` stands for; returns what act returns.
template <class Act>
decltype(auto) with_element_type(ElementType type, Act&& act);  // below

/// Declaration of one named array, for a writer.
struct ArraySpec {
  std::string name;
  ElementType type = ElementType::U8;
  std::vector<std::uint64_t> shape;  ///< slowest axis first; at most 8 axes
  std::uint64_t alignment = 64;      ///< of the first byte in the file: 64, or 4096 for bricks
};

/// One named array that a reader found.
struct ArrayEntry {
  std::string name;
  ElementType type = ElementType::U8;
  std::vector<std::uint64_t> shape;
  std::uint64_t first_byte = 0;  ///< counted from the start of the file
  std::uint64_t byte_count = 0;

  std::uint64_t element_count() const;
};

/// File-wide information of the header.
struct FileDescription {
  std::string kind;  ///< "grid", "tets", or a neutral kind for data from workers
  /// features that a reader must support; an unknown one is refused by name
  std::vector<std::string> required = {};
  std::string details = "{}";  ///< one JSON text; its meaning depends on the kind
  int minor_version = 0;       ///< of format 1.x: the first version with all features in use
};

// -------------------------------------------------------------------------------------------------

template <class T>
constexpr ElementType element_type_of() {
  if constexpr (std::is_same_v<T, std::uint8_t>)
    return ElementType::U8;
  else if constexpr (std::is_same_v<T, std::int8_t>)
    return ElementType::I8;
  else if constexpr (std::is_same_v<T, std::uint16_t>)
    return ElementType::U16;
  else if constexpr (std::is_same_v<T, std::int16_t>)
    return ElementType::I16;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return ElementType::U32;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return ElementType::I32;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return ElementType::U64;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return ElementType::I64;
  else if constexpr (std::is_same_v<T, float>)
    return ElementType::F32;
  else {
    static_assert(std::is_same_v<T, double>, "not an element type");
    return ElementType::F64;
  }
}

template <class Act>
decltype(auto) with_element_type(ElementType type, Act&& act) {
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

}  // namespace rhoray::formats
