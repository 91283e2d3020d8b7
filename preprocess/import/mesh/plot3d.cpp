#include <algorithm>
#include <optional>

#include "preprocess/import/mesh/mesh_pieces.h"
#include "preprocess/import/mesh/plot3d_layout.h"
#include "preprocess/import/mesh/structured_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

bool has_one_layer(const Plot3dLayout& layout) {
  return std::any_of(layout.blocks.begin(), layout.blocks.end(),
                     [](const Index3& size) { return size[0] < 2 || size[1] < 2 || size[2] < 2; });
}

/// The only layout that fits; if several fit, the only one whose blocks all have cells. Refuses
/// none and several.
Plot3dLayout only_layout(const ForeignFile& file) {
  std::vector<Plot3dLayout> layouts = plot3d_layouts(file);
  if (layouts.size() > 1 && !std::all_of(layouts.begin(), layouts.end(), has_one_layer))
    std::erase_if(layouts, has_one_layer);
  if (layouts.empty())
    refuse_input(file.path(), "size", concat(file.bytes().size(), " bytes that fit no layout of PLOT3D"),
                 "a grid or solution in three dimensions, text or binary, of 32 or 64 bits, with or without block "
                 "count, IBLANK and Fortran records");
  if (layouts.size() > 1) {
    std::string candidates;
    for (const Plot3dLayout& layout : layouts)
      candidates += concat(candidates.empty() ? "" : "; or ", in_words(layout));
    refuse_input(file.path(), "size", concat(layouts.size(), " layouts that fit (", candidates, ")"), "one",
                 ErrorCode::unsupported);
  }
  return layouts.front();
}

/// Reads the numbers after a file's header, array by array.
class Plot3dReader {
 public:
  Plot3dReader(const ForeignFile& file, const Plot3dLayout& layout)
      : bytes_(file.bytes()), layout_(layout), numbers_(file.text()) {
    if (layout.is_text)
      for (std::uint64_t i = 0; i < layout.data_offset; ++i) numbers_.next();
    else
      at_ = layout.data_offset;
  }

  void begin_record() { at_ += layout_.has_records ? 4 : 0; }
  void end_record() { at_ += layout_.has_records ? 4 : 0; }

  Array<double> reals(std::uint64_t count) {
    return layout_.float_bytes == 4 ? binary<float>(count) : binary<double>(count);
  }

  Array<double> integers(std::uint64_t count) { return binary<std::int32_t>(count); }

 private:
  template <class T>
  Array<double> binary(std::uint64_t count) {
    Array<double> values(count);
    if (layout_.is_text) {
      for (double& value : values) value = numbers_.next().value_or(0);  // already counted
      return values;
    }
    const std::span<const std::byte> source = bytes_.subspan(at_, count * sizeof(T));
    Array<std::byte> raw(source.begin(), source.end());
    make_native(raw, sizeof(T), layout_.is_big_endian);
    copy_as_doubles(formats::element_type_of<T>(), raw, values.data());
    at_ += raw.size();
    return values;
  }

  std::span<const std::byte> bytes_;
  const Plot3dLayout& layout_;
  Plot3dNumbers numbers_;
  std::uint64_t at_ = 0;
};

std::uint64_t points_in(const Index3& size) {
  return static_cast<std::uint64_t>(size[0] * size[1] * size[2]);
}

NeutralField flow_field(const char* name, int component_count, Array<double> values, const Plot3dLayout& layout) {
  NeutralField field = field_of(name, std::move(values), component_count);
  field.was_single_precision = field.was_single_precision && (layout.is_text || layout.float_bytes == 4);
  return field;
}

/// Points of a block and, with IBLANK, the field with that name.
CellMesh read_grid_block(Plot3dReader& reader, const Plot3dLayout& layout, const Index3& size) {
  CellMesh mesh;
  mesh.points.resize(points_in(size));
  reader.begin_record();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Array<double> coordinates = reader.reals(mesh.points.size());
    for (std::size_t i = 0; i < coordinates.size(); ++i) mesh.points[i][axis] = coordinates[i];
  }
  if (layout.has_iblank) {
    mesh.point_fields.push_back(field_of("IBlank", reader.integers(mesh.points.size())));
  }
  reader.end_record();
  return mesh;
}

/// IBLANK 0 hides a point. Other numbers describe it (a wall, a fringe) and hide nothing.
Array<std::uint8_t> blanked_points(const CellMesh& mesh) {
  Array<std::uint8_t> ghosts;
  if (mesh.point_fields.empty()) return ghosts;
  for (const double blank : mesh.point_fields.front().values)
    ghosts.push_back(blank == 0 ? ghost_hidden_point : std::uint8_t{0});
  return ghosts;
}

