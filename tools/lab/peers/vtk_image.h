#pragma once

#include <vtkImageData.h>
#include <vtkSmartPointer.h>

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// The samples as a VTK image, without a copy: the grid must outlive it.
vtkSmartPointer<vtkImageData> vtk_image(const preprocess::NeutralVolume& grid);

}  // namespace rhoray::study
