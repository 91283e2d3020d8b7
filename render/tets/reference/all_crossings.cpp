#include "render/query/crossings.h"
#include "render/tets/reference/exact_cells.h"

namespace rhoray::render {

template <>
std::vector<Crossing> crossings_along(const TetData& view, double isovalue, const Ray& ray, std::size_t most) {
  KernelCounters counters;
  const std::vector<ExactTet> tets = crossed_cells(view, {.isovalue = isovalue}, ray, counters);
  std::vector<Crossing> crossings;
  for (const TetCrossing& found : exact_crossings(tets, ray, isovalue, exact_mesh_width(view, ray), most)) {
    const Middle t(found.t);
    crossings.push_back({t.value, t.error, view.cell_id(tet_of(found)), found.to_inside});
  }
  return crossings;
}

}  // namespace rhoray::render
