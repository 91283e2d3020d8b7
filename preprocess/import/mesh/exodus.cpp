// Exodus II, a convention that defines dimensions and variables of netCDF files.
// Source: Schoof and Yarberry, "EXODUS II: A Finite Element Data Model", SAND92-2137, and the node
// numberings of its successor's manual (SEACAS).

#include <algorithm>
#include <cctype>
#include <limits>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/mesh/netcdf_file.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/label_names.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/reading/time_steps.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// An element type. `beginning` is the start of its name; the rest repeats the node count or
/// describes its use. `order` is the file's index of each VTK node; empty means that both orders
/// are the same.
struct ElementType {
  std::string_view beginning;
  std::uint64_t node_count;
  CellKind kind;
  std::vector<std::uint8_t> order;
};

// Edges of hexahedra and wedges: the file's order is lower, upright, upper; VTK's order is lower,
// upper, upright.
const ElementType element_types[] = {
    {"TET", 4, CellKind::tetrahedron, {}},
    {"TET", 10, CellKind::quadratic_tetrahedron, {}},
    {"TET", 14, CellKind::quadratic_tetrahedron_14, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 13, 11, 12, 10}},
    {"HEX", 8, CellKind::hexahedron, {}},
    {"HEX", 20, CellKind::quadratic_hexahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
    // File: centre, below, above, left, right, front, back. VTK: left, right, front, back, below,
    // above, centre.
    {"HEX", 27, CellKind::triquadratic_hexahedron, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                                                    18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22, 20}},
    {"WED", 6, CellKind::wedge, {}},
    {"WED", 12, CellKind::quadratic_linear_wedge, {}},
    {"WED", 15, CellKind::quadratic_wedge, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
    {"WED", 18, CellKind::biquadratic_quadratic_wedge, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17}},
    {"PYR", 5, CellKind::pyramid, {}},
    {"PYR", 13, CellKind::quadratic_pyramid, {}},
    {"PYR", 14, CellKind::quadratic_pyramid_14, {}},
};

/// Types that do not fill space, with VTK's number of their kind.
struct FlatType {
  std::string_view beginning;
  std::uint8_t kind;
};
constexpr FlatType flat_types[] = {{"SPH", 1}, {"CIR", 1}, {"POI", 1}, {"NOD", 1}, {"BAR", 3},
                                   {"BEA", 3}, {"TRU", 3}, {"ROD", 3}, {"EDG", 3}, {"LIN", 3},
                                   {"SPR", 3}, {"TRI", 5}, {"NSI", 7}, {"QUA", 9}, {"SHE", 9}};
constexpr std::uint8_t triangle = 5;

struct Block {
  std::uint64_t first = 0;  ///< index of its first element among those of all blocks
  std::uint64_t count = 0;
};

class ExodusReader {
 public:
  ExodusReader(const std::filesystem::path& path, const std::string& time) : file_(path), time_(time) {}

  CellMesh read() {
    if (!file_.dimension("num_el_blk"))
      refuse_input(file_.path(), "dimensions", "no 'num_el_blk'", "one, as Exodus II files have");
    read_points();
    read_blocks();
    read_fields();
    take_cells(mesh_, std::move(cells_), file_.path());
    return std::move(mesh_);
  }

