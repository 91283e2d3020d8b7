#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import_volume.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

struct TypeName {
  std::string_view name;
  ElementType type;
};
constexpr TypeName type_names[] = {
    {"uint8", ElementType::U8},   {"int8", ElementType::I8},     {"uint16", ElementType::U16},
    {"int16", ElementType::I16},  {"uint32", ElementType::U32},  {"int32", ElementType::I32},
    {"uint64", ElementType::U64}, {"int64", ElementType::I64},   {"float32", ElementType::F32},
    {"float", ElementType::F32},  {"float64", ElementType::F64}, {"double", ElementType::F64},
};

[[noreturn]] void refuse_part(const std::string& text, std::string_view part, std::string_view expected) {
  throw Error(ErrorCode::usage, concat("raw volume '", text, "': found '", part, "'; expected ", expected),
              "use NXxNYxNZ:TYPE[:le|be][:SKIP], for example 256x256x128:uint16:le");
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

Index3 sizes_in(const std::string& text, std::string_view part) {
  const std::vector<std::string_view> words = split(part, 'x');
  if (words.size() != 3) refuse_part(text, part, "three sizes, NXxNYxNZ");
  Index3 sizes;
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<std::int64_t> size = parse_number<std::int64_t>(words[static_cast<std::size_t>(axis)]);
    if (!size || *size < 1) refuse_part(text, words[static_cast<std::size_t>(axis)], "a size of at least 1");
    sizes[axis] = *size;
  }
  return sizes;
}

ElementType type_in(const std::string& text, std::string_view part) {
  std::string names;
  for (const TypeName& row : type_names) {
    if (part == row.name || part == formats::element_name(row.type)) return row.type;
    names += concat(names.empty() ? "" : ", ", row.name);
  }
  refuse_part(text, part, "one of " + names);
}

}  // namespace

RawVolume parse_raw_volume(const std::string& text) {
  const std::vector<std::string_view> parts = split(text, ':');
  RawVolume raw;
  raw.sample_count = sizes_in(text, parts[0]);
  if (parts.size() < 2) refuse_part(text, "", "a type after the sizes");
  raw.type = type_in(text, parts[1]);
  std::size_t next = 2;
  if (next < parts.size() && (parts[next] == "le" || parts[next] == "be")) raw.big_endian = parts[next++] == "be";
  if (next < parts.size()) {
    const std::optional<std::uint64_t> skipped = parse_number<std::uint64_t>(parts[next]);
    if (!skipped)
      refuse_part(text, parts[next], next == 2 ? "le, be or a number of bytes to skip" : "a number of bytes to skip");
    raw.skipped_bytes = *skipped;
    ++next;
  }
  if (next < parts.size()) refuse_part(text, parts[next], "nothing more");
  return raw;
}

}  // namespace rhoray::preprocess
