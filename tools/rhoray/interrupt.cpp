#include "tools/rhoray/interrupt.h"

#include <semaphore.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <mutex>
#include <thread>

#include "formats/base/checks.h"
#include "formats/base/pending_file.h"
#include "formats/base/trouble.h"

namespace rhoray::tools {

namespace {

sem_t interrupted;  // a handler may do no more than post it
std::mutex scratch_mutex;
std::filesystem::path scratch;  // empty when there is none
std::mutex request_mutex;
std::stop_source* request = nullptr;  // of an InterruptRequest

extern "C" void on_interrupt(int) {
  ::sem_post(&interrupted);
}

void wait_for_interrupt() {
  while (::sem_wait(&interrupted) != 0 && errno == EINTR) {
  }
}

/// False where nobody takes the request, or it was made before.
bool request_end() {
  const std::lock_guard lock(request_mutex);
  if (request == nullptr || !request->request_stop()) return false;
  std::fputs("\nrhoray: interrupted: writing what there is; once more ends at once\n", stderr);
  return true;
}

/// The work goes on meanwhile and may put a file into the folder after what is in it was listed: then once more.
void remove_scratch() {
  constexpr int most_times = 1000;
  std::error_code error;
  for (int i = 0; i < most_times; ++i) {
    std::filesystem::remove_all(scratch, error);
    if (!std::filesystem::exists(scratch, error)) return;
  }
}

void wait_and_end() {
  do wait_for_interrupt();
  while (request_end());
  const std::lock_guard lock(scratch_mutex);
  if (!scratch.empty()) remove_scratch();
  end_pending_files();
  std::fputs("\nrhoray: interrupted\n", stderr);
  ::_exit(static_cast<int>(Trouble::interrupted));
}

}  // namespace

void end_cleanly_on_interrupt() {
  RHORAY_CHECK(::sem_init(&interrupted, 0, 0) == 0);
  std::thread(wait_and_end).detach();
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESTART;
  RHORAY_CHECK(::sigaction(SIGINT, &action, nullptr) == 0);
}

InterruptRequest::InterruptRequest() {
  const std::lock_guard lock(request_mutex);
  RHORAY_CHECK(request == nullptr);
  request = &source_;
}

InterruptRequest::~InterruptRequest() {
  const std::lock_guard lock(request_mutex);
  request = nullptr;
}

ScratchFolder::ScratchFolder(const std::filesystem::path& inside) {
  const std::lock_guard lock(scratch_mutex);
  RHORAY_CHECK(scratch.empty());
  std::string pattern = (inside / "rhoray-scratch-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr)
    throw Error(Trouble::resource, concat(inside.string(), ": no folder can be made here"));
  path_ = pattern;
  scratch = path_;
}

ScratchFolder::~ScratchFolder() {
  const std::lock_guard lock(scratch_mutex);
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  scratch.clear();
}

}  // namespace rhoray::tools
