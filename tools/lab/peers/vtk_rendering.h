#pragma once

#include "tools/lab/peers/triangles.h"

namespace rhoray::study {

/// Draws the triangles with VTK through the system's OpenGL (Mesa's software renderer where there
/// is no GPU).
PeerPointer vtk_drawing(std::shared_ptr<Triangles> triangles);

/// The reason why nothing can be drawn here; empty if it can.
std::string no_display();

/// vtkFixedPointVolumeRayCastMapper, maximum intensity, one thread, without its automatic
/// coarsening. Only casts the rays, so it needs no display.
/// @param step  distance of samples in voxels (of the smallest spacing)
PeerPointer vtk_largest_values(double step);

}  // namespace rhoray::study
