#pragma once

/// The exact judge (render/exact), for tools that measure what a method of the kernels is worth: what is true along a
/// ray in one trilinear cell, in a grid, in tetrahedra. render/cell comes along: the methods that are judged.
#include "render/cell/certified_crossing.h"
#include "render/cell/crossing_methods.h"
#include "render/exact/exact_cell.h"
#include "render/exact/exact_grid.h"
#include "render/exact/exact_tets.h"
