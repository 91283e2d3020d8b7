#include "formats/envelope/header.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "formats/base/bytes.h"
#include "formats/base/checks.h"
#include "formats/envelope/seal.h"
#include "formats/format_error.h"

namespace rhoray::formats::envelope {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "packed files are little-endian and used in place");

constexpr std::array all_types{ElementType::U8,  ElementType::I8,  ElementType::U16, ElementType::I16,
                               ElementType::U32, ElementType::I32, ElementType::U64, ElementType::I64,
                               ElementType::F32, ElementType::F64};

/// Features that a file may require of its reader: the last since version 1.2, the others since
/// 1.1.
constexpr std::array<std::string_view, 3> known_features{"axis-tables", "sparse-bricks", "cell-clusters"};

bool has_control_character(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

bool is_padding(std::string_view name) {
  return name.starts_with("_pad.");
}

std::optional<ElementType> type_named(std::string_view name) {
  for (const ElementType type : all_types)
    if (element_name(type) == name) return type;
  return std::nullopt;
}

std::optional<std::uint64_t> bytes_in(ElementType type, const std::vector<std::uint64_t>& shape) {
  std::optional<std::uint64_t> bytes = element_bytes(type);
  for (const std::uint64_t size : shape)
    if (bytes) bytes = checked_product({*bytes, size});
  return bytes;
}

/// Receives the events of the JSON parser and accepts only
///     { "__metadata__": {text: text, ...},
///       name: {"dtype": text, "shape": [n, ...], "data_offsets": [n, n]}, ... }
/// Anything else stops the parser at once, so the text itself bounds depth and memory.
class Listener final : public nlohmann::json_sax<json> {
 public:
  struct Array {
    std::string name;
    std::optional<std::string> type;
    std::optional<std::vector<std::uint64_t>> shape, offsets;
  };

  std::map<std::string, std::string> metadata;
  std::vector<Array> arrays;
  std::string complaint_place, complaint_found, complaint_expected;

  bool null() override { return unexpected("null"); }
  bool boolean(bool value) override { return unexpected(value ? "true" : "false"); }
  bool number_integer(number_integer_t value) override { return unexpected(concat(value)); }
  bool number_float(number_float_t, const string_t& text) override { return unexpected(text); }
  bool binary(binary_t&) override { return unexpected("binary data"); }

  bool number_unsigned(number_unsigned_t value) override {
    if (numbers_ == nullptr) return unexpected(concat(value));
    const std::size_t largest = numbers_is_shape_ ? largest_rank : 2;
    if (numbers_->size() == largest) return complain(place(), "one number more", concat("at most ", largest));
    numbers_->push_back(value);
    return true;
  }

  bool string(string_t& value) override {
    if (level_ == 2 && in_metadata_) {
      metadata[key_] = value;
      return true;
    }
    if (level_ == 2 && key_ == "dtype") {
      arrays.back().type = value;
      return true;
    }
    return unexpected(concat('"', value.substr(0, 40), '"'));
  }

  bool start_object(std::size_t) override {
    if (level_ >= 2 || numbers_ != nullptr) return unexpected("an object");
    ++level_;
    return true;
  }
  bool end_object() override {
    --level_;
    return true;
  }

  bool key(string_t& value) override {
    if (level_ == 1) return start_member(value);
    key_ = value;
    if (in_metadata_) {
      if (metadata.contains(value)) return complain("header, __metadata__", concat("'", value, "' twice"), "it once");
      return true;
    }
    const Array& array = arrays.back();
    const bool known = value == "dtype" || value == "shape" || value == "data_offsets";
    if (!known) return complain(place(), "a key of that name", "dtype, shape and data_offsets");
    if ((value == "dtype" && array.type) || (value == "shape" && array.shape) ||
        (value == "data_offsets" && array.offsets))
      return complain(place(), "the key twice", "it once");
    return true;
  }

  bool start_array(std::size_t) override {
    if (level_ != 2 || in_metadata_ || numbers_ != nullptr || key_ == "dtype") return unexpected("a list");
    numbers_is_shape_ = key_ == "shape";
    numbers_ = &(numbers_is_shape_ ? arrays.back().shape : arrays.back().offsets).emplace();
    return true;
  }
  bool end_array() override {
    numbers_ = nullptr;
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception&) override {
    return complain(concat("byte ", length_bytes + position), "text that is not JSON", "the header's JSON");
  }

 private:
  bool start_member(const std::string& name) {
    in_metadata_ = name == "__metadata__";
    key_.clear();
    if (!names_.insert(name).second)
      return complain("header", concat("array '", name.substr(0, largest_name_bytes), "' twice"), "it once");
    if (in_metadata_) return true;
    if (name.empty() || name.size() > largest_name_bytes || has_control_character(name))
      return complain("header", concat("a name of ", name.size(), " bytes"),
                      concat("1 to ", largest_name_bytes, " bytes without control characters"));
    if (arrays.size() == largest_array_count)
      return complain("header", "one array more", concat("at most ", largest_array_count));
    arrays.push_back({.name = name, .type = {}, .shape = {}, .offsets = {}});
    return true;
  }

  std::string place() const {
    if (level_ < 2) return "header";
    return concat("header, ", in_metadata_ ? "__metadata__" : concat("array '", arrays.back().name, "'"),
                  key_.empty() ? "" : concat(", ", key_.substr(0, 40)));
  }
  bool unexpected(const std::string& found) {
    const std::string_view expected = level_ < 2        ? "an object"
                                      : in_metadata_    ? "a text"
                                      : key_ == "dtype" ? "the name of an element type"
                                      : numbers_        ? "unsigned integers below 2^64"
                                                        : "a list of unsigned integers";
    return complain(place(), found, expected);
  }
  bool complain(const std::string& where, std::string found, std::string_view expected) {
    complaint_place = where;
    complaint_found = std::move(found);
    complaint_expected = expected;
    return false;
  }

  int level_ = 0;
  bool in_metadata_ = false;
  bool numbers_is_shape_ = false;
  std::string key_;
  std::set<std::string> names_;
  std::vector<std::uint64_t>* numbers_ = nullptr;
};

ArrayEntry to_entry(std::string_view file, const Listener::Array& array) {
  const std::string place = concat("header, array '", array.name, "'");
  if (!array.type || !array.shape || !array.offsets || array.offsets->size() != 2)
    refuse(file, place, "an incomplete entry", "dtype, shape and two data_offsets");
  const std::optional<ElementType> type = type_named(*array.type);
  if (!type)
    refuse(file, place, concat("dtype '", array.type->substr(0, 40), "'"), "U8 I8 U16 I16 U32 I32 U64 I64 F32 F64",
           ErrorCode::unsupported);

  const std::uint64_t first = array.offsets->front(), last = array.offsets->back();
  if (first > last) refuse(file, place, concat("data_offsets [", first, ",", last, "]"), "them not to fall");
  const std::optional<std::uint64_t> bytes = bytes_in(*type, *array.shape);
  if (!bytes || *bytes != last - first)
    refuse(file, place, concat(last - first, " bytes"),
           bytes ? concat(*bytes, " for its shape") : "a shape whose size fits 64 bits");
  return {.name = array.name, .type = *type, .shape = *array.shape, .first_byte = first, .byte_count = *bytes};
}

/// Checks that every byte of the data area belongs to exactly one array, and that the envelope's
/// arrays come last.
void check_layout(std::string_view file, const std::vector<ArrayEntry>& arrays, std::uint64_t data_bytes) {
  std::uint64_t end = 0;
  for (const ArrayEntry& array : arrays) {
    const std::string place = concat("header, array '", array.name, "'");
    if (array.first_byte != end)
      refuse(file, place, concat("its start at ", array.first_byte),
             concat("it at ", end, ", where the last one ends"));
    if (array.byte_count > data_bytes - end)
      refuse(file, place, concat("its end at ", end + array.byte_count),
             concat("it within the data area of ", data_bytes, " bytes"));
    if (!is_padding(array.name) && array.name != seal_name && array.first_byte % small_alignment != 0)
      refuse(file, place, concat("its start at ", array.first_byte), concat("a multiple of ", small_alignment));
    end += array.byte_count;
  }
  if (end != data_bytes) refuse(file, "header", concat("arrays of ", end, " bytes"), concat(data_bytes, " bytes"));

  const std::size_t count = arrays.size();
  if (count < 2 || arrays[count - 2].name != sums_name || arrays[count - 1].name != seal_name)
    refuse(file, "header", "other arrays at the end", "_sum and _seal");
  const ArrayEntry& sums = arrays[count - 2];
  const std::vector<std::uint64_t> sums_shape{block_count(sums.first_byte)};
  if (sums.type != ElementType::U64 || sums.shape != sums_shape)
    refuse(file, "header, array '_sum'", "another type or shape", concat("U64 [", sums_shape.front(), "]"));
  const ArrayEntry& seal = arrays[count - 1];
  if (seal.type != ElementType::U8 || seal.shape != std::vector<std::uint64_t>{seal_bytes})
    refuse(file, "header, array '_seal'", "another type or shape", "U8 [64]");
}

const std::string& metadata_text(std::string_view file, const Listener& heard, const std::string& key) {
  const auto found = heard.metadata.find(key);
  if (found == heard.metadata.end()) refuse(file, concat("header, __metadata__, ", key), "nothing", "a text");
  return found->second;
}

/// The minor number of "major.minor" with major 1. A larger minor version only adds arrays and keys
/// that this reader may ignore.
int checked_minor_version(std::string_view file, std::string_view text) {
  const auto is_number = [](std::string_view part) {
    return !part.empty() && part.size() <= 4 && part.find_first_not_of("0123456789") == std::string_view::npos;
  };
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos || !is_number(text.substr(0, dot)) || !is_number(text.substr(dot + 1)))
    refuse(file, "header, __metadata__, version", concat("'", text.substr(0, 40), "'"), "two numbers such as 1.0");
  if (text.substr(0, dot) != major_version)
    refuse(file, "header, __metadata__, version", text, "1.x; a newer program may read it", ErrorCode::unsupported);
  int minor = 0;
  std::from_chars(text.data() + dot + 1, text.data() + text.size(), minor);
  return minor;
}

