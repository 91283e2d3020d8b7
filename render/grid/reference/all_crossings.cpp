#include "render/grid/reference/exact_view.h"
#include "render/query/crossings.h"

namespace rhoray::render {

template <class View>
std::vector<Crossing> crossings_along(const View& view, double isovalue, const Ray& ray, std::size_t most) {
  const ExactGridView grid(view, ray, true);
  std::vector<Crossing> crossings;
  for (const GridCrossing& found : exact_crossings(grid, ray, isovalue, exact_grid_width(view, ray), most)) {
    const Middle t(found.t);
    crossings.push_back({t.value, t.error, view.cell_id(found.cell), found.to_inside});
  }
  return crossings;
}

template std::vector<Crossing> crossings_along(const UniformGrid&, double, const Ray&, std::size_t);
template std::vector<Crossing> crossings_along(const RectilinearGrid&, double, const Ray&, std::size_t);

}  // namespace rhoray::render
