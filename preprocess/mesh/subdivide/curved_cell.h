#pragma once

#include <cstdint>

#include "preprocess/mesh/subdivide/shape_functions.h"

namespace rhoray::preprocess {

struct CurvedCell {
  std::uint64_t cell;           ///< its index in the mesh
  const ShapeFunctions* shape;  ///< owned by the caller
};

}  // namespace rhoray::preprocess
