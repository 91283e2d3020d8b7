#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLRectilinearGridReader.h>

#include <algorithm>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/vtk/vti_stream.h"
#include "preprocess/import/vtk/vtk_arrays.h"
#include "preprocess/import/vtk/vtk_errors.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

Affine world_from_points(vtkImageData& image) {
  int extent[6];
  image.GetExtent(extent);
  const auto column = [&](int axis) {
    const double length = image.GetSpacing()[axis];
    const vtkMatrix3x3* direction = image.GetDirectionMatrix();
    return length *
           Vec3(direction->GetElement(0, axis), direction->GetElement(1, axis), direction->GetElement(2, axis));
  };
  Affine map{column(0), column(1), column(2), Vec3(image.GetOrigin()[0], image.GetOrigin()[1], image.GetOrigin()[2])};
  // parts of larger images do not begin at 0
  map.origin = map.point(Vec3(extent[0], extent[2], extent[4]));
  return map;
}

void collect(std::vector<GridArray>& arrays, vtkFieldData& data, bool in_cells) {
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data.GetArray(i);  // null for text arrays
    if (array == nullptr) continue;
    const std::optional<formats::ElementType> type = element_type_of_vtk(*array);
    if (!type || array->GetNumberOfComponents() < 1) continue;
    const auto bytes = static_cast<std::size_t>(array->GetNumberOfValues()) * formats::element_bytes(*type);
    arrays.push_back({.name = array->GetName() == nullptr ? "" : array->GetName(),
                      .type = *type,
                      .component_count = array->GetNumberOfComponents(),
                      .in_cells = in_cells,
                      .owned = {},
                      .values = {static_cast<const std::byte*>(array->GetVoidPointer(0)), bytes}});
  }
}

std::vector<GridArray> arrays_of(vtkDataSet& data) {
  std::vector<GridArray> arrays;
  collect(arrays, *data.GetPointData(), false);
  collect(arrays, *data.GetCellData(), true);
  return arrays;
}

std::vector<double> positions_of(vtkDataArray* coordinates) {
  std::vector<double> positions;
  if (coordinates == nullptr) return positions;
  for (vtkIdType i = 0; i < coordinates->GetNumberOfTuples(); ++i) positions.push_back(coordinates->GetTuple1(i));
  return positions;
}

double precision_of(vtkDataArray* coordinates) {
  return coordinates != nullptr && coordinates->GetDataTypeSize() < 8 ? 0x1p-23 : 0x1p-52;
}

NeutralVolume read_image_data(const std::filesystem::path& path, const std::string& field, TakeField* take) {
  check_vtk_xml(path, "ImageData");
  if (std::optional<NeutralVolume> volume = stream_vti(path, field, take)) return *std::move(volume);
  const VtkErrors errors;
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  errors.check(path);
  vtkImageData* image = reader->GetOutput();
  const int* size = image->GetDimensions();
  return take(path, {{size[0], size[1], size[2]}, world_from_points(*image)}, arrays_of(*image), field);
}

}  // namespace

NeutralVolume read_vti(const std::filesystem::path& path, const std::string& field) {
  return read_image_data(path, field, volume_of_field);
}

NeutralVolume read_vti_colors(const std::filesystem::path& path, const std::string& field) {
  return read_image_data(path, field, colors_of_field);
}

NeutralVolume read_vtr(const std::filesystem::path& path, const std::string& field) {
  check_vtk_xml(path, "RectilinearGrid");
  const VtkErrors errors;
  vtkNew<vtkXMLRectilinearGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  errors.check(path);
  vtkRectilinearGrid* grid = reader->GetOutput();
  vtkDataArray* const x = grid->GetXCoordinates();
  vtkDataArray* const y = grid->GetYCoordinates();
  vtkDataArray* const z = grid->GetZCoordinates();
  const double precision = std::max({precision_of(x), precision_of(y), precision_of(z)});
  return volume_of_field(path, rectilinear_grid(path, {positions_of(x), positions_of(y), positions_of(z)}, precision),
                         arrays_of(*grid), field);
}

}  // namespace rhoray::preprocess
