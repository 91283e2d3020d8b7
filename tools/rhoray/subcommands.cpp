#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

std::vector<Subcommand> all_subcommands() {
  return {info_subcommand(),    pack_subcommand(),           verify_subcommand(),   export_subcommand(),
          import_subcommand(),  tetrahedralize_subcommand(), resample_subcommand(), render_subcommand(),
          compare_subcommand(), accuracy_subcommand(),       validate_subcommand(), bench_subcommand()};
}

}  // namespace rhoray::tools
