#include "tools/rhoray/cli/interrupt.h"

#include <fcntl.h>
#include <semaphore.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/mapped_file.h"
#include "formats/base/pending_file.h"

namespace rhoray::tools {

namespace {

constexpr int signal_base = 128;  // a shell shows this plus the signal's number

/// How long work on lost bytes may go on before it is ended: zeros in the place of links may make
/// it endless.
constexpr int grace_s = 10;

sem_t something_came;                 // a handler may do no more than set the flags below and post it
std::atomic<int> ending_signal{0};    ///< the last that came
std::atomic<int> unanswered{0};       ///< how many such signals were not acted upon yet
std::atomic<bool> lost_bytes{false};  ///< and reading went on
std::atomic<bool> crashed{false};     ///< after bytes were lost
std::atomic<bool> lost_reader{false};

std::mutex scratch_mutex;
std::filesystem::path scratch;  // empty when there is none
std::mutex request_mutex;
InterruptRequest* request = nullptr;

extern "C" void on_interrupt(int signal) {
  const int before = errno;
  if (signal == SIGPIPE) {
    lost_reader.store(true);
  } else {
    ending_signal.store(signal);
    unanswered.fetch_add(1);
  }
  ::sem_post(&something_came);
  errno = before;
}

/// Lets the signal act as if there were no handler, once this one has returned.
void leave_to_system(int signal) {
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  ::sigaction(signal, &usual, nullptr);
  ::raise(signal);  // held back until the handler returns
}

extern "C" void on_bus_error(int signal, siginfo_t* fault, void*) {
  const int before = errno;
  const bool by_memory_access = fault->si_code > 0;
  if (!by_memory_access || !replace_lost_bytes(fault->si_addr)) return leave_to_system(signal);
  if (!lost_bytes.exchange(true)) ::sem_post(&something_came);
  errno = before;
}

/// Data that were checked when the file was opened may now be zeros, and code that trusted them may
/// crash.
extern "C" void on_crash(int signal, siginfo_t*, void*) {
  if (!any_bytes_lost()) return leave_to_system(signal);
  crashed.store(true);
  ::sem_post(&something_came);
  for (unsigned left = grace_s; left > 0;) left = ::sleep(left);  // wait_and_end ends the program
  leave_to_system(signal);                                        // unless this thread holds what that needs
}

/// Waits for a flag to be set, until the deadline if there is one. False when it has passed.
bool wait_until(const timespec* deadline) {
  for (;;) {
    const int result =
        deadline == nullptr ? ::sem_wait(&something_came) : ::sem_clockwait(&something_came, CLOCK_MONOTONIC, deadline);
    if (result == 0) return true;
    if (errno != EINTR) return false;
  }
}

/// False where nobody takes the request, or it was made before.
bool request_end() {
  const std::lock_guard lock(request_mutex);
  return request != nullptr && request->request_end();
}

/// The work goes on meanwhile and may put a file into the folder after what is in it was listed:
/// then once more.
void remove_scratch() {
  constexpr int most_times = 1000;
  std::error_code error;
  for (int i = 0; i < most_times; ++i) {
    std::filesystem::remove_all(scratch, error);
    if (!std::filesystem::exists(scratch, error)) return;
  }
}

[[noreturn]] void end_program(int exit_code, const std::string& words) {
  const std::lock_guard lock(scratch_mutex);
  if (!scratch.empty()) remove_scratch();
  end_pending_files();
  // Not through stdio, which a crashed thread may hold.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, words.data(), words.size());
  // Threads that work are not joined. The thread sanitizer would report that at _exit.
  std::_Exit(exit_code);
}

[[noreturn]] void end_for_lost_bytes(const std::string& fact) {
  end_program(static_cast<int>(ErrorCode::invalid), concat("rhoray: ", fact, "\n"));
}

/// Ends the program when bytes were lost and nobody was told yet.
void end_if_loss_is_untold() {
  try {
    require_no_lost_bytes();
  } catch (const Error& error) {
    end_for_lost_bytes(error.what());
  }
}

void wait_and_end() {
  timespec deadline{};
  bool has_deadline = false;
  for (;;) {
    const bool came = wait_until(has_deadline ? &deadline : nullptr);
    if (crashed.load()) {
      end_if_loss_is_untold();
      end_for_lost_bytes("an input lost bytes while it was read");
    }
    if (lost_reader.load()) end_program(signal_base + SIGPIPE, "");
    if (unanswered.load() > 0) {
      unanswered.fetch_sub(1);
      if (request_end()) continue;
      end_program(interrupted_exit_code(), "\nrhoray: interrupted\n");
    }
    if (!came) {  // the program has told of the loss and works on something else
      lost_bytes.store(false);
      has_deadline = false;
      end_if_loss_is_untold();
    } else if (lost_bytes.load() && !has_deadline) {
      ::clock_gettime(CLOCK_MONOTONIC, &deadline);
      deadline.tv_sec += grace_s;
      has_deadline = true;
    }
  }
}

constexpr const char* scratch_name = "rhoray-scratch-";  // six letters follow

/// A folder's descriptor that holds a lock; -1 where it is gone, belongs to another user, or
/// somebody else holds it. On file systems without locks there is none to hold: such a folder is of
/// use to its program, and never stale.
int open_and_lock(const std::filesystem::path& folder, bool must_lock = false) {
  const int opened = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (opened < 0) return -1;
  struct stat here {
  }, named{};
  const bool is_locked = ::flock(opened, LOCK_EX | LOCK_NB) == 0;
  const bool is_held = !is_locked && errno == EWOULDBLOCK;
  if (!is_held && (is_locked || !must_lock) && ::fstat(opened, &here) == 0 && here.st_uid == ::geteuid() &&
      ::lstat(folder.c_str(), &named) == 0 && named.st_ino == here.st_ino)
    return opened;
  ::close(opened);
  return -1;
}

/// Removes the scratch folders of programs that were killed.
void remove_stale_scratch(const std::filesystem::path& inside) {
  std::error_code unreadable;
  std::vector<std::filesystem::path> found;
  for (std::filesystem::directory_iterator entry(inside, unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(scratch_name) && name.size() == std::strlen(scratch_name) + 6) found.push_back(entry->path());
  }
  for (const std::filesystem::path& folder : found) {
    const int lock = open_and_lock(folder, true);
    if (lock < 0) continue;
    std::error_code stays;
    std::filesystem::remove_all(folder, stays);
    ::close(lock);
  }
}

bool is_ignored(int signal) {
  struct sigaction now {};
  return ::sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

}  // namespace

void keep_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest number that is free is this one. Opened the wrong way round, so that using it
    // fails as before.
    if (::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) != descriptor)
      ::_exit(static_cast<int>(ErrorCode::resource));
  }
}

