#include <span>

#include "preprocess/tetrahedralize/fill.h"
#include "preprocess/tetrahedralize/job.h"
#include "preprocess/tetrahedralize/surface_checks.h"
#include "preprocess/worker/child_process.h"
#include "preprocess/worker/handover.h"

/// Reads a surface, refuses what TetGen could not survive, fills the rest with tetrahedra.
int main(int argc, char** argv) {
  using namespace rhoray;
  return preprocess::worker_main([&](int input, int output) {
    const auto options = preprocess::options_from(std::span<const char* const>(argv + 1, argv + argc));
    const auto surface = preprocess::checked_surface(
        preprocess::take_surface(formats::PackedFile::from_descriptor(input, "handed-over surface")));
    preprocess::hand_over(preprocess::fill(surface, options), output);
  });
}
