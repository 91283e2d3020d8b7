#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/traverse/ray.h"

namespace rhoray::render {

/// A change of side along a ray, found in exact arithmetic.
struct Crossing {
  double t = 0;
  double error = 0;        ///< bound on the distance of t from the exact one
  std::uint64_t cell = 0;  ///< id, as in Hit
  bool to_inside = false;  ///< from value < isovalue to value >= isovalue
};

/// Returns the first `most` changes of side along a ray in the data's frame, in order. Defined for
/// every view with a field.
template <class View>
std::vector<Crossing> crossings_along(const View& view, double isovalue, const Ray& ray, std::size_t most);

}  // namespace rhoray::render