std::vector<std::string> split_features(std::string_view text) {
  std::vector<std::string> features;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    features.emplace_back(text.substr(0, comma));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return features;
}

/// A JSON string; bytes that are not UTF-8 (names from old files) become the replacement character.
std::string json_string(std::string_view text) {
  return json(std::string(text)).dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string number_list(const std::vector<std::uint64_t>& numbers) {
  std::string text = "[";
  for (const std::uint64_t number : numbers) text += concat(text.size() > 1 ? "," : "", number);
  return text + "]";
}

}  // namespace

Header read_header(std::string_view file, std::string_view text, std::uint64_t data_bytes) {
  if (has_control_character(text)) refuse(file, "header", "a control character", "JSON and spaces only");
  Listener heard;
  if (!json::sax_parse(text.begin(), text.end(), &heard))
    refuse(file, heard.complaint_place, heard.complaint_found, heard.complaint_expected);

  Header header;
  header.version = metadata_text(file, heard, "version");
  header.description.minor_version = checked_minor_version(file, header.version);
  header.description.kind = metadata_text(file, heard, "kind");
  header.description.details = metadata_text(file, heard, "details");
  header.description.required = split_features(metadata_text(file, heard, "requires"));
  for (const std::string& feature : header.description.required)
    if (std::find(known_features.begin(), known_features.end(), feature) == known_features.end())
      refuse(file, "header, __metadata__, requires", concat("the feature '", feature.substr(0, 80), "'"),
             "axis-tables, sparse-bricks or cell-clusters; a newer program may know more", ErrorCode::unsupported);

  for (const Listener::Array& array : heard.arrays) header.arrays.push_back(to_entry(file, array));
  check_layout(file, header.arrays, data_bytes);
  return header;
}

