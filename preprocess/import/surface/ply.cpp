#include <algorithm>
#include <cmath>

#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/surface/surface_building.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

struct Property {
  std::string name;
  ElementType type = ElementType::U8;
  std::optional<ElementType> count_type;  ///< only of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { text, little_endian, big_endian };

/// Words of the header, then the numbers after it in any of the three encodings.
class Ply {
 public:
  explicit Ply(const ForeignFile& file) : reader_(file) {
    if (!file.text().starts_with("ply")) refuse_input(file.path(), "byte 0", "another beginning", "ply");
    read_header();
  }

  const std::vector<Element>& elements() const { return elements_; }

  /// The next number, stored with this type.
  double number(ElementType type, std::string_view what) {
    if (encoding_ == Encoding::text) return reader_.number<double>(what);
    return formats::with_element_type(type, [&]<class T>(T) {
      return static_cast<double>(reader_.binary<T>(what, encoding_ == Encoding::big_endian));
    });
  }

  std::uint64_t whole_number(ElementType type, std::string_view what) {
    const double value = number(type, what);
    if (!(value >= 0 && value < 9e15 && value == std::floor(value))) reader_.refuse(concat(value), what);
    return static_cast<std::uint64_t>(value);
  }

  /// Bytes after the last number; white space after a text does not count.
  std::uint64_t bytes_left() { return encoding_ == Encoding::text && reader_.at_end() ? 0 : reader_.bytes_left(); }

  void skip(const Property& property) {
    const std::uint64_t count = property.count_type ? whole_number(*property.count_type, "a list's length") : 1;
    for (std::uint64_t i = 0; i < count; ++i) number(property.type, property.name);
  }

 private:
  void read_header() {
    reader_.line();
    for (;;) {
      const std::string_view keyword = reader_.word("end_header");
      if (keyword == "end_header") break;
      if (keyword == "format")
        format();
      else if (keyword == "element")
        element();
      else if (keyword == "property")
        property();
      else if (keyword != "comment" && keyword != "obj_info")
        reader_.refuse(keyword, "a keyword of PLY headers");
      reader_.line();
    }
    if (!has_format_)
      reader_.refuse("a header without format", "format ascii, binary_little_endian or binary_big_endian");
    // the end of the end_header line
    if (encoding_ != Encoding::text || reader_.bytes_left() > 0) reader_.line();
  }

  void format() {
    const std::string_view word = reader_.word("an encoding");
    if (word == "ascii")
      encoding_ = Encoding::text;
    else if (word == "binary_little_endian")
      encoding_ = Encoding::little_endian;
    else if (word == "binary_big_endian")
      encoding_ = Encoding::big_endian;
    else
      reader_.refuse(word, "ascii, binary_little_endian or binary_big_endian");
    has_format_ = true;
  }

  void element() {
    Element& element = elements_.emplace_back();
    element.name = reader_.word("an element's name");
    element.count = reader_.number<std::uint64_t>("a number of elements");
    if (element.count > reader_.bytes_left())
      reader_.refuse(concat(element.count, " elements in ", reader_.bytes_left(), " bytes"),
                     "a number that the file can hold");
  }

  void property() {
    if (elements_.empty()) reader_.refuse("a property before any element", "element");
    Property property;
    std::string_view word = reader_.word("a type");
    if (word == "list") {
      property.count_type = type(reader_.word("a type"));
      word = reader_.word("a type");
    }
    property.type = type(word);
    property.name = reader_.word("a property's name");
    elements_.back().properties.push_back(property);
  }

  ElementType type(std::string_view word) {
    static constexpr std::pair<std::string_view, ElementType> types[] = {
        {"char", ElementType::I8},    {"int8", ElementType::I8},     {"uchar", ElementType::U8},
        {"uint8", ElementType::U8},   {"short", ElementType::I16},   {"int16", ElementType::I16},
        {"ushort", ElementType::U16}, {"uint16", ElementType::U16},  {"int", ElementType::I32},
        {"int32", ElementType::I32},  {"uint", ElementType::U32},    {"uint32", ElementType::U32},
        {"float", ElementType::F32},  {"float32", ElementType::F32}, {"double", ElementType::F64},
        {"float64", ElementType::F64}};
    const std::optional<ElementType> found = find_in(types, word);
    if (!found) reader_.refuse(word, "a type, char to double");
    return *found;
  }

  WordReader reader_;
  Encoding encoding_ = Encoding::text;
  bool has_format_ = false;
  std::vector<Element> elements_;
};

void read_points(Ply& ply, const Element& element, NeutralSurface& surface, const std::filesystem::path& path) {
  std::array<std::size_t, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name(1, static_cast<char>('x' + axis));
    const auto found =
        std::find_if(element.properties.begin(), element.properties.end(),
                     [&](const Property& property) { return property.name == name && !property.count_type; });
    if (found == element.properties.end())
      refuse_input(path, "element vertex", concat("no property ", name), "properties x, y and z");
    columns[axis] = static_cast<std::size_t>(found - element.properties.begin());
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    std::array<double, 3>& point = surface.points.emplace_back();
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const auto axis = std::find(columns.begin(), columns.end(), p);
      if (axis == columns.end())
        ply.skip(element.properties[p]);
      else
        point[static_cast<std::size_t>(axis - columns.begin())] =
            ply.number(element.properties[p].type, "a coordinate");
    }
  }
}

void read_facets(Ply& ply, const Element& element, NeutralSurface& surface, const std::filesystem::path& path) {
  const auto holds_corners = [](const Property& property) {
    return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  if (std::none_of(element.properties.begin(), element.properties.end(), holds_corners))
    refuse_input(path, "element face", "no list vertex_indices", "a list of corners");
  Array<std::uint64_t> corners;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      if (!holds_corners(property)) {
        ply.skip(property);
        continue;
      }
      corners.clear();
      const std::uint64_t count = ply.whole_number(*property.count_type, "a number of corners");
      for (std::uint64_t k = 0; k < count; ++k) corners.push_back(ply.whole_number(property.type, "a corner"));
      add_facet(surface, corners, path, concat("face ", i));
    }
  }
}

}  // namespace

NeutralSurface read_ply(const std::filesystem::path& path) {
  const ForeignFile file = unpacked_file(path);
  Ply ply(file);
  NeutralSurface surface;
  for (const Element& element : ply.elements()) {
    if (element.name == "vertex")
      read_points(ply, element, surface, path);
    else if (element.name == "face")
      read_facets(ply, element, surface, path);
    else if (element.name == "tristrips")
      refuse_input(path, "header", "triangle strips", "faces", ErrorCode::unsupported);
    else
      for (std::uint64_t i = 0; i < element.count; ++i)
        for (const Property& property : element.properties) ply.skip(property);
  }
  if (const std::uint64_t rest = ply.bytes_left(); rest > 0)
    surface.notes.push_back(concat(path.filename().string(), ": ", count_text(rest, "byte", "bytes"),
                                   " after the elements ", rest == 1 ? "was" : "were", " left out"));
  finish_surface(surface, path);
  return surface;
}

}  // namespace rhoray::preprocess
