#include "preprocess/import/vtk/vtk_fields.h"

#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include "formats/base/text.h"
#include "preprocess/import/vtk/vtk_arrays.h"
#include "preprocess/import/vtk/vtk_numbers.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

constexpr const char* ghost_array = "vtkGhostType";

std::string unit_of(vtkDataArray& array) {
  if (!array.HasInformation() || !array.GetInformation()->Has(vtkDataArray::UNITS_LABEL())) return {};
  const char* unit = array.GetInformation()->Get(vtkDataArray::UNITS_LABEL());
  return unit == nullptr ? "" : unit;
}

void take_arrays(std::vector<NeutralField>& fields, std::vector<std::string>& notes, vtkFieldData& data) {
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    const std::string name = data.GetArrayName(i) == nullptr ? "" : data.GetArrayName(i);
    if (name == ghost_array) continue;
    vtkDataArray* array = data.GetArray(i);  // null for text arrays
    const std::optional<ElementType> type = array == nullptr ? std::nullopt : element_type_of_vtk(*array);
    if (!type || array->GetNumberOfComponents() < 1) {
      notes.push_back(concat("array '", name, "' left out: it does not hold numbers"));
      continue;
    }
    NeutralField& field = fields.emplace_back();
    field.name = name;
    field.unit = unit_of(*array);
    field.component_count = array->GetNumberOfComponents();
    field.values = numbers_of<double>(*array, *type);
    note_precision(field, *type, notes);
  }
}

Array<std::uint8_t> ghosts_of(vtkFieldData& data) {
  vtkDataArray* array = data.GetArray(ghost_array);
  if (array == nullptr || array->GetNumberOfComponents() != 1 || element_type_of_vtk(*array) != ElementType::U8)
    return {};
  return numbers_of<std::uint8_t>(*array, ElementType::U8);
}

}  // namespace

void take_vtk_points(CellMesh& mesh, vtkPoints* points, const std::filesystem::path& path) {
  if (points == nullptr || points->GetNumberOfPoints() == 0) return;
  vtkDataArray& array = *points->GetData();
  const std::optional<ElementType> type = element_type_of_vtk(array);
  if (!type || array.GetNumberOfComponents() != 3)
    refuse_input(path, "element Points", concat(array.GetNumberOfComponents(), " numbers for each point"), "3");
  mesh.points.resize(static_cast<std::size_t>(array.GetNumberOfTuples()));
  with_numbers(array, *type, [&](const auto* numbers, std::size_t count) {
    double* to = mesh.points.front().data();
    for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<double>(numbers[i]);
  });
}

void take_vtk_fields(CellMesh& mesh, vtkDataSet& data) {
  take_arrays(mesh.point_fields, mesh.notes, *data.GetPointData());
  take_arrays(mesh.cell_fields, mesh.notes, *data.GetCellData());
}

void take_vtk_ghosts(ForeignCells& cells, vtkDataSet& data) {
  cells.ghosts = ghosts_of(*data.GetCellData());
  cells.point_ghosts = ghosts_of(*data.GetPointData());
}

}  // namespace rhoray::preprocess
