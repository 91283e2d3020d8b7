// Converts the data sets of a legacy VTK file to a mesh, a surface, or a volume.

#include <array>

#include "preprocess/import/mesh/structured_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/surface/surface_building.h"
#include "preprocess/import/vtk/legacy_vtk.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

NeutralField field_of(const GridArray& array) {
  NeutralField field;
  field.name = array.name;
  field.unit = array.unit;
  field.component_count = array.component_count;
  field.values.resize(array.values.size() / formats::element_bytes(array.type));
  copy_as_doubles(array.type, array.values, field.values.data());
  field.was_single_precision = array.type != ElementType::F64 && fits_single_precision(field.values);
  return field;
}

void take_arrays(CellMesh& mesh, LegacyVtk& parts) {
  for (const GridArray& array : parts.arrays) {
    if (array.name == "vtkGhostType" && array.type == ElementType::U8 && array.component_count == 1) {
      const auto* ghosts = reinterpret_cast<const std::uint8_t*>(array.values.data());
      (array.in_cells ? parts.cells.ghosts : parts.cells.point_ghosts).assign(ghosts, ghosts + array.values.size());
      continue;
    }
    (array.in_cells ? mesh.cell_fields : mesh.point_fields).push_back(field_of(array));
  }
}

}  // namespace

CellMesh read_legacy_vtk_mesh(const std::filesystem::path& path) {
  LegacyVtk parts = read_legacy_vtk(path);
  if (parts.dataset == "STRUCTURED_GRID") {
    Array<std::uint8_t> blanked = std::move(parts.cells.point_ghosts);
    parts.cells = hexahedra_of_grid(parts.dimensions, parts.points.size(), path);
    parts.cells.point_ghosts = std::move(blanked);
  } else if (parts.dataset != "UNSTRUCTURED_GRID") {
    refuse_input(path, "DATASET", parts.dataset, "UNSTRUCTURED_GRID or STRUCTURED_GRID", ErrorCode::unsupported);
  }
  CellMesh mesh;
  mesh.points = std::move(parts.points);
  take_arrays(mesh, parts);
  if (parts.cells.offsets.empty()) parts.cells.offsets = {0};
  if (parts.version_major < 5 || (parts.version_major == 5 && parts.version_minor < 1))
    renew_lagrange_hexahedra(parts.cells, path);
  take_cells(mesh, std::move(parts.cells), path);
  return mesh;
}

NeutralSurface read_legacy_vtk_surface(const std::filesystem::path& path) {
  LegacyVtk parts = read_legacy_vtk(path);
  if (parts.dataset != "POLYDATA") refuse_input(path, "DATASET", parts.dataset, "POLYDATA", ErrorCode::unsupported);
  NeutralSurface surface;
  surface.points = std::move(parts.points);
  const auto each = [&](const ForeignCells& cells, const char* kind, auto&& act) {
    for (std::size_t cell = 0; cell + 1 < cells.offsets.size(); ++cell) {
      if (cells.offsets[cell] > cells.offsets[cell + 1] || cells.offsets[cell + 1] > cells.nodes.size())
        refuse_input(path, concat(kind, " ", cell), "an offset that does not fit", "offsets rising to the corners");
      act(std::span(cells.nodes).subspan(cells.offsets[cell], cells.offsets[cell + 1] - cells.offsets[cell]),
          concat(kind, " ", cell));
    }
  };
  each(parts.polygons, "polygon", [&](std::span<const std::uint64_t> corners, const std::string& place) {
    add_facet(surface, corners, path, place);
  });
  each(parts.strips, "triangle strip", [&](std::span<const std::uint64_t> corners, const std::string& place) {
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {  // every other triangle is flipped
      const std::size_t second = i + 1 + i % 2, third = i + 2 - i % 2;
      add_facet(surface, std::array{corners[i], corners[second], corners[third]}, path, place);
    }
  });
  if (parts.thin_cell_count > 0) surface.notes.push_back(concat(parts.thin_cell_count, " vertices and lines left out"));
  if (!parts.arrays.empty())
    surface.notes.push_back(
        concat(count_text(parts.arrays.size(), "field", "fields"), " left out; a surface has no fields"));
  finish_surface(surface, path);
  return surface;
}

NeutralVolume read_legacy_vtk_volume(const std::filesystem::path& path, const std::string& field) {
  LegacyVtk parts = read_legacy_vtk(path);
  if (parts.dataset != "STRUCTURED_POINTS" && parts.dataset != "RECTILINEAR_GRID")
    refuse_input(path, "DATASET", parts.dataset, "STRUCTURED_POINTS or RECTILINEAR_GRID", ErrorCode::unsupported);
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
