#include "formats/file_description.h"

#include <array>

namespace rhoray::formats {

std::size_t element_bytes(ElementType type) {
  return with_element_type(type, [](auto zero) { return sizeof zero; });
}

std::string_view element_name(ElementType type) {
  constexpr std::array<std::string_view, 10> names{"U8", "I8", "U16", "I16", "U32", "I32", "U64", "I64", "F32", "F64"};
  return names[static_cast<std::size_t>(type)];
}

std::uint64_t ArrayEntry::element_count() const {
  return byte_count / element_bytes(type);
}

}  // namespace rhoray::formats
