#include <csignal>

#include "tools/rhoray/command_line.h"
#include "tools/rhoray/interrupt.h"
#include "tools/rhoray/standard_streams.h"
#include "tools/rhoray/subcommands.h"

int main(int argc, char** argv) {
  using namespace rhoray::tools;
  keep_standard_descriptors();
  end_cleanly_on_interrupt();
  survive_lost_bytes();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit of file size is met by an error of write, here and in the workers
  const Subcommand subcommands[] = {info_subcommand(),    import_subcommand(),   pack_subcommand(),
                                    verify_subcommand(),  resample_subcommand(), tetrahedralize_subcommand(),
                                    render_subcommand(),  export_subcommand(),   validate_subcommand(),
                                    compare_subcommand(), bench_subcommand(),    accuracy_subcommand()};
  return finish_standard_output(run_command_line(subcommands, argc, argv));
}
