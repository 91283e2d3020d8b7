#include "render/kernels/ordered_crossings.h"

#include "render/kernels/wide/shells.h"

namespace rhoray::render {

CrossingsKernel crossings_kernel(const VolumeImplementation& volume, const Question& question, Machine machine) {
  return wide::shells_kernel(volume, question, machine);
}

}  // namespace rhoray::render
