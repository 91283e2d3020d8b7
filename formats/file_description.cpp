#include "formats/file_description.h"

#include "formats/base/read_value.h"

#include <array>

namespace rhoray::formats {

std::size_t element_bytes(ElementType type) {
  return with_element_type(type, [](auto zero) { return sizeof zero; });
}

std::string_view element_name(ElementType type) {
  constexpr std::array<std::string_view, 10> names{"U8", "I8", "U16", "I16", "U32", "I32", "U64", "I64", "F32", "F64"};
  return names[static_cast<std::size_t>(type)];
}

void read_value(const std::string& text, ElementType& out) {
  using enum ElementType;
  static const std::pair<std::string, ElementType> names[] = {
      {"U8", U8},      {"I8", I8},       {"U16", U16},     {"I16", I16},   {"U32", U32},    {"I32", I32},
      {"U64", U64},    {"I64", I64},     {"F32", F32},     {"F64", F64},   {"uint8", U8},   {"int8", I8},
      {"uint16", U16}, {"int16", I16},   {"uint32", U32},  {"int32", I32}, {"uint64", U64}, {"int64", I64},
      {"float", F32},  {"float32", F32}, {"float64", F64}, {"double", F64}};
  for (const auto& [name, type] : names)
    if (text == name) {
      out = type;
      return;
    }
  refuse_value(text, "a type: U8, I8, U16, I16, U32, I32, F32 or F64");
}

std::uint64_t ArrayEntry::element_count() const {
  return byte_count / element_bytes(type);
}

}  // namespace rhoray::formats
