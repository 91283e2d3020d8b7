#include <csignal>

#include "tools/rhoray/cli/command_line.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/subcommands.h"

int main(int argc, char** argv) {
  using namespace rhoray::tools;
  keep_standard_descriptors();
  end_cleanly_on_interrupt();
  survive_lost_bytes();
  std::signal(SIGXFSZ, SIG_IGN);  // a limit of file size is met by an error of write, here and in the workers
  const std::vector<Subcommand> subcommands = subcommands_for(argc > 1 ? argv[1] : "");
  return finish_standard_output(run_command_line(subcommands, argc, argv));
}
