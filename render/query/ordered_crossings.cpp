#include "render/query/ordered_crossings.h"

#include "render/grid/all_hits/all_hits.h"
#include "render/triangles/kernels/facet_kernels.h"

namespace rhoray::render {

CrossingsKernel crossings_kernel(const VolumeImplementation& volume, const Question& question, Machine machine) {
  if (const CrossingsKernel of_grid = wide::shells_kernel(volume, question, machine)) return of_grid;
  return wide::facet_crossings_kernel(volume, question, machine);
}

}  // namespace rhoray::render