void end_cleanly_on_interrupt() {
  RHORAY_CHECK(::sem_init(&something_came, 0, 0) == 0);
  std::thread(wait_and_end).detach();
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE})
    if (signal != SIGHUP || !is_ignored(signal)) RHORAY_CHECK(::sigaction(signal, &action, nullptr) == 0);
}

void survive_lost_bytes() {
  struct sigaction action {};
  action.sa_flags = SA_SIGINFO | SA_RESTART | SA_ONSTACK;
  action.sa_sigaction = on_bus_error;
  RHORAY_CHECK(::sigaction(SIGBUS, &action, nullptr) == 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these report crashes themselves
  action.sa_sigaction = on_crash;
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGILL}) RHORAY_CHECK(::sigaction(signal, &action, nullptr) == 0);
#endif
}

int interrupted_exit_code() {
  const int signal = ending_signal.load();
  return signal == 0 ? static_cast<int>(ErrorCode::interrupted) : signal_base + signal;
}

int finish_standard_output(int exit_code) {
  const bool failed_before = std::ferror(stdout) != 0;
  errno = 0;
  const bool fails_now = std::fflush(stdout) != 0;
  const int reason = errno;
  if (!failed_before && !fails_now) return exit_code;
  if (lost_reader.load() || reason == EPIPE) return 128 + SIGPIPE;
  std::fputs(concat("rhoray: standard output: could not be written completely",
                    fails_now ? concat(": ", std::strerror(reason)) : std::string(), "\n")
                 .c_str(),
             stderr);
  return exit_code == 0 ? static_cast<int>(ErrorCode::resource) : exit_code;
}

InterruptRequest::InterruptRequest(std::string notice) : notice_(std::move(notice)) {
  const std::lock_guard lock(request_mutex);
  RHORAY_CHECK(request == nullptr);
  request = this;
}

bool InterruptRequest::request_end() {
  if (!source_.request_stop()) return false;
  if (!notice_.empty()) std::fputs(concat("\nrhoray: ", notice_, "\n").c_str(), stderr);
  return true;
}

InterruptRequest::~InterruptRequest() {
  const std::lock_guard lock(request_mutex);
  request = nullptr;
}

ScratchFolder::ScratchFolder(const std::filesystem::path& inside) {
  const std::lock_guard lock(scratch_mutex);
  RHORAY_CHECK(scratch.empty());
  remove_stale_scratch(inside);
  constexpr int most_tries = 100;  // in which another program takes the new folder for a stale one
  for (int i = 0; i < most_tries && lock_ < 0; ++i) {
    path_ = concat((inside / scratch_name).string(), "XXXXXX");
    std::string name = path_.string();
    if (::mkdtemp(name.data()) == nullptr) break;
    path_ = name;
    lock_ = open_and_lock(path_);
  }
  if (lock_ < 0) throw Error(ErrorCode::resource, concat(inside.string(), ": cannot make a folder here"));
  scratch = path_;
}

ScratchFolder::~ScratchFolder() {
  const std::lock_guard lock(scratch_mutex);
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  scratch.clear();
  ::close(lock_);
}

}  // namespace rhoray::tools
