#pragma once

#include "render/tets/reference/crossing.h"
#include "render/tets/tet_volume.h"

/// The scalar search for a mesh's isosurface (kernels/tet_crossing_kernel.h) as templates over the mesh and over the
/// way to its cells, for studies that put other structures under it: what is then compared is the way alone.
