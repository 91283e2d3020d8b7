#include "preprocess/import/vtk/legacy_vtk_numbers.h"

#include <algorithm>
#include <cstring>
#include <optional>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/samples.h"

namespace rhoray::preprocess {

using formats::ElementType;

ElementType LegacyVtkNumbers::type() {
  const std::string_view word = words.word("a type");
  static constexpr std::pair<std::string_view, ElementType> types[] = {
      {"UNSIGNED_CHAR", ElementType::U8},  {"CHAR", ElementType::I8},
      {"SIGNED_CHAR", ElementType::I8},    {"UNSIGNED_SHORT", ElementType::U16},
      {"SHORT", ElementType::I16},         {"UNSIGNED_INT", ElementType::U32},
      {"INT", ElementType::I32},           {"VTKIDTYPE", ElementType::I32},
      {"UNSIGNED_LONG", ElementType::U64}, {"LONG", ElementType::I64},
      {"VTKTYPEINT64", ElementType::I64},  {"VTKTYPEUINT64", ElementType::U64},
      {"FLOAT", ElementType::F32},         {"DOUBLE", ElementType::F64}};
  const std::optional<ElementType> found = find_in(types, in_capitals(word));
  if (!found) words.refuse(in_quotes(word), "a type of numbers, unsigned_char to double", ErrorCode::unsupported);
  return *found;
}

ElementType LegacyVtkNumbers::index_type() {
  const ElementType found = type();
  if (found != ElementType::I64 && found != ElementType::I32) words.refuse("another type", "int or vtktypeint64");
  return found;
}

Array<std::byte> LegacyVtkNumbers::values(ElementType type, std::uint64_t tuples, int components,
                                          std::string_view what) {
  const std::size_t size = formats::element_bytes(type);
  const std::optional<std::uint64_t> number = checked_product({tuples, static_cast<std::uint64_t>(components)});
  // Text needs two bytes per number except for the last, binary needs its size. So nothing is
  // allocated for absurd counts.
  const std::uint64_t least = are_binary ? size : 2;
  if (!number || *number > words.bytes_left() / least + 1)
    words.refuse(concat(words.bytes_left(), " bytes left in the file"),
                 concat(tuples, " x ", components, " numbers of ", what));
  if (are_binary) {
    if (*number == 0) return {};
    words.line();
    const std::span<const std::byte> raw = words.bytes(*number * size, what);
    Array<std::byte> result(raw.begin(), raw.end());
    make_native(result, size, true);
    return result;
  }
  Array<std::byte> result(*number * size);
  formats::with_element_type(type, [&]<class T>(T) {
    for (std::size_t i = 0; i < *number; ++i) {
      const T value = words.number<T>(what);
      std::memcpy(result.data() + i * sizeof value, &value, sizeof value);
    }
  });
  return result;
}

Array<std::uint64_t> LegacyVtkNumbers::whole_numbers(ElementType type, std::uint64_t number, std::string_view what) {
  const Array<std::byte> raw = values(type, number, 1, what);
  Array<std::uint64_t> result(number);
  for (std::size_t i = 0; i < number; ++i) {
    std::int64_t wide = 0;
    std::int32_t narrow = 0;
    if (type == ElementType::I64)
      std::memcpy(&wide, raw.data() + i * sizeof wide, sizeof wide);
    else
      std::memcpy(&narrow, raw.data() + i * sizeof narrow, sizeof narrow);
    result[i] = static_cast<std::uint64_t>(wide + narrow);
  }
  return result;
}

}  // namespace rhoray::preprocess
