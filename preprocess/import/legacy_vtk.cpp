#include "preprocess/import/legacy_vtk.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "formats/base/bytes.h"
#include "preprocess/import/families.h"
#include "preprocess/import/text_reading.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

std::string in_capitals(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](char letter) { return static_cast<char>(std::toupper(static_cast<unsigned char>(letter))); });
  return result;
}

/// VTK writes bytes of names that would split a word as %20.
std::string decoded(std::string_view name) {
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    unsigned code = 0;
    if (name[i] == '%' && i + 2 < name.size() &&
        std::from_chars(name.data() + i + 1, name.data() + i + 3, code, 16).ptr == name.data() + i + 3) {
      result += static_cast<char>(code);
      i += 2;
    } else {
      result += name[i];
    }
  }
  return result;
}

class Parser {
 public:
  explicit Parser(const ForeignFile& file) : file_(file), reader_(file) {}

  LegacyVtk read() {
    header();
    while (!reader_.at_end()) section(in_capitals(reader_.word("a keyword")));
    return std::move(result_);
  }

 private:
  void header() {
    if (!reader_.line().starts_with("# vtk DataFile Version"))
      refuse_input(file_.path(), "line 1", "another beginning", "# vtk DataFile Version");
    reader_.line();  // a title of any kind
    const std::string mode = in_capitals(reader_.word("ASCII or BINARY"));
    if (mode != "ASCII" && mode != "BINARY") reader_.refuse(in_quotes(mode), "ASCII or BINARY");
    binary_ = mode == "BINARY";
    if (in_capitals(reader_.word("DATASET")) != "DATASET") reader_.refuse("another word", "DATASET");
    result_.dataset = in_capitals(reader_.word("a kind of data set"));
    if (result_.dataset != "STRUCTURED_POINTS" && result_.dataset != "RECTILINEAR_GRID" &&
        result_.dataset != "UNSTRUCTURED_GRID")
      reader_.refuse(in_quotes(result_.dataset), "STRUCTURED_POINTS, RECTILINEAR_GRID or UNSTRUCTURED_GRID",
                     Trouble::unsupported);
  }

  void section(const std::string& keyword) {
    if (keyword == "DIMENSIONS")
      dimensions();
    else if (keyword == "SPACING" || keyword == "ASPECT_RATIO")
      result_.spacing = three_reals("three spacings");
    else if (keyword == "ORIGIN")
      result_.origin = three_reals("an origin");
    else if (keyword == "X_COORDINATES" || keyword == "Y_COORDINATES" || keyword == "Z_COORDINATES")
      coordinates(static_cast<std::size_t>(keyword[0] - 'X'));
    else if (keyword == "POINTS")
      points();
    else if (keyword == "CELLS")
      cells();
    else if (keyword == "CELL_TYPES")
      cell_kinds();
    else if (keyword == "POINT_DATA")
      begin_data(false);
    else if (keyword == "CELL_DATA")
      begin_data(true);
    else if (keyword == "FIELD")
      field_arrays();
    else if (keyword == "METADATA")
      skip_metadata();
    else if (owners_)
      attribute(keyword);
    else
      reader_.refuse(in_quotes(keyword), "a keyword of " + result_.dataset);
  }

  Vec3 three_reals(std::string_view what) {
    const auto x = reader_.number<double>(what), y = reader_.number<double>(what), z = reader_.number<double>(what);
    return {x, y, z};
  }

  void dimensions() {
    for (int axis = 0; axis < 3; ++axis) result_.dimensions[axis] = reader_.number<std::int64_t>("three sizes");
  }

  std::uint64_t count(std::string_view what) { return reader_.number<std::uint64_t>(what); }

  void points() {
    const std::uint64_t number = count("a number of points");
    const ElementType type = element_type(reader_.word("a type"));
    const Array<std::byte> raw = values(type, number, 3, "points");
    result_.points.resize(number);
    copy_as_doubles(type, raw, result_.points.empty() ? nullptr : result_.points.front().data());
  }

  void coordinates(std::size_t axis) {
    const std::uint64_t number = count("a number of coordinates");
    const ElementType type = element_type(reader_.word("a type"));
    const Array<std::byte> raw = values(type, number, 1, "coordinates");
    result_.coordinates[axis].resize(number);
    copy_as_doubles(type, raw, result_.coordinates[axis].data());
    if (type != ElementType::F64) result_.coordinate_precision = 0x1p-23;
  }

