#pragma once

/// Exact arithmetic (render/exact), for tools that measure how accurate the kernels' methods are.
/// It computes the true result along a ray in one trilinear cell, in a grid and in tetrahedra. The
/// methods under test (render/cell) are included too.
#include "render/cell/certified_crossing.h"
#include "render/cell/crossing_methods.h"
#include "render/exact/exact_cell.h"
#include "render/exact/exact_grid.h"
#include "render/exact/exact_tets.h"
