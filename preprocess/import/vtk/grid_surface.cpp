#include "preprocess/import/vtk/grid_surface.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>

#include "formats/base/error.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/import/vtk/vtk_errors.h"

namespace rhoray::preprocess {
namespace {

/// An image of the samples at integer positions in their own frame, so that only the corners of
/// triangles are moved into the world.
template <class T>
vtkSmartPointer<vtkImageData> image_of(const GridSamples<T>& samples) {
  const Index3& count = samples.sample_count();
  const auto array = vtkSmartPointer<vtkAOSDataArrayTemplate<T>>::New();
  array->SetNumberOfTuples(volume(count));
  T* values = array->GetPointer(0);
  for (std::int64_t k = 0; k < count.z; ++k)
    for (std::int64_t j = 0; j < count.y; ++j)
      samples.read_row(j, k, std::span(values + (k * count.y + j) * count.x, static_cast<std::size_t>(count.x)));
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(static_cast<int>(count.x), static_cast<int>(count.y), static_cast<int>(count.z));
  image->GetPointData()->SetScalars(array);
  return image;
}

/// True when all corners of the cell that contains this point have data. A marching cubes triangle
/// lies in one cell.
template <class T>
bool has_data_around(const GridSamples<T>& samples, const Vec3& p) {
  if constexpr (!std::is_floating_point_v<T>) return true;
  Index3 cell;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(p[axis])) return false;  // the cut edge joins a value and no data
    const auto last = static_cast<double>(samples.sample_count()[axis] - 2);
    cell[axis] = static_cast<std::int64_t>(std::clamp(std::floor(p[axis]), 0.0, last));
  }
  for (std::int64_t corner = 0; corner < 8; ++corner)
    if (!std::isfinite(
            static_cast<double>(samples.at(cell.x + (corner & 1), cell.y + (corner >> 1 & 1), cell.z + (corner >> 2)))))
      return false;
  return true;
}

template <class T>
StlCounts write_triangles(const GridSamples<T>& samples, const Affine& world_from_grid, vtkPolyData& surface,
                          const std::filesystem::path& output) {
  // In a right-handed frame, the front of VTK's triangles faces lower values.
  const bool mirrored = world_from_grid.determinant() < 0;
  StlFile file(output);
  const vtkIdType* corners = nullptr;
  vtkIdType corner_count = 0;
  vtkCellArray* triangles = surface.GetPolys();
  for (triangles->InitTraversal(); triangles->GetNextCell(corner_count, corners) != 0;) {
    Vec3 p[3];
    for (int c = 0; c < 3; ++c) surface.GetPoint(corners[c], &p[c].x);
    if (!has_data_around(samples, (p[0] + p[1] + p[2]) / 3)) continue;
    for (Vec3& corner : p) corner = world_from_grid.point(corner);
    if (mirrored) std::swap(p[1], p[2]);
    file.add(p[0], p[1], p[2]);
  }
  return file.finish();
}

}  // namespace

StlCounts write_grid_surface(const std::filesystem::path& packed, const std::string& field, double isovalue,
                             const std::filesystem::path& output) {
  const OpenedGrid grid = open_grid(packed, field);
  return with_samples(grid, [&]<class T>(const GridSamples<T>& samples) {
    const VtkErrors errors;
    vtkNew<vtkFlyingEdges3D> contour;
    contour->SetInputData(image_of(samples));
    contour->SetValue(0, isovalue);
    contour->ComputeNormalsOff();
    contour->ComputeScalarsOff();
    contour->Update();
    if (errors.any())
      throw Error(ErrorCode::internal, concat(packed.string(), ": VTK made no surface at the isovalue ", isovalue),
                  "-v prints the reason that VTK gives");
    return write_triangles(samples, grid.description().world_from_grid, *contour->GetOutput(), output);
  });
}

}  // namespace rhoray::preprocess
