#include <cstdlib>
#include <string_view>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/query/machine.h"

namespace rhoray::render {

namespace {

Machine asked_for(std::string_view name) {
  for (const Machine machine : all_machines)
    if (name == name_of(machine)) {
      if (!has_machine(machine))
        throw Error(ErrorCode::usage, concat("RHORAY_MACHINE=", name, "; this processor does not have it"));
      return machine;
    }
  throw Error(ErrorCode::usage, concat("RHORAY_MACHINE=", name, "; expected scalar, baseline, avx2 or avx512"));
}

}  // namespace

Machine chosen_machine() {
  static const Machine chosen = [] {
    const char* const name = std::getenv("RHORAY_MACHINE");
    return name != nullptr ? asked_for(name) : best_machine();
  }();
  return chosen;
}

}  // namespace rhoray::render
