#include "tools/rhoray/cli/standard_streams.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "formats/base/error.h"
#include "tools/rhoray/cli/interrupt.h"

namespace rhoray::tools {

void keep_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest number that is free is this one. Opened the wrong way round, so that using it
    // fails as before.
    if (::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) != descriptor)
      ::_exit(static_cast<int>(ErrorCode::resource));
  }
}

int finish_standard_output(int exit_code) {
  const bool failed_before = std::ferror(stdout) != 0;
  errno = 0;
  const bool fails_now = std::fflush(stdout) != 0;
  const int reason = errno;
  if (!failed_before && !fails_now) return exit_code;
  if (has_lost_its_reader() || reason == EPIPE) return 128 + SIGPIPE;
  std::fputs(concat("rhoray: standard output: could not be written completely",
                    fails_now ? concat(": ", std::strerror(reason)) : std::string(), "\n")
                 .c_str(),
             stderr);
  return exit_code == 0 ? static_cast<int>(ErrorCode::resource) : exit_code;
}

}  // namespace rhoray::tools
