#include "render/all_crossings.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "formats/intact.h"
#include "render/dataset/loaded_dataset.h"

namespace rhoray::render {

AllCrossings all_crossings(const Dataset& dataset, double isovalue, const Ray& ray, std::size_t most) {
  const DefaultFloatingPoint default_floating_point;
  if (!std::isfinite(isovalue))
    throw Error(ErrorCode::usage, concat("isovalue ", isovalue, "; expected a finite number"));
  const LoadedDataset& data = dataset.implementation();
  if (dataset.is_surface())
    throw Error(ErrorCode::unsupported,
                concat(data.file.name(), ": holds triangles, which have no isosurface; expected a grid or a mesh"));
  dataset.prove_ranges();
  // One more shows whether there are more; the largest number has none above it.
  const std::size_t wanted = std::max(most, most + 1);
  AllCrossings found;
  std::visit(
      [&]<class View>(const View& view) {
        if constexpr (!std::is_same_v<View, TriangleData>)
          found.crossings = crossings_along(view, isovalue, ray, wanted);
      },
      data.view);
  found.truncated = found.crossings.size() > most;
  if (found.truncated) found.crossings.pop_back();
  formats::require_intact(data.file);
  return found;
}

}  // namespace rhoray::render
