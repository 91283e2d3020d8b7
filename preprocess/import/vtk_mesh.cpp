#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <cmath>

#include "formats/base/checks.h"
#include "preprocess/import/families.h"
#include "preprocess/import/foreign_file.h"
#include "preprocess/import/mesh_cells.h"
#include "preprocess/import/vtk_arrays.h"
#include "preprocess/import/vtk_errors.h"
#include "preprocess/import/vtu_stream.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// Calls act(numbers, count) with the array's numbers in their own type.
template <class Act>
void with_numbers(vtkDataArray& array, ElementType type, Act&& act) {
  formats::with_element_type(type, [&]<class T>(T) {
    act(static_cast<const T*>(array.GetVoidPointer(0)), static_cast<std::size_t>(array.GetNumberOfValues()));
  });
}

template <class Number>
Array<Number> numbers_of(vtkDataArray& array, ElementType type) {
  Array<Number> result;
  with_numbers(array, type, [&]<class T>(const T* numbers, std::size_t count) {
    result.resize(count);
    for (std::size_t i = 0; i < count; ++i) result[i] = static_cast<Number>(numbers[i]);
  });
  return result;
}

void take_points(CellMesh& mesh, vtkUnstructuredGrid& grid, const std::filesystem::path& path) {
  if (grid.GetPoints() == nullptr || grid.GetNumberOfPoints() == 0)
    refuse_input(path, "element Points", "no points", "at least 4 points");
  vtkDataArray& array = *grid.GetPoints()->GetData();
  const std::optional<ElementType> type = element_type_of_vtk(array);
  if (!type || array.GetNumberOfComponents() != 3)
    refuse_input(path, "element Points", concat(array.GetNumberOfComponents(), " numbers for each point"), "3");
  mesh.points.resize(static_cast<std::size_t>(array.GetNumberOfTuples()));
  with_numbers(array, *type, [&](const auto* numbers, std::size_t count) {
    double* to = mesh.points.front().data();
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<double>(numbers[i]);
  });
}

bool loses_integers(ElementType type, const Array<double>& values) {
  if (type != ElementType::I64 && type != ElementType::U64) return false;
  for (const double value : values)
    if (std::abs(value) > 9007199254740992.0) return true;  // 2^53
  return false;
}

void take_fields(std::vector<NeutralField>& fields, std::vector<std::string>& notes, vtkFieldData& data) {
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    const std::string name = data.GetArrayName(i) == nullptr ? "" : data.GetArrayName(i);
    if (name == "vtkGhostType") continue;    // VTK's own bookkeeping
    vtkDataArray* array = data.GetArray(i);  // null for texts
    const std::optional<ElementType> type = array == nullptr ? std::nullopt : element_type_of_vtk(*array);
    if (!type || array->GetNumberOfComponents() < 1) {
      notes.push_back(concat("array '", name, "' left out: it does not hold numbers"));
      continue;
    }
    NeutralField& field = fields.emplace_back();
    field.name = name;
    field.component_count = array->GetNumberOfComponents();
    field.values = numbers_of<double>(*array, *type);
    field.was_single_precision = *type != ElementType::F64 && fits_single_precision(field.values);
    if (loses_integers(*type, field.values))
      notes.push_back(concat("field '", name, "' holds integers beyond 2^53, which were rounded"));
  }
}

ForeignCells cells_of(vtkUnstructuredGrid& grid, const std::filesystem::path& path) {
  ForeignCells cells;
  vtkCellArray* array = grid.GetCells();
  vtkUnsignedCharArray* kinds = grid.GetCellTypesArray();
  if (array == nullptr || kinds == nullptr || array->GetNumberOfCells() == 0)
    refuse_input(path, "element Cells", "no cells", "at least one tetrahedron");
  const auto whole_numbers = [&](vtkDataArray* numbers) {
    const std::optional<ElementType> type = element_type_of_vtk(*numbers);
    RHORAY_CHECK(type.has_value());
    return numbers_of<std::uint64_t>(*numbers, *type);  // a negative one becomes too large and is refused later
  };
  cells.offsets = whole_numbers(array->GetOffsetsArray());
  cells.nodes = whole_numbers(array->GetConnectivityArray());
  cells.kinds = numbers_of<std::uint8_t>(*kinds, ElementType::U8);
  return cells;
}

/// VTK reads a truncated file without an error in some places: what its header promised must have arrived.
void check_arrival(vtkXMLUnstructuredGridReader& reader, vtkUnstructuredGrid& grid, const std::filesystem::path& path) {
  const auto compare = [&](const char* what, vtkIdType promised, vtkIdType arrived) {
    if (promised != arrived)
      refuse_input(path, what, concat(arrived, " read"), concat(promised, ", as its header says"));
  };
  compare("points", reader.GetNumberOfPoints(), grid.GetNumberOfPoints());
  compare("cells", reader.GetNumberOfCells(), grid.GetNumberOfCells());
  compare("arrays at points", reader.GetNumberOfPointArrays(), grid.GetPointData()->GetNumberOfArrays());
  compare("arrays in cells", reader.GetNumberOfCellArrays(), grid.GetCellData()->GetNumberOfArrays());
}

}  // namespace

CellMesh read_vtu(const std::filesystem::path& path) {
  check_vtk_xml(path, "UnstructuredGrid");
  if (std::optional<CellMesh> mesh = stream_vtu(path)) return *std::move(mesh);
  const VtkErrors errors;
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  errors.check(path);
  vtkUnstructuredGrid* grid = reader->GetOutput();
  check_arrival(*reader, *grid, path);
  CellMesh mesh;
  take_points(mesh, *grid, path);
  take_fields(mesh.point_fields, mesh.notes, *grid->GetPointData());
  take_fields(mesh.cell_fields, mesh.notes, *grid->GetCellData());
  take_cells(mesh, cells_of(*grid, path), path);
  return mesh;
}

}  // namespace rhoray::preprocess