  static void copy_as_doubles(ElementType type, std::span<const std::byte> raw, double* to) {
    formats::with_element_type(type, [&]<class T>(T) {
      for (std::size_t at = 0; at < raw.size(); at += sizeof(T)) {
        T value;
        std::memcpy(&value, raw.data() + at, sizeof value);
        *to++ = static_cast<double>(value);
      }
    });
  }

  Array<std::uint64_t> whole_numbers(ElementType type, std::uint64_t number, std::string_view what) {
    const Array<std::byte> raw = values(type, number, 1, what);
    Array<std::uint64_t> result(number);
    for (std::size_t i = 0; i < number; ++i) {
      std::int64_t wide = 0;
      std::int32_t narrow = 0;
      if (type == ElementType::I64)
        std::memcpy(&wide, raw.data() + i * sizeof wide, sizeof wide);
      else
        std::memcpy(&narrow, raw.data() + i * sizeof narrow, sizeof narrow);
      result[i] = static_cast<std::uint64_t>(wide + narrow);  // a negative one becomes too large and is refused later
    }
    return result;
  }

  ElementType index_type() {
    const ElementType type = element_type(reader_.word("a type"));
    if (type != ElementType::I64 && type != ElementType::I32) reader_.refuse("another type", "int or vtktypeint64");
    return type;
  }

  void cells() {
    const std::uint64_t first = count("a number of cells"), second = count("a number of corners");
    if (in_capitals(reader_.peek()) == "OFFSETS")
      offsets_and_corners(first, second);
    else
      counted_corners(first, second);
  }

  /// Version 5.1: OFFSETS type, numbers, CONNECTIVITY type, numbers.
  void offsets_and_corners(std::uint64_t offset_count, std::uint64_t corner_count) {
    reader_.word("OFFSETS");
    result_.cells.offsets = whole_numbers(index_type(), offset_count, "offsets of cells");
    if (in_capitals(reader_.word("CONNECTIVITY")) != "CONNECTIVITY") reader_.refuse("another word", "CONNECTIVITY");
    result_.cells.nodes = whole_numbers(index_type(), corner_count, "corners of cells");
  }

  /// Before: for each cell the number of corners, then the corners.
  void counted_corners(std::uint64_t cell_count, std::uint64_t number_count) {
    const Array<std::uint64_t> numbers = whole_numbers(ElementType::I32, number_count, "corners of cells");
    ForeignCells& cells = result_.cells;
    cells.offsets = {0};
    std::uint64_t at = 0;
    for (std::uint64_t cell = 0; cell < cell_count; ++cell) {
      if (at == number_count || numbers[at] > number_count - at - 1)
        refuse_input(file_.path(), concat("cell ", cell), "more corners than CELLS says", "counts that fit");
      const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(at + 1);
      cells.nodes.insert(cells.nodes.end(), begin, begin + static_cast<std::ptrdiff_t>(numbers[at]));
      cells.offsets.push_back(cells.nodes.size());
      at += 1 + numbers[at];
    }
    if (at != number_count)
      refuse_input(file_.path(), "CELLS", concat(at, " numbers in ", cell_count, " cells"), concat(number_count));
  }

  void cell_kinds() {
    const std::uint64_t number = count("a number of cells");
    for (const std::uint64_t kind : whole_numbers(ElementType::I32, number, "kinds of cells")) {
      if (kind > 255) refuse_input(file_.path(), "CELL_TYPES", concat(kind), "0 to 255");
      result_.cells.kinds.push_back(static_cast<std::uint8_t>(kind));
    }
  }

  void begin_data(bool in_cells) {
    owners_ = count("a number of values");
    in_cells_ = in_cells;
    (in_cells ? result_.cell_data_count : result_.point_data_count) = *owners_;
  }

