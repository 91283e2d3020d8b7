#include "render/query/machine.h"

namespace rhoray::render {

// For the shared library, instead of chosen_machine.cpp: a library reads no environment.
Machine chosen_machine() {
  static const Machine best = best_machine();
  return best;
}

}  // namespace rhoray::render
