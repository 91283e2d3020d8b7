#include "preprocess/import/vtk/legacy_vtk.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>

#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/vtk/legacy_vtk_numbers.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// Decodes a name: VTK writes characters that would split a word as %20.
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
  explicit Parser(const ForeignFile& file) : file_(file), numbers_(file), reader_(numbers_.words) {}

  LegacyVtk read() {
    header();
    while (!reader_.at_end()) section(in_capitals(reader_.word("a keyword")));
    return std::move(result_);
  }

 private:
  void header() {
    version(reader_.line());
    reader_.line();  // any title
    const std::string mode = in_capitals(reader_.word("ASCII or BINARY"));
    if (mode != "ASCII" && mode != "BINARY") reader_.refuse(in_quotes(mode), "ASCII or BINARY");
    numbers_.are_binary = mode == "BINARY";
    if (in_capitals(reader_.word("DATASET")) != "DATASET") reader_.refuse("another word", "DATASET");
    result_.dataset = in_capitals(reader_.word("a kind of data set"));
    static const std::set<std::string> known{"STRUCTURED_POINTS", "RECTILINEAR_GRID", "STRUCTURED_GRID",
                                             "UNSTRUCTURED_GRID", "POLYDATA"};
    if (!known.contains(result_.dataset))
      reader_.refuse(in_quotes(result_.dataset),
                     "STRUCTURED_POINTS, RECTILINEAR_GRID, STRUCTURED_GRID, UNSTRUCTURED_GRID or POLYDATA",
                     ErrorCode::unsupported);
  }

  /// Reads `# vtk DataFile Version 4.2`.
  void version(std::string_view line) {
    constexpr std::string_view beginning = "# vtk DataFile Version";
    if (!line.starts_with(beginning)) refuse_input(file_.path(), "line 1", "another beginning", beginning);
    const std::string_view text = line.substr(std::min(line.find_first_not_of(" \t", beginning.size()), line.size()));
    const std::size_t point = std::min(text.find('.'), text.size());
    const std::string_view minor = text.substr(std::min(point + 1, text.size()));
    result_.version_major = parse_number<int>(text.substr(0, point)).value_or(0);
    result_.version_minor = parse_number<int>(minor.substr(0, minor.find_first_of(" \t\r"))).value_or(0);
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
    else if (keyword == "BLANKING")
      blanking();
    else if (keyword == "CELLS")
      cells(result_.cells);
    else if (keyword == "POLYGONS")
      cells(result_.polygons);
    else if (keyword == "TRIANGLE_STRIPS")
      cells(result_.strips);
    else if (keyword == "VERTICES" || keyword == "LINES")
      thin_cells();
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
    const ElementType type = numbers_.type();
    const Array<std::byte> raw = numbers_.values(type, number, 3, "points");
    result_.points.resize(number);
    copy_as_doubles(type, raw, result_.points.empty() ? nullptr : result_.points.front().data());
  }

  void coordinates(std::size_t axis) {
    const std::uint64_t number = count("a number of coordinates");
    const ElementType type = numbers_.type();
    const Array<std::byte> raw = numbers_.values(type, number, 1, "coordinates");
    result_.coordinates[axis].resize(number);
    copy_as_doubles(type, raw, result_.coordinates[axis].data());
    if (type != ElementType::F64) result_.coordinate_precision = 0x1p-23;
  }

  /// Files before version 4: one byte per point, 0 if the point is hidden.
  void blanking() {
    const std::uint64_t number = count("a number of points");
    const ElementType type = numbers_.type();
    if (type != ElementType::U8) reader_.refuse("another type", "unsigned_char");
    for (const std::byte visible : numbers_.values(type, number, 1, "blanking"))
      result_.cells.point_ghosts.push_back(visible == std::byte{0} ? ghost_hidden_point : std::uint8_t{0});
  }

  void cells(ForeignCells& to) {
    const std::uint64_t first = count("a number of cells"), second = count("a number of corners");
    if (in_capitals(reader_.peek()) == "OFFSETS")
      offsets_and_corners(to, first, second);
    else
      counted_corners(to, first, second);
  }

  void thin_cells() {
    ForeignCells passed_over;
    cells(passed_over);
    result_.thin_cell_count += passed_over.offsets.empty() ? 0 : passed_over.offsets.size() - 1;
  }

  /// Version 5.1: OFFSETS type, numbers, CONNECTIVITY type, numbers.
  void offsets_and_corners(ForeignCells& to, std::uint64_t offset_count, std::uint64_t corner_count) {
    reader_.word("OFFSETS");
    to.offsets = numbers_.whole_numbers(numbers_.index_type(), offset_count, "offsets of cells");
    if (in_capitals(reader_.word("CONNECTIVITY")) != "CONNECTIVITY") reader_.refuse("another word", "CONNECTIVITY");
    to.nodes = numbers_.whole_numbers(numbers_.index_type(), corner_count, "corners of cells");
  }

  /// Earlier versions: for each cell the number of corners, then the corners.
  void counted_corners(ForeignCells& to, std::uint64_t cell_count, std::uint64_t number_count) {
    const Array<std::uint64_t> numbers = numbers_.whole_numbers(ElementType::I32, number_count, "corners of cells");
    to.offsets = {0};
    std::uint64_t at = 0;
    for (std::uint64_t cell = 0; cell < cell_count; ++cell) {
      if (at == number_count || numbers[at] > number_count - at - 1)
        refuse_input(file_.path(), concat("cell ", cell), "more corners than CELLS says", "counts that fit");
      const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(at + 1);
      to.nodes.insert(to.nodes.end(), begin, begin + static_cast<std::ptrdiff_t>(numbers[at]));
      to.offsets.push_back(to.nodes.size());
      at += 1 + numbers[at];
    }
    if (at != number_count)
      refuse_input(file_.path(), "CELLS", concat(at, " numbers in ", cell_count, " cells"), concat(number_count));
  }

  void cell_kinds() {
    const std::uint64_t number = count("a number of cells");
    for (const std::uint64_t kind : numbers_.whole_numbers(ElementType::I32, number, "kinds of cells")) {
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
    if (keyword == "LOOKUP_TABLE") {  // colours are skipped
      reader_.word("a name");
      numbers_.values(numbers_.are_binary ? ElementType::U8 : ElementType::F32, count("a number of colours"), 4,
                      "colours");
      return;
    }
    const bool is_texture = keyword == "TEXTURE_COORDINATES";
    const auto found = component_counts.find(keyword);
    if (!is_texture && found == component_counts.end())
      reader_.refuse(in_quotes(keyword), "a keyword of point or cell data");
    const std::string name = decoded(reader_.word("a name"));
    const int components = is_texture ? component_count("a number of components") : found->second;
    add(name, numbers_.type(), components);
  }

  void scalars() {
    const std::string name = decoded(reader_.word("a name"));
    const ElementType type = numbers_.type();
    int components = 1;
    if (parse_number<int>(reader_.peek())) components = component_count("a number of components");
    if (in_capitals(reader_.peek()) == "LOOKUP_TABLE") {
      reader_.word("LOOKUP_TABLE");
      reader_.word("a table's name");
    }
    add(name, type, components);
  }

  /// Bytes. VTK stores unsigned chars this way, in text as fractions of 255.
  void color_scalars() {
    const std::string name = decoded(reader_.word("a name"));
    const int components = component_count("a number of components");
    if (numbers_.are_binary) return add(name, ElementType::U8, components);
    const Array<std::byte> fractions = numbers_.values(ElementType::F32, *owners_, components, name);
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
      const ElementType type = numbers_.type();
      if (!owners_) {  // belongs to the whole file
        numbers_.values(type, tuples, components, name);
        metadata_has_owner_ = false;
        continue;
      }
      if (tuples != *owners_)
        refuse_input(file_.path(), concat("array '", name, "'"), concat(tuples, " tuples"), concat(*owners_));
      add(name, type, components);
    }
  }

  /// VTK's metadata of the preceding array, up to an empty line; contains its unit.
  void skip_metadata() {
    reader_.line();
    bool is_unit = false;
    while (reader_.bytes_left() > 0) {
      const std::string_view line = reader_.line();
      if (line.empty()) break;
      if (is_unit && line.starts_with("DATA ") && metadata_has_owner_)
        result_.arrays.back().unit = decoded(line.substr(5));
      is_unit = line.starts_with("NAME UNITS_LABEL ");
    }
    metadata_has_owner_ = false;
  }

  void add(const std::string& name, ElementType type, int components) {
    add(name, type, components, numbers_.values(type, *owners_, components, name));
  }

  void add(const std::string& name, ElementType type, int components, Array<std::byte> numbers) {
    result_.arrays.push_back({.name = name,
                              .type = type,
                              .component_count = components,
                              .in_cells = in_cells_,
                              .unit = {},
                              .values = std::move(numbers)});
    metadata_has_owner_ = true;
  }

  const ForeignFile& file_;
  LegacyVtkNumbers numbers_;
  WordReader& reader_;
  std::optional<std::uint64_t> owners_;  ///< count after POINT_DATA or CELL_DATA
  bool in_cells_ = false;
  bool metadata_has_owner_ = false;  ///< the last array that was read was kept
  LegacyVtk result_;
};

}  // namespace

LegacyVtk read_legacy_vtk(const std::filesystem::path& path) {
  const ForeignFile file(path);
  return Parser(file).read();
}

}  // namespace rhoray::preprocess