  void attribute(const std::string& keyword) {
    static const std::map<std::string, int> component_counts{{"VECTORS", 3},    {"NORMALS", 3},    {"TENSORS", 9},
                                                             {"TENSORS6", 6},   {"GLOBAL_IDS", 1}, {"PEDIGREE_IDS", 1},
                                                             {"EDGE_FLAGS", 1}, {"GHOST_TYPES", 1}};
    if (keyword == "SCALARS") return scalars();
    if (keyword == "COLOR_SCALARS") return color_scalars();
    if (keyword == "LOOKUP_TABLE") {  // colours: passed over
      reader_.word("a name");
      values(binary_ ? ElementType::U8 : ElementType::F32, count("a number of colours"), 4, "colours");
      return;
    }
    const bool is_texture = keyword == "TEXTURE_COORDINATES";
    const auto found = component_counts.find(keyword);
    if (!is_texture && found == component_counts.end())
      reader_.refuse(in_quotes(keyword), "a keyword of point or cell data");
    const std::string name = decoded(reader_.word("a name"));
    const int components = is_texture ? component_count("a number of components") : found->second;
    add(name, element_type(reader_.word("a type")), components);
  }

  void scalars() {
    const std::string name = decoded(reader_.word("a name"));
    const ElementType type = element_type(reader_.word("a type"));
    int components = 1;
    if (parse_number<int>(reader_.peek())) components = component_count("a number of components");
    if (in_capitals(reader_.peek()) == "LOOKUP_TABLE") {
      reader_.word("LOOKUP_TABLE");
      reader_.word("a table's name");
    }
    add(name, type, components);
  }

  /// Bytes; VTK writes unsigned chars so, and in text as fractions of 255.
  void color_scalars() {
    const std::string name = decoded(reader_.word("a name"));
    const int components = component_count("a number of components");
    if (binary_) return add(name, ElementType::U8, components);
    const Array<std::byte> fractions = values(ElementType::F32, *owners_, components, name);
    Array<std::byte> bytes(fractions.size() / sizeof(float));
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      float fraction;
      std::memcpy(&fraction, fractions.data() + i * sizeof fraction, sizeof fraction);
      if (!(fraction >= 0 && fraction <= 1)) reader_.refuse(concat(fraction), "fractions, 0 to 1");
      bytes[i] = static_cast<std::byte>(std::lround(255 * fraction));
    }
    add(name, ElementType::U8, components, std::move(bytes));
  }

  int component_count(std::string_view what) {
    const int components = reader_.number<int>(what);
    if (components < 1 || components > 1024) reader_.refuse(concat(components), "1 to 1024 components");
    return components;
  }

  void field_arrays() {
    reader_.word("a name");
    for (std::uint64_t left = count("a number of arrays"); left > 0; --left) {
      if (in_capitals(reader_.peek()) == "METADATA") {
        reader_.word("METADATA");
        skip_metadata();
      }
      const std::string name = decoded(reader_.word("an array's name"));
      const int components = component_count("a number of components");
      const std::uint64_t tuples = count("a number of tuples");
      const ElementType type = element_type(reader_.word("a type"));
      if (!owners_) {  // belongs to the file as a whole
        values(type, tuples, components, name);
        continue;
      }
      if (tuples != *owners_)
        refuse_input(file_.path(), concat("array '", name, "'"), concat(tuples, " tuples"), concat(*owners_));
      add(name, type, components);
    }
  }

  /// Notes of VTK about the array before, ended by an empty line.
  void skip_metadata() {
    reader_.line();
    while (reader_.bytes_left() > 0 && !reader_.line().empty()) {
    }
  }

  void add(const std::string& name, ElementType type, int components) {
    add(name, type, components, values(type, *owners_, components, name));
  }

  void add(const std::string& name, ElementType type, int components, Array<std::byte> numbers) {
    GridArray array{
        .name = name, .type = type, .component_count = components, .in_cells = in_cells_, .owned = {}, .values = {}};
    array.owned = std::move(numbers);
    array.values = array.owned;
    result_.arrays.push_back(std::move(array));
  }

  ElementType element_type(std::string_view word) {
    static const std::map<std::string, ElementType> types{
        {"UNSIGNED_CHAR", ElementType::U8},  {"CHAR", ElementType::I8},
        {"SIGNED_CHAR", ElementType::I8},    {"UNSIGNED_SHORT", ElementType::U16},
        {"SHORT", ElementType::I16},         {"UNSIGNED_INT", ElementType::U32},
        {"INT", ElementType::I32},           {"VTKIDTYPE", ElementType::I32},
        {"UNSIGNED_LONG", ElementType::U64}, {"LONG", ElementType::I64},
        {"VTKTYPEINT64", ElementType::I64},  {"VTKTYPEUINT64", ElementType::U64},
        {"FLOAT", ElementType::F32},         {"DOUBLE", ElementType::F64}};
    const auto found = types.find(in_capitals(word));
    if (found == types.end())
      reader_.refuse(in_quotes(word), "a type of numbers, unsigned_char to double", Trouble::unsupported);
    return found->second;
  }

  /// Numbers in native order. Binary ones begin after the end of the line and are big-endian.
  Array<std::byte> values(ElementType type, std::uint64_t tuples, int components, std::string_view what) {
    const std::size_t size = formats::element_bytes(type);
    const std::optional<std::uint64_t> number = checked_product({tuples, static_cast<std::uint64_t>(components)});
    // Text needs two bytes for each number but the last, binary its size: so nothing is allocated for absurd counts.
    const std::uint64_t least = binary_ ? size : 2;
    if (!number || *number > reader_.bytes_left() / least + 1)
      reader_.refuse(concat(reader_.bytes_left(), " bytes left in the file"),
                     concat(tuples, " x ", components, " numbers of ", what));
    if (binary_) {
      if (*number == 0) return {};
      reader_.line();
      const std::span<const std::byte> raw = reader_.bytes(*number * size, what);
      Array<std::byte> result(raw.begin(), raw.end());
      make_native(result, size, true);
      return result;
    }
    Array<std::byte> result(*number * size);
    formats::with_element_type(type, [&]<class T>(T) {
      for (std::size_t i = 0; i < *number; ++i) {
        const T value = reader_.number<T>(what);
        std::memcpy(result.data() + i * sizeof value, &value, sizeof value);
      }
    });
    return result;
  }

  const ForeignFile& file_;
  WordReader reader_;
  bool binary_ = false;
  std::optional<std::uint64_t> owners_;  ///< after POINT_DATA or CELL_DATA: how many
  bool in_cells_ = false;
  LegacyVtk result_;
};

