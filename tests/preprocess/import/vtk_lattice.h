#pragma once

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include "tests/preprocess/import/support.h"

namespace rhoray::tests {

/// The known values as a VTK image, to be written by VTK and read by us: two roads to one answer.
inline vtkSmartPointer<vtkImageData> vtk_lattice(int vtk_type) {
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(static_cast<int>(size_x), static_cast<int>(size_y), static_cast<int>(size_z));
  image->AllocateScalars(vtk_type, 1);
  image->GetPointData()->GetScalars()->SetName("density");
  for (int k = 0; k < size_z; ++k)
    for (int j = 0; j < size_y; ++j)
      for (int i = 0; i < size_x; ++i) image->SetScalarComponentFromDouble(i, j, k, 0, value_at(i, j, k));
  return image;
}

}  // namespace rhoray::tests
