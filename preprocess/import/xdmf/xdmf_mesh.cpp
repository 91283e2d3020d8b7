// Meshes in XDMF files (.xdmf, .xmf): cells of every kind, and structured grids as hexahedra.

#include <algorithm>
#include <array>

#include "preprocess/import/mesh/mesh_pieces.h"
#include "preprocess/import/mesh/structured_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/xdmf/topology_cells.h"
#include "preprocess/import/xdmf/xdmf_grids.h"

namespace rhoray::preprocess {
namespace {

bool is_structured(std::string_view topology) {
  return topology == "3dsmesh" || topology == "3dcurvilinear";
}

bool is_wanted(std::string_view topology) {
  return is_structured(topology) || may_fill_space(topology);
}

/// Brings the numbers xx, xy, xz, yy, yz, zz of each tensor to our order.
void order_tensors(Array<double>& values) {
  for (std::size_t at = 0; at + 6 <= values.size(); at += 6) {
    std::array<double, 6> tensor;
    std::transform(from_upper_rows.begin(), from_upper_rows.end(), tensor.begin(),
                   [&](int number) { return values[at + static_cast<std::size_t>(number)]; });
    std::copy(tensor.begin(), tensor.end(), values.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

/// Adds a field, or takes it as ghosts, as ParaView writes them.
void add_attribute(CellMesh& mesh, ForeignCells& cells, const XdmfAttribute& attribute) {
  const std::uint64_t owners = attribute.in_cells ? cells.kinds.size() : mesh.points.size();
  const int components = attribute.component_count(owners);
  if (attribute.name == "vtkGhostType" && components == 1) {
    for (const std::int64_t value : attribute.numbers.read<std::int64_t>())
      (attribute.in_cells ? cells.ghosts : cells.point_ghosts).push_back(static_cast<std::uint8_t>(value));
    return;
  }
  NeutralField& field = (attribute.in_cells ? mesh.cell_fields : mesh.point_fields).emplace_back();
  field.name = attribute.name;
  field.component_count = components;
  field.values = attribute.numbers.read<double>();
  if (attribute.is_symmetric_tensor) order_tensors(field.values);
  note_precision(field, attribute.numbers.type(), mesh.notes);
}

void add_grid(MeshPieces& pieces, const XdmfDocument& document, XdmfData& data, const XdmfGrid& grid) {
  CellMesh mesh;
  mesh.points = points_of(document, data, *grid.geometry);
  ForeignCells cells =
      is_structured(topology_word(*grid.topology))
          ? hexahedra_of_grid(point_counts_of(document, *grid.topology), mesh.points.size(), document.path())
          : cells_of_topology(document, data, *grid.topology, mesh.points.size());
  for (const XdmfAttribute& attribute : attributes_of(document, data, grid, mesh.notes))
    add_attribute(mesh, cells, attribute);
  pieces.add(std::move(mesh), std::move(cells), document.path());
}

}  // namespace

CellMesh read_xdmf_mesh(const std::filesystem::path& path, const std::string& time) {
  const XdmfDocument document(path);
  XdmfData data(document);
  const XdmfGrids chosen = select_grids(document, data, {.time = time, .is_wanted = is_wanted});
  MeshPieces pieces;
  for (const XdmfGrid& grid : chosen.grids) add_grid(pieces, document, data, grid);
  CellMesh mesh = pieces.finish(path);
  mesh.notes.insert(mesh.notes.begin(), chosen.notes.begin(), chosen.notes.end());
  return mesh;
}

}  // namespace rhoray::preprocess