 private:
  void read_points() {
    const std::uint64_t count = file_.dimension("num_nodes").value_or(0), axes = file_.dimension("num_dim").value_or(3);
    if (count == 0 || axes != 3)
      refuse_input(file_.path(), "dimensions", concat(count, " points in ", axes, " dimensions"),
                   "points in 3 dimensions");
    const auto together = file_.variable("coord");
    Array<double> all;
    if (together) all = written_numbers(*together, std::array{axes, count});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!together) all = written_numbers(file_.need_variable(concat("coord", "xyz"[axis])), std::array{count});
      mesh_.points.resize(count);
      const std::size_t first = together ? axis * count : 0;
      for (std::size_t i = 0; i < count; ++i) mesh_.points[i][axis] = all[first + i];
    }
  }

  /// Like NetcdfFile::numbers, with NaN where nothing was written.
  Array<double> written_numbers(const NetcdfFile::Variable& variable, std::span<const std::uint64_t> shape) const {
    Array<double> numbers = file_.numbers(variable, shape);
    std::replace(numbers.begin(), numbers.end(), file_.fill_value(variable), std::numeric_limits<double>::quiet_NaN());
    return numbers;
  }

  void read_blocks() {
    const std::uint64_t count = *file_.dimension("num_el_blk");
    const Array<std::int64_t> ids = file_.integers(file_.need_variable("eb_prop1"), std::array{count});
    cells_.offsets = {0};
    Array<double> block_of_cell;
    for (std::uint64_t i = 0; i < count; ++i) {
      blocks_.push_back({.first = cells_.kinds.size(), .count = 0});
      const auto connect = file_.variable(concat("connect", i + 1));
      // a block without elements has no such variable
      if (!connect || connect->shape.empty()) continue;
      read_block(*connect, i + 1, ids[i]);
      blocks_.back().count = cells_.kinds.size() - blocks_.back().first;
      block_of_cell.resize(cells_.kinds.size(), static_cast<double>(ids[i]));
    }
    mesh_.cell_fields.push_back(field_of("block", std::move(block_of_cell)));
    GivenNames names;
    for (const std::string& name : names_of("eb_names"))
      if (names.size() < ids.size()) names.emplace_back(ids[names.size()], name);
    mesh_.cell_fields.back().label_names = label_names_from(names, mesh_.notes);
  }

  /// @param number  number of the block, from 1, as used in names; its id may differ
  void read_block(const NetcdfFile::Variable& connect, std::uint64_t number, std::int64_t id) {
    const std::string name = file_.text_attribute(connect, "elem_type");
    const Array<std::int64_t> nodes = file_.integers(connect, connect.shape);
    // polygons: all corners in one row
    const std::uint64_t each = connect.shape.size() == 2 ? connect.shape[1] : 0;
    const std::uint64_t count =
        each == 0 ? file_.dimension(concat("num_el_in_blk", number)).value_or(0) : connect.shape[0];
    std::string beginning = in_capitals(name).substr(0, 3);
    if (beginning == "PRI") beginning = "WED";  // prisms are wedges
    const auto type = std::find_if(std::begin(element_types), std::end(element_types), [&](const ElementType& row) {
      return row.beginning == beginning && row.node_count == each;
    });
    if (type != std::end(element_types)) return add_elements(*type, nodes, count);
    const auto flat = std::find_if(std::begin(flat_types), std::end(flat_types),
                                   [&](const FlatType& row) { return row.beginning == beginning; });
    if (flat == std::end(flat_types) || count > nodes.size())
      refuse_input(file_.path(), concat("block ", id), concat(count, " elements '", name, "' of ", each, " nodes"),
                   "tetrahedra (4, 10, 14), hexahedra (8, 20, 27), wedges (6, 12, 15, 18), pyramids (5, 13, 14)",
                   ErrorCode::unsupported);
    const bool is_shell_of_three = flat->beginning == "SHE" && (each == 3 || each == 6);
    cells_.kinds.resize(cells_.kinds.size() + count, is_shell_of_three ? triangle : flat->kind);
    // left out, whatever their nodes are
    cells_.offsets.resize(cells_.offsets.size() + count, cells_.nodes.size());
  }

  void add_elements(const ElementType& type, const Array<std::int64_t>& nodes, std::uint64_t count) {
    cells_.nodes.reserve(cells_.nodes.size() + nodes.size());
    for (std::uint64_t element = 0; element < count; ++element) {
      const std::int64_t* from = nodes.data() + element * type.node_count;
      // counts from 1; a 0 wraps to a huge number and is refused
      for (std::uint64_t i = 0; i < type.node_count; ++i)
        cells_.nodes.push_back(static_cast<std::uint64_t>(from[type.order.empty() ? i : type.order[i]]) - 1);
      cells_.offsets.push_back(cells_.nodes.size());
      cells_.kinds.push_back(static_cast<std::uint8_t>(type.kind));
    }
  }

  void read_fields() {
    const std::vector<std::string> at_points = names_of("name_nod_var"), in_cells = names_of("name_elem_var");
    const std::uint64_t steps = file_.dimension("time_step").value_or(0);
    if (steps == 0) {
      refuse_time_step(time_, file_.path());
      if (!at_points.empty() || !in_cells.empty()) mesh_.notes.push_back("fields left out: they have no time steps");
      return;
    }
    const Array<double> times = written_numbers(file_.need_variable("time_whole"), std::array{steps});
    step_ = choose_time_step(times, time_, file_.path(), mesh_.notes);
    for (std::size_t i = 0; i < at_points.size(); i += point_field(at_points, i)) {
    }
    if (!in_cells.empty()) read_truth(in_cells.size());
    for (std::size_t i = 0; i < in_cells.size(); i += cell_field(in_cells, i)) {
    }
  }

  std::vector<std::string> names_of(const std::string& name) const {
    const auto variable = file_.variable(name);
    return variable ? file_.texts(*variable) : std::vector<std::string>();
  }

  /// Name of the vector whose three components start at name i ("V_X", "V_Y", "V_Z" or "Vx", "Vy",
  /// "Vz"); empty when there is none.
  static std::string vector_name(const std::vector<std::string>& names, std::size_t i) {
    if (i + 3 > names.size()) return {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string& name = names[i + axis];
      if (name.size() < 2 ||
          name.back() != (std::islower(static_cast<unsigned char>(names[i].back())) ? "xyz" : "XYZ")[axis] ||
          name.substr(0, name.size() - 1) != names[i].substr(0, names[i].size() - 1))
        return {};
    }
    const std::string stem = names[i].substr(0, names[i].size() - 1);
    return stem.ends_with('_') ? stem.substr(0, stem.size() - 1) : stem;
  }

  NeutralField new_field(const std::vector<std::string>& names, std::size_t i, std::uint64_t owners) const {
    NeutralField field;
    field.name = vector_name(names, i);
    field.component_count = field.name.empty() ? 1 : 3;
    if (field.name.empty()) field.name = names[i];
    field.values.assign(owners * static_cast<std::uint64_t>(field.component_count),
                        std::numeric_limits<double>::quiet_NaN());
    return field;
  }

  /// A component of the values of a field, from an owner on.
  struct Target {
    std::size_t owner, component;
  };

  /// Leaves NaN where nothing was written, which the fill value says. Returns how many those are.
  static std::uint64_t put_values(NeutralField& field, const Target& target, std::span<const double> values,
                                  double fill_value) {
    const auto width = static_cast<std::size_t>(field.component_count);
    std::uint64_t unwritten = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] == fill_value)
        ++unwritten;
      else
        field.values[(target.owner + i) * width + target.component] = values[i];
    return unwritten;
  }

  void note_unwritten(const NeutralField& field, std::uint64_t count) {
    if (count > 0)
      mesh_.notes.push_back(
          concat("field '", field.name, "': ", count_text(count, "value was", "values were"), " never written"));
  }

  /// Adds the field that starts at name i, and returns the number of names it used.
  std::size_t point_field(const std::vector<std::string>& names, std::size_t i) {
    const std::uint64_t owners = mesh_.points.size();
    NeutralField field = new_field(names, i, owners);
    const auto width = static_cast<std::size_t>(field.component_count);
    bool is_double = false;
    std::uint64_t unwritten = 0;
    // small old files store all variables in one array
    const auto together = file_.variable("vals_nod_var");
    Array<double> all;
    if (together) all = file_.numbers(*together, std::array{std::uint64_t{names.size()}, owners}, step_);
    for (std::size_t c = 0; c < width; ++c) {
      const auto own = together ? together : file_.variable(concat("vals_nod_var", i + c + 1));
      if (!own) continue;  // never written: no data
      if (!together) all = file_.numbers(*own, std::array{owners}, step_);
      is_double = is_double || NetcdfFile::is_double_precision(*own);
      const auto values = std::span(all).subspan(together ? (i + c) * owners : 0, owners);
      unwritten += put_values(field, {.owner = 0, .component = c}, values, file_.fill_value(*own));
    }
    note_unwritten(field, unwritten);
    if (in_capitals(field.name).starts_with("DISPL"))
      mesh_.notes.push_back(concat("points are not displaced by field '", field.name, "'"));
    field.was_single_precision = !is_double || fits_single_precision(field.values);
    mesh_.point_fields.push_back(std::move(field));
    return width;
  }

  void read_truth(std::uint64_t variable_count) {
    const auto table = file_.variable("elem_var_tab");
    variable_count_ = variable_count;
    if (table) truth_ = file_.integers(*table, std::array{std::uint64_t{blocks_.size()}, variable_count});
  }

  /// Like point_field. Blocks that lack the variable have no data: NaN.
  std::size_t cell_field(const std::vector<std::string>& names, std::size_t i) {
    NeutralField field = new_field(names, i, cells_.kinds.size());
    const auto width = static_cast<std::size_t>(field.component_count);
    bool is_double = false;
    std::uint64_t unwritten = 0;
    for (std::size_t c = 0; c < width; ++c)
      for (std::size_t b = 0; b < blocks_.size(); ++b) {
        const Block& block = blocks_[b];
        if (block.count == 0 || (!truth_.empty() && truth_[b * variable_count_ + i + c] == 0)) continue;
        const auto variable = file_.variable(concat("vals_elem_var", i + c + 1, "eb", b + 1));
        if (!variable) continue;
        is_double = is_double || NetcdfFile::is_double_precision(*variable);
        const Array<double> values = file_.numbers(*variable, std::array{block.count}, step_);
        unwritten += put_values(field, {.owner = block.first, .component = c}, values, file_.fill_value(*variable));
      }
    note_unwritten(field, unwritten);
    field.was_single_precision = !is_double || fits_single_precision(field.values);
    mesh_.cell_fields.push_back(std::move(field));
    return width;
  }

  NetcdfFile file_;
  std::string time_;
  CellMesh mesh_;
  ForeignCells cells_;
  std::vector<Block> blocks_;
  std::uint64_t step_ = 0;
  std::uint64_t variable_count_ = 0;
  /// per block and variable, whether it has values there; empty: everywhere
  Array<std::int64_t> truth_;
};

}  // namespace

CellMesh read_exodus(const std::filesystem::path& path, const std::string& time) {
  return ExodusReader(path, time).read();
}

}  // namespace rhoray::preprocess
