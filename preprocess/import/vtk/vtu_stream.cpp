#include "preprocess/import/vtk/vtu_stream.h"

#include <algorithm>
#include <vector>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/vtk/vtk_xml_stream.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// Contents of a file, before any array is read.
struct Plan {
  std::uint64_t point_count = 0, cell_count = 0;
  VtkXmlArray points, connectivity, offsets, kinds;
  std::vector<VtkXmlArray> at_points, in_cells;
};

bool is_integer(const VtkXmlArray& array) {
  return array.type != ElementType::F32 && array.type != ElementType::F64;
}

/// Ghost cells are left out by VTK's reader.
bool is_ghost(const VtkXmlArray& array) {
  return array.name == "vtkGhostType";
}

bool take_cell_arrays(const VtkXmlStream& file, const XmlElement& cells, Plan& plan) {
  int found = 0;
  for (const XmlElement& element : cells.children) {
    const std::optional<VtkXmlArray> array = file.array(element);
    if (!array) return false;
    for (const auto& [name, place] :
         {std::pair{"connectivity", &plan.connectivity}, {"offsets", &plan.offsets}, {"types", &plan.kinds}})
      if (array->name == name) {
        *place = *array;
        ++found;
      }
  }
  return found == 3 && is_integer(plan.connectivity) && is_integer(plan.offsets) && plan.kinds.type == ElementType::U8;
}

std::optional<Plan> plan_for(const VtkXmlStream& file) {
  const XmlElement& grid = file.data_set();
  const XmlElement* piece = grid.child("Piece");
  const auto is_piece = [](const XmlElement& element) { return element.name == "Piece"; };
  if (grid.name != "UnstructuredGrid" || std::count_if(grid.children.begin(), grid.children.end(), is_piece) != 1)
    return std::nullopt;
  Plan plan;
  const auto points = parse_number<std::uint64_t>(piece->attribute("NumberOfPoints"));
  const auto cells = parse_number<std::uint64_t>(piece->attribute("NumberOfCells"));
  const XmlElement* places = piece->child("Points");
  const XmlElement* corners = piece->child("Cells");
  constexpr std::uint64_t most = std::uint64_t{1} << 48;  // so that no product below overflows
  if (!points || !cells || *points == 0 || *cells == 0 || *points > most || *cells > most || places == nullptr ||
      places->children.size() != 1 || corners == nullptr || !take_cell_arrays(file, *corners, plan))
    return std::nullopt;
  plan.point_count = *points;
  plan.cell_count = *cells;
  const std::optional<VtkXmlArray> array = file.array(places->children.front());
  auto at_points = file.arrays_in(piece->child("PointData")), in_cells = file.arrays_in(piece->child("CellData"));
  if (!array || array->component_count != 3 || !at_points || !in_cells ||
      std::any_of(at_points->begin(), at_points->end(), is_ghost) ||
      std::any_of(in_cells->begin(), in_cells->end(), is_ghost))
    return std::nullopt;
  plan.points = *array;
  plan.at_points = *std::move(at_points);
  plan.in_cells = *std::move(in_cells);
  return plan;
}

bool is_for_vtk(std::uint8_t kind) {
  constexpr auto polyhedron = static_cast<std::uint8_t>(CellKind::polyhedron);
  constexpr std::uint8_t first_lagrange = 68;  // older files order their nodes differently
  return kind == polyhedron || kind >= first_lagrange;
}

NeutralField read_field(const VtkXmlStream& file, const VtkXmlArray& array, std::uint64_t owners,
                        std::vector<std::string>& notes) {
  NeutralField field;
  field.name = array.name;
  field.unit = array.unit;
  field.component_count = array.component_count;
  const std::uint64_t count = owners * static_cast<std::uint64_t>(array.component_count);
  file.check_count(array, count);
  field.values.resize(count);
  file.read(array, std::span(field.values));
  note_precision(field, array.type, notes);
  return field;
}

}  // namespace

std::optional<CellMesh> stream_vtu(const std::filesystem::path& path) {
  const ForeignFile source(path);
  const std::optional<VtkXmlStream> file = VtkXmlStream::open(source);
  if (!file) return std::nullopt;
  const std::optional<Plan> plan = plan_for(*file);
  if (!plan) return std::nullopt;

  ForeignCells cells;
  file->check_count(plan->kinds, plan->cell_count);
  cells.kinds.resize(plan->cell_count);
  file->read(plan->kinds, std::span(cells.kinds));
  if (std::any_of(cells.kinds.begin(), cells.kinds.end(), is_for_vtk)) return std::nullopt;
  file->check_count(plan->offsets, plan->cell_count);
  cells.offsets.resize(plan->cell_count + 1);  // the file stores the ends of cells
  file->read(plan->offsets, std::span(cells.offsets).subspan(1));
  file->check_count(plan->connectivity, cells.offsets.back());
  cells.nodes.resize(cells.offsets.back());
  file->read(plan->connectivity, std::span(cells.nodes));

  CellMesh mesh;
  file->check_count(plan->points, 3 * plan->point_count);
  mesh.points.resize(plan->point_count);
  file->read(plan->points, std::span(mesh.points.front().data(), 3 * plan->point_count));
  for (const VtkXmlArray& array : plan->at_points)
    mesh.point_fields.push_back(read_field(*file, array, plan->point_count, mesh.notes));
  for (const VtkXmlArray& array : plan->in_cells)
    mesh.cell_fields.push_back(read_field(*file, array, plan->cell_count, mesh.notes));
  take_cells(mesh, std::move(cells), path);
  return mesh;
}

}  // namespace rhoray::preprocess
