#pragma once

/// The exact judge (render/judge), for tools that measure what a method of the kernels is worth: what is true along a
/// ray in one trilinear cell, in a grid, in tetrahedra. render/cells comes along: the methods that are judged.
#include "render/cells/certified_crossing.h"
#include "render/cells/crossing_methods.h"
#include "render/judge/judge_cell.h"
#include "render/judge/judge_grid.h"
#include "render/judge/judge_tets.h"