std::vector<ArrayEntry> place_arrays(std::string_view file, const std::vector<ArraySpec>& arrays) {
  // Far below 2^64, so that padding, checksums and seal can be added without an overflow check.
  constexpr std::uint64_t largest_file = std::uint64_t{1} << 62;
  std::vector<ArrayEntry> placed;
  std::set<std::string> names;
  std::uint64_t end = 0;
  int pads = 0;
  const auto append = [&](std::string name, ElementType type, std::vector<std::uint64_t> shape, std::uint64_t bytes) {
    placed.push_back({std::move(name), type, std::move(shape), end, bytes});
    end += bytes;
  };
  const auto align = [&](std::uint64_t alignment) {
    const std::uint64_t pad = round_up(end, alignment) - end;
    if (pad != 0) append(concat("_pad.", pads++), ElementType::U8, {pad}, pad);
  };
  for (const ArraySpec& array : arrays) {
    RHORAY_CHECK(array.alignment == small_alignment || array.alignment == page_bytes);
    RHORAY_CHECK(array.shape.size() <= largest_rank);
    RHORAY_CHECK(!array.name.empty() && array.name.size() <= largest_name_bytes && array.name.front() != '_');
    RHORAY_CHECK(!has_control_character(array.name) && names.insert(array.name).second);
    const std::optional<std::uint64_t> bytes = bytes_in(array.type, array.shape);
    if (!bytes || *bytes > largest_file - end)
      throw Error(ErrorCode::usage, concat(file, ": array '", array.name, "' makes the file larger than 2^62 bytes"));
    align(array.alignment);
    append(array.name, array.type, array.shape, *bytes);
  }
  align(small_alignment);
  const std::uint64_t blocks = block_count(end);
  append(std::string(sums_name), ElementType::U64, {blocks}, blocks * sizeof(std::uint64_t));
  append(std::string(seal_name), ElementType::U8, {seal_bytes}, seal_bytes);
  return placed;
}

