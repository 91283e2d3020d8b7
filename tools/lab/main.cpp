// Measurements against other programs' libraries and against exact arithmetic, one subcommand each.

#include "tools/lab/bits.h"
#include "tools/lab/closed_surfaces.h"
#include "tools/lab/epsilon.h"
#include "tools/lab/extraction.h"
#include "tools/lab/judge_cells.h"
#include "tools/lab/largest_values.h"
#include "tools/lab/layouts.h"
#include "tools/lab/maximum_search.h"
#include "tools/lab/mesh_scale.h"
#include "tools/lab/peers_grid.h"
#include "tools/lab/peers_tets.h"
#include "tools/lab/preprocess_speed.h"
#include "tools/lab/resample_or_direct.h"
#include "tools/lab/secondary_rays.h"
#include "tools/lab/structures.h"
#include "tools/rhoray/cli/command_line.h"
#include "tools/rhoray/cli/interrupt.h"

int main(int argc, char** argv) {
  using namespace rhoray;
  tools::end_cleanly_on_interrupt();
  const tools::Subcommand subcommands[] = {
      study::preprocess_speed(),
      study::judge_cells(),
      study::closed_surfaces(),
      study::largest_values(),
      study::maximum_search(),
      study::peers_grid(),
      study::peers_tets(),
      study::layouts(),
      study::structures(),
      study::one_frame(),
      study::mesh_scale(),
      study::secondary_rays(),
      study::extraction(),
      study::resample_or_direct(),
      study::bits(),
      study::epsilon(),
  };
  return tools::run_command_line(subcommands, argc, argv);
}