NeutralField field_of(const GridArray& array) {
  NeutralField field;
  field.name = array.name;
  field.component_count = array.component_count;
  formats::with_element_type(array.type, [&]<class T>(T) {
    field.values.resize(array.values.size() / sizeof(T));
    for (std::size_t i = 0; i < field.values.size(); ++i) {
      T value;
      std::memcpy(&value, array.values.data() + i * sizeof value, sizeof value);
      field.values[i] = static_cast<double>(value);
    }
  });
  field.was_single_precision = array.type != ElementType::F64 && fits_single_precision(field.values);
  return field;
}

}  // namespace

LegacyVtk read_legacy_vtk(const std::filesystem::path& path) {
  const ForeignFile file(path);
  return Parser(file).read();
}

CellMesh read_legacy_vtk_mesh(const std::filesystem::path& path) {
  LegacyVtk parts = read_legacy_vtk(path);
  if (parts.dataset != "UNSTRUCTURED_GRID")
    refuse_input(path, "DATASET", parts.dataset, "UNSTRUCTURED_GRID", Trouble::unsupported);
  CellMesh mesh;
  mesh.points = std::move(parts.points);
  for (const GridArray& array : parts.arrays)
    (array.in_cells ? mesh.cell_fields : mesh.point_fields).push_back(field_of(array));
  if (parts.cells.offsets.empty()) parts.cells.offsets = {0};
  take_cells(mesh, std::move(parts.cells), path);
  return mesh;
}

NeutralVolume read_legacy_vtk_volume(const std::filesystem::path& path, const std::string& field) {
  LegacyVtk parts = read_legacy_vtk(path);
  if (parts.dataset != "STRUCTURED_POINTS" && parts.dataset != "RECTILINEAR_GRID")
    refuse_input(path, "DATASET", parts.dataset, "STRUCTURED_POINTS or RECTILINEAR_GRID", Trouble::unsupported);
  PointGrid grid{parts.dimensions, axis_parallel(parts.spacing, parts.origin)};
  if (parts.dataset == "RECTILINEAR_GRID") {
    grid = rectilinear_grid(path, parts.coordinates, parts.coordinate_precision);
    if (grid.point_count != parts.dimensions)
      refuse_input(path, "DIMENSIONS", concat(parts.dimensions.x, " x ", parts.dimensions.y, " x ", parts.dimensions.z),
                   concat(grid.point_count.x, " x ", grid.point_count.y, " x ", grid.point_count.z,
                          ", as many as there are coordinates"));
  }
  return volume_of_field(path, grid, std::move(parts.arrays), field);
}

}  // namespace rhoray::preprocess
