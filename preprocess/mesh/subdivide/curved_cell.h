#pragma once

#include <cstdint>

#include "preprocess/mesh/subdivide/shape_functions.h"

namespace rhoray::preprocess {

struct CurvedCell {
  std::uint64_t cell;           ///< its position in the mesh
  const ShapeFunctions* shape;  ///< stays with the caller
};

}  // namespace rhoray::preprocess
