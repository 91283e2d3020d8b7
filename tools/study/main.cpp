// Measurements beside other programs' libraries and against the exact judge, one subcommand each.

#include "tools/rhoray/command_line.h"
#include "tools/rhoray/interrupt.h"
#include "tools/study/bits.h"
#include "tools/study/closed_surfaces.h"
#include "tools/study/epsilon.h"
#include "tools/study/extraction.h"
#include "tools/study/judge_cells.h"
#include "tools/study/largest_values.h"
#include "tools/study/layouts.h"
#include "tools/study/maximum_search.h"
#include "tools/study/mesh_scale.h"
#include "tools/study/peers_grid.h"
#include "tools/study/peers_tets.h"
#include "tools/study/preprocess_speed.h"
#include "tools/study/resample_or_direct.h"
#include "tools/study/secondary_rays.h"
#include "tools/study/structures.h"

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
