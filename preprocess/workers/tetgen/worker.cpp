#include <span>
#include <string_view>

#include "preprocess/process/child_process.h"
#include "preprocess/process/messages.h"
#include "preprocess/workers/tetgen/fill.h"
#include "preprocess/workers/tetgen/job.h"
#include "preprocess/workers/tetgen/surface_checks.h"

/// Reads a surface; refuses what TetGen could not survive and fills the rest with tetrahedra, or
/// lists its faults.
int main(int argc, char** argv) {
  using namespace rhoray::preprocess;
  return worker_main([&](int input, int output) {
    const std::span<const char* const> arguments(argv + 1, argv + argc);
    NeutralSurface surface =
        receive_surface(rhoray::formats::PackedFile::from_descriptor(input, "handed-over surface"));
    if (arguments.size() == 2 && std::string_view(arguments[0]) == find_faults_verb) {
      hand_over_faults(faulty_facets(std::move(surface), std::string_view(arguments[1]) == "1"), output);
      return;
    }
    const TetrahedralizeOptions options = options_from(arguments);
    send(fill(checked_surface(std::move(surface), options.solids_may_touch), options), output);
  });
}