std::string write_header(std::string_view file, const FileDescription& description,
                         const std::vector<ArrayEntry>& arrays) {
  std::string required;
  for (const std::string& feature : description.required) {
    RHORAY_CHECK(!feature.empty() && feature.find(',') == std::string::npos);
    required += concat(required.empty() ? "" : ",", feature);
  }
  std::string text =
      concat(start_text, R"(,"version":)", json_string(concat(major_version, ".", description.minor_version)),
             R"(,"requires":)", json_string(required), R"(,"kind":)", json_string(description.kind), R"(,"details":)",
             json_string(description.details), "}");
  for (const ArrayEntry& array : arrays)
    text += concat(",", json_string(array.name), R"(:{"dtype":")", element_name(array.type), R"(","shape":)",
                   number_list(array.shape), R"(,"data_offsets":)",
                   number_list({array.first_byte, array.first_byte + array.byte_count}), "}");
  text += "}";

  const std::uint64_t bytes = round_up(length_bytes + text.size(), page_bytes);
  if (bytes > largest_header_bytes || arrays.size() > largest_array_count)
    throw Error(ErrorCode::usage,
                concat(file, ": the header would take ", bytes, " bytes for ", arrays.size(), " arrays; at most ",
                       largest_header_bytes, " bytes and ", largest_array_count, " arrays are allowed"),
                "pack fewer fields into one file");
  const std::uint64_t text_bytes = bytes - length_bytes;
  text.resize(text_bytes, ' ');
  std::string header(length_bytes, '\0');
  std::memcpy(header.data(), &text_bytes, length_bytes);
  return header + text;
}

}  // namespace rhoray::formats::envelope
