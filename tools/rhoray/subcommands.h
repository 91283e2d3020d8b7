#pragma once

#include <string_view>
#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

// One file each.
Subcommand info_subcommand();
Subcommand formats_subcommand();
Subcommand verify_subcommand();
Subcommand import_subcommand();
Subcommand pack_subcommand();
Subcommand tetrahedralize_subcommand();
Subcommand resample_subcommand();
Subcommand render_subcommand();
Subcommand bench_subcommand();
Subcommand export_subcommand();
Subcommand validate_subcommand();
Subcommand compare_subcommand();
Subcommand accuracy_subcommand();
Subcommand cache_subcommand();
Subcommand measure_subcommand();
Subcommand selftest_subcommand();
Subcommand view_subcommand();

/// Those of `rhoray`, in the order of its help.
std::vector<Subcommand> all_subcommands();

/// The one that this word names; all for other words. Others need not be made to run it.
std::vector<Subcommand> subcommands_for(std::string_view word);

}  // namespace rhoray::tools
