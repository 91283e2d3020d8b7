#pragma once

#include "render/tets/reference/crossing.h"
#include "render/tets/tet_data.h"

/// The scalar search for a mesh's isosurface (render/tets/reference/crossing.h), as templates over
/// the mesh and over the traversal of its cells. Studies use them with other acceleration
/// structures, so that only the traversal differs between the versions compared.
