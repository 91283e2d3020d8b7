#pragma once

#include <filesystem>
#include <optional>

#include "formats/packed_file.h"

class vtkDataArray;

namespace rhoray::preprocess {

/// The element type of a VTK array, by the type of its numbers in memory; nothing for bits and
/// similar types.
std::optional<formats::ElementType> element_type_of_vtk(const vtkDataArray& array);

}  // namespace rhoray::preprocess