void read_solution_block(Plot3dReader& reader, const Plot3dLayout& layout, CellMesh& mesh) {
  const std::uint64_t count = mesh.points.size();
  reader.begin_record();
  const Array<double> conditions = reader.reals(4);
  reader.end_record();
  mesh.notes.push_back(concat("conditions of the solution, not kept: Mach number ", conditions[0], ", angle of attack ",
                              conditions[1], ", Reynolds number ", conditions[2], ", time ", conditions[3]));
  reader.begin_record();
  mesh.point_fields.push_back(flow_field("Density", 1, reader.reals(count), layout));
  Array<double> momentum(3 * count);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Array<double> component = reader.reals(count);
    for (std::uint64_t i = 0; i < count; ++i) momentum[3 * i + axis] = component[i];
  }
  mesh.point_fields.push_back(flow_field("Momentum", 3, std::move(momentum), layout));
  mesh.point_fields.push_back(flow_field("StagnationEnergy", 1, reader.reals(count), layout));
  reader.end_record();
}

struct OpenFile {
  explicit OpenFile(const fs::path& path) : file(path), layout(only_layout(file)) {}
  ForeignFile file;
  Plot3dLayout layout;
};

/// `name` with the last `from` replaced; nothing if it does not contain `from`.
std::optional<std::string> replaced(std::string name, std::string_view from, std::string_view to) {
  const std::size_t at = name.rfind(from);
  if (at == std::string::npos) return std::nullopt;
  return name.replace(at, from.size(), to);
}

/// Candidate names of the other file of a pair, in the same folder.
std::vector<fs::path> partners_of(const fs::path& path, bool is_solution) {
  const std::string name = path.filename().string(), extension = path.extension().string();
  std::vector<std::string> names;
  const auto add = [&](const std::optional<std::string>& candidate) {
    if (candidate && *candidate != name) names.push_back(*candidate);
  };
  if (is_solution) {
    add(replaced(name, "q", "xyz"));
    for (const char* other : {".xyz", ".x", ".g", ".p3d"}) add(path.stem().string() + other);
  } else {
    add(replaced(name, "xyz", "q"));
    add(path.stem().string() + ".q");
  }
  std::vector<fs::path> paths;
  for (const std::string& candidate : names) paths.push_back(path.parent_path() / candidate);
  return paths;
}

std::optional<OpenFile> partner_of(const OpenFile& given, std::string& looked_for) {
  for (const fs::path& path : partners_of(given.file.path(), given.layout.is_solution)) {
    looked_for += concat(looked_for.empty() ? "" : " or ", path.filename().string());
    if (is_there(path)) return OpenFile(path);
  }
  return std::nullopt;
}

void check_pair(const OpenFile& grid, const OpenFile& solution) {
  const auto must_be = [](const OpenFile& file, bool is_solution, const char* expected) {
    if (file.layout.is_solution != is_solution) refuse_input(file.file.path(), "size", in_words(file.layout), expected);
  };
  must_be(grid, false, "a PLOT3D grid, as the other file is a solution");
  must_be(solution, true, "a PLOT3D solution, as the other file is a grid");
  if (grid.layout.blocks != solution.layout.blocks)
    refuse_input(solution.file.path(), "header", in_words(solution.layout),
                 concat("the sizes of ", in_words(grid.layout), ", as in ", grid.file.path().string()));
}

CellMesh read_blocks(const OpenFile& grid, const OpenFile* solution) {
  Plot3dReader grid_reader(grid.file, grid.layout);
  std::optional<Plot3dReader> solution_reader;
  if (solution != nullptr) solution_reader.emplace(solution->file, solution->layout);
  MeshPieces pieces;
  for (const Index3& size : grid.layout.blocks) {
    CellMesh mesh = read_grid_block(grid_reader, grid.layout, size);
    ForeignCells cells = hexahedra_of_grid(size, mesh.points.size(), grid.file.path());
    cells.point_ghosts = blanked_points(mesh);
    if (solution_reader) read_solution_block(*solution_reader, solution->layout, mesh);
    pieces.add(std::move(mesh), std::move(cells), grid.file.path());
  }
  return pieces.finish(grid.file.path());
}

}  // namespace

CellMesh read_plot3d(const fs::path& path) {
  const OpenFile given(path);
  std::string looked_for;
  const std::optional<OpenFile> partner = partner_of(given, looked_for);
  if (partner) {
    const OpenFile& grid = given.layout.is_solution ? *partner : given;
    const OpenFile& solution = given.layout.is_solution ? given : *partner;
    check_pair(grid, solution);
    return read_blocks(grid, &solution);
  }
  if (given.layout.is_solution)
    refuse_input(path, "PLOT3D solution", "no grid beside it", "its points in " + looked_for, ErrorCode::unreadable);
  CellMesh mesh = read_blocks(given, nullptr);
  mesh.notes.push_back(concat("no solution file found; looked for ", looked_for));
  return mesh;
}

}  // namespace rhoray::preprocess
