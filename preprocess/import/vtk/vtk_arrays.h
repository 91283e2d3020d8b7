#pragma once

#include <filesystem>
#include <optional>

#include "formats/packed_file.h"

class vtkDataArray;

namespace rhoray::preprocess {

/// Our element type for a VTK array, by what its numbers are in memory; nothing for bits and the
/// like.
std::optional<formats::ElementType> element_type_of_vtk(const vtkDataArray& array);

}  // namespace rhoray::preprocess
