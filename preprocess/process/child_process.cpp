#include "preprocess/process/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory_resource>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "formats/base/component_file.h"
#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/library_text.h"
#include "formats/base/printable.h"
#include "preprocess/process/limits.h"
#include "preprocess/process/nameless_file.h"
#include "preprocess/process/scratch_memory.h"

extern char** environ;

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

// The address and thread sanitizers reserve terabytes of memory for themselves, so no limit can be
// set there.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool memory_can_be_limited = false;
#else
constexpr bool memory_can_be_limited = true;
#endif

constexpr std::size_t kept_complaint_bytes = 64 << 10;
constexpr std::string_view hint_mark = "hint: ";
constexpr char progress_mark = '\1';  // begins a line of progress

[[noreturn]] void refuse_by_system(const std::string& doing, const char* call) {
  const int reason = errno;
  const bool scarce = reason == ENOMEM || reason == EAGAIN || reason == EMFILE || reason == ENFILE || reason == ENOSPC;
  throw Error(scarce ? ErrorCode::resource : ErrorCode::internal,
              concat(doing, ": ", call, ": ", std::strerror(reason)));
}

/// A file passed between the two processes: in memory, or in the scratch folder.
Descriptor anonymous_file(const WorkerRequest& request, const char* name) {
  if (!request.scratch_folder.empty()) return Descriptor(open_nameless_file(request.scratch_folder, 0));
  const int number = ::memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (number < 0) refuse_by_system(request.doing, "memfd_create");
  return Descriptor(number);
}

/// Seals an answer in memory: nobody can change it any more, so it stays as it is checked on
/// opening.
void freeze(const Descriptor& answer, const WorkerRequest& request) {
  if (!request.scratch_folder.empty()) return;  // files on disk have no seals
  if (::fcntl(answer.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL) != 0)
    refuse_by_system(request.doing, "fcntl F_ADD_SEALS");
}

std::string worker_path(const std::string& program) {
  const char* const named = std::getenv("RHORAY_WORKER_DIR");
  const ComponentFile file(program, named == nullptr ? "" : named);
  if (!file.exists())
    throw Error(ErrorCode::unsupported, concat("this needs ", file.missing_text()),
                concat(file.hint(), "; RHORAY_WORKER_DIR names another folder"));
  if (::access(file.path().c_str(), X_OK) != 0)
    throw Error(ErrorCode::internal,
                concat("the worker program ", file.path().string(), " cannot be started: ", std::strerror(errno)));
  return file.path().string();
}

/// Everything that the child needs, prepared before the fork. After the fork, only calls that are
/// safe beside other threads are allowed.
struct Start {
  int input = -1, output = -1, complaints = -1, nothing = -1;
  pid_t parent = 0;
  std::vector<std::string> argument_texts{}, environment_texts{};
  std::vector<char*> arguments{}, environment{};
  WorkerLimits limits{};
};

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

bool is_ours(std::string_view variable) {
  for (const std::string_view name : {"RHORAY_INPUT_FD=", "RHORAY_OUTPUT_FD=", "RHORAY_DOING=", "RHORAY_SCRATCH="})
    if (variable.starts_with(name)) return true;
  return false;
}

void prepare_texts(Start& start, const WorkerRequest& request) {
  start.argument_texts.push_back(worker_path(request.program));
  start.argument_texts.insert(start.argument_texts.end(), request.arguments.begin(), request.arguments.end());
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (!is_ours(*variable)) start.environment_texts.emplace_back(*variable);
  if (start.input >= 0) start.environment_texts.push_back(concat("RHORAY_INPUT_FD=", start.input));
  start.environment_texts.push_back(concat("RHORAY_OUTPUT_FD=", start.output));
  start.environment_texts.push_back("RHORAY_DOING=" + request.doing);
  if (!request.scratch_folder.empty())
    start.environment_texts.push_back("RHORAY_SCRATCH=" + request.scratch_folder.string());
  start.arguments = pointers_to(start.argument_texts);
  start.environment = pointers_to(start.environment_texts);
}

[[noreturn]] void fail_in_child(const char* text) {
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
  ::_exit(127);
}

void set_limits(const WorkerLimits& limits) {
  if (::setrlimit(RLIMIT_CORE, &limits.core) != 0) fail_in_child("core files could not be switched off\n");
  if (memory_can_be_limited && ::setrlimit(RLIMIT_DATA, &limits.memory) != 0)
    fail_in_child("the memory limit was not accepted\n");
  if (::setrlimit(RLIMIT_FSIZE, &limits.file_size) != 0) fail_in_child("the limit of file sizes was not accepted\n");
  if (::setrlimit(RLIMIT_NOFILE, &limits.open_files) != 0) fail_in_child("the limit of open files was not accepted\n");
  if (limits.time && ::setrlimit(RLIMIT_CPU, &*limits.time) != 0) fail_in_child("the time limit was not accepted\n");
}

[[noreturn]] void become_worker(const Start& start) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != start.parent) ::_exit(127);  // the parent died before the line above
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  if (::dup2(start.nothing, STDIN_FILENO) < 0 || ::dup2(start.nothing, STDOUT_FILENO) < 0 ||
      ::dup2(start.complaints, STDERR_FILENO) < 0)
    ::_exit(127);
  if (start.input >= 0) ::fcntl(start.input, F_SETFD, 0);
  ::fcntl(start.output, F_SETFD, 0);
  set_limits(start.limits);
  ::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is an error of the call that writes
  ::execve(start.arguments[0], start.arguments.data(), start.environment.data());
  fail_in_child("the worker program was not accepted by the system\n");
}

/// Forwards the numbers of `<mark>DONE TOTAL` at the end of a line, and returns the text before. A
/// mark before other text belongs to the text.
std::string_view without_progress(std::string_view line, const WorkerRequest& request) {
  const std::size_t mark = line.rfind(progress_mark);
  if (mark == line.npos) return line;
  const char* const end = line.data() + line.size();
  std::uint64_t done = 0, total = 0;
  const auto first = std::from_chars(line.data() + mark + 1, end, done);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != ' ') return line;
  const auto second = std::from_chars(first.ptr + 1, end, total);
  if (second.ec != std::errc() || second.ptr != end) return line;
  if (request.progress) request.progress(done, total);
  return line.substr(0, mark);
}

[[noreturn]] void refuse_idle(const WorkerRequest& request) {
  throw Error(ErrorCode::resource,
              concat("the worker ", request.program, " was stopped while ", request.doing, ": for ",
                     request.idle_limit_s, " s it used no CPU time and read or wrote nothing"),
              "the input's disk or server does not answer, or the library that reads it has a defect");
}

/// Waits until there is something to read. Throws when the worker is idle for too long.
void wait_for_words(int descriptor, const WorkerRequest& request, IdleWatch& watch) {
  for (;;) {
    pollfd words{.fd = descriptor, .events = POLLIN, .revents = 0};
    const auto begin = std::chrono::steady_clock::now();
    const int ready = ::poll(&words, 1, watch.pause_ms());
    if (ready > 0) return;
    if (ready < 0 && errno != EINTR) refuse_by_system(request.doing, "poll");
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (ready == 0 && watch.is_over(elapsed.count())) refuse_idle(request);
  }
}

/// Waits until the worker has ended: one that has closed its standard error may go on. Throws like
/// wait_for_words.
void wait_for_end(pid_t worker, const WorkerRequest& request, IdleWatch& watch) {
  constexpr int longest_ms = 128;
  double since_look_s = 0;
  for (int pause_ms = 1;; pause_ms = std::min(2 * pause_ms, longest_ms)) {
    siginfo_t ended{};
    if (::waitid(P_PID, static_cast<id_t>(worker), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == worker)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(pause_ms));
    since_look_s += 1e-3 * pause_ms;
    if (1e3 * since_look_s < watch.pause_ms()) continue;
    if (watch.is_over(since_look_s)) refuse_idle(request);
    since_look_s = 0;
  }
}

/// Reads the worker's output until it ends. Progress is forwarded, and the end of the remaining
/// text is returned.
std::string complaints_of(int descriptor, pid_t worker, const WorkerRequest& request) {
  std::string text, rest;
  char piece[4096];
  IdleWatch watch(worker, request.idle_limit_s);
  for (;;) {
    wait_for_words(descriptor, request, watch);
    const ssize_t count = ::read(descriptor, piece, sizeof piece);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      wait_for_end(worker, request, watch);
      return text + rest;
    }
    rest.append(piece, static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end; (end = rest.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string_view line = std::string_view(rest).substr(begin, end - begin);
      const std::string_view kept = without_progress(line, request);
      text += kept;
      if (kept.size() == line.size()) text += '\n';
    }
    rest.erase(0, begin);
    if (rest.size() > kept_complaint_bytes) text += std::exchange(rest, {});
    if (text.size() > 2 * kept_complaint_bytes) text.erase(0, text.size() - kept_complaint_bytes);
  }
}

struct End {
  int status = 0;
  double computing_s = 0;
};

End end_of(pid_t child) {
  End end;
  rusage used{};
  while (::wait4(child, &end.status, 0, &used) < 0 && errno == EINTR) {
  }
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  end.computing_s = seconds(used.ru_utime) + seconds(used.ru_stime);
  return end;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end > begin) lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

/// Passes on the last lines that the worker printed beside its report: its libraries printed them.
void pass_on(std::span<const std::string> lines) {
  constexpr std::size_t most = 100;
  for (const std::string& line : lines.last(std::min(most, lines.size()))) note_library_text(line);
}

std::string hint_at(std::span<const std::string> lines) {
  return lines.empty() ? "" : "-v prints what its libraries said";
}

std::optional<ErrorCode> error_code_of(int exit_code) {
  switch (exit_code) {
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
    case 7:
    case 130:
      return static_cast<ErrorCode>(exit_code);
    default:
      return std::nullopt;
  }
}

[[noreturn]] void rethrow(int exit_code, const WorkerRequest& request, const std::vector<std::string>& lines) {
  const std::optional<ErrorCode> error_code = error_code_of(exit_code);
  if (!error_code || lines.empty()) {
    pass_on(lines);
    throw Error(ErrorCode::internal,
                concat("the worker ", request.program, " ended with code ", exit_code, " while ", request.doing),
                hint_at(lines));
  }
  const bool has_hint = lines.size() > 1 && lines[lines.size() - 2].starts_with(hint_mark);
  pass_on(std::span(lines).first(lines.size() - (has_hint ? 2 : 1)));
  throw Error(*error_code, lines.back(), has_hint ? lines[lines.size() - 2].substr(hint_mark.size()) : "");
}

/// The worker was ended by a signal: reports the cause and what it means.
[[noreturn]] void report_death(const End& end, const WorkerRequest& request, const std::string& complaints) {
  const int signal = WTERMSIG(end.status);
  pass_on(lines_of(complaints));
  if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP)
    throw Error(ErrorCode::interrupted, concat("interrupted while ", request.doing));
  if (signal == SIGBUS)
    throw Error(ErrorCode::invalid,
                concat("the worker ", request.program, " was stopped by signal ", signal, " (", ::strsignal(signal),
                       ") while ", request.doing, ": bytes of a file that it had mapped were gone"),
                "another program made the file shorter meanwhile, or its disk failed");
  const bool out_of_time = request.time_limit_s > 0 && end.computing_s >= request.time_limit_s;
  if (signal == SIGXCPU || (signal == SIGKILL && out_of_time))
    throw Error(ErrorCode::resource,
                concat("the worker ", request.program, " was stopped after its limit of ", request.time_limit_s,
                       " s of CPU time while ", request.doing),
                "allow more time, or reduce the work");
  const bool out_of_memory = signal == SIGKILL || complaints.find("bad_alloc") != std::string::npos;
  throw Error(out_of_memory ? ErrorCode::resource : ErrorCode::invalid,
              concat("the worker ", request.program, " was stopped by signal ", signal, " (", ::strsignal(signal),
                     ") while ", request.doing),
              out_of_memory ? "it probably needs more memory; allow more with --memory"
                            : "the input is damaged, or the library that reads it has a defect");
}

/// Fills the worker's input. That file has no name, so a failure is that of the whole act.
void write_input(const WorkerRequest& request, const Descriptor& input) {
  try {
    request.write_input(input.number());
  } catch (const Error& error) {
    const std::string nameless = concat("descriptor ", input.number()), fact = error.what();
    if (!fact.starts_with(nameless)) throw;
    throw Error(error.code(), request.doing + fact.substr(nameless.size()), error.hint());
  }
}

}  // namespace

formats::PackedFile run_worker(const WorkerRequest& request) {
  Descriptor input;
  if (request.write_input) {
    input = anonymous_file(request, "rhoray-input");
    write_input(request, input);
    if (::lseek(input.number(), 0, SEEK_SET) < 0) refuse_by_system(request.doing, "lseek");
  }
  const Descriptor output = anonymous_file(request, "rhoray-output");
  int pipe_ends[2];
  if (::pipe2(pipe_ends, O_CLOEXEC) != 0) refuse_by_system(request.doing, "pipe2");
  const Descriptor hear(pipe_ends[0]);
  Descriptor speak(pipe_ends[1]);
  const Descriptor nothing(::open("/dev/null", O_RDWR | O_CLOEXEC));
  if (nothing.number() < 0) refuse_by_system(request.doing, "open /dev/null");

  Start start{.input = input.number(),
              .output = output.number(),
              .complaints = speak.number(),
              .nothing = nothing.number(),
              .parent = ::getpid()};
  prepare_texts(start, request);
  start.limits = limits_for(request);

  const pid_t child = ::fork();
  if (child < 0) refuse_by_system(request.doing, "fork");
  if (child == 0) become_worker(start);
  speak.close();
  const std::string complaints = [&] {
    try {
      return complaints_of(hear.number(), child, request);
    } catch (...) {
      ::kill(child, SIGKILL);
      end_of(child);
      throw;
    }
  }();
  const End end = end_of(child);
  const int status = end.status;

  if (WIFSIGNALED(status)) report_death(end, request, complaints);
  if (WEXITSTATUS(status) != 0) rethrow(WEXITSTATUS(status), request, lines_of(complaints));
  pass_on(lines_of(complaints));
  freeze(output, request);
  try {
    return formats::PackedFile::from_descriptor(output.number(), "what the worker " + request.program + " handed over");
  } catch (const Error& error) {
    // Memory may be exhausted here; any other error is a defect of the worker.
    const ErrorCode error_code = error.code() == ErrorCode::resource ? ErrorCode::resource : ErrorCode::internal;
    throw Error(error_code, concat("while ", request.doing, ": ", error.what()), error.hint());
  }
}

namespace {

std::string in_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return printable(text);
}

/// Reports a refusal and ends the process at once, without static destructors and without the leak
/// checker: libraries do not free everything when they refuse a damaged file.
[[noreturn]] void refuse(ErrorCode error_code, const std::string& fact, const std::string& hint) {
  std::string lines = "\n";  // ends a line that a library left unfinished
  if (!hint.empty()) lines += concat(hint_mark, in_one_line(hint), "\n");
  lines += in_one_line(fact.empty() ? "no reason given" : fact) + "\n";
  std::fputs(lines.c_str(), stderr);
  std::_Exit(static_cast<int>(error_code));
}

int descriptor_named(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? -1 : std::atoi(text);
}

std::atomic<bool> is_worker = false;

/// Stores large arrays of this process in the folder that the caller named, if any.
void use_scratch_folder() {
  const char* folder = std::getenv("RHORAY_SCRATCH");
  if (folder == nullptr) return;
  static ScratchMemory scratch{folder};
  std::pmr::set_default_resource(&scratch);
}

}  // namespace

void report_worker_progress(std::uint64_t done, std::uint64_t total) {
  if (!is_worker) return;
  static std::mutex guard;
  static std::chrono::steady_clock::time_point last;
  const std::lock_guard lock(guard);
  const auto now = std::chrono::steady_clock::now();
  if (now - last < std::chrono::milliseconds(100)) return;
  last = now;
  const std::string line = concat(std::string(1, progress_mark), done, " ", total, "\n");
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

int worker_main(const std::function<void(int input, int output)>& act) {
  // a library that was loaded may have set another
  const DefaultFloatingPoint default_floating_point;
  const char* doing = std::getenv("RHORAY_DOING");
  const int output = descriptor_named("RHORAY_OUTPUT_FD");
  if (doing == nullptr || output < 0)
    refuse(ErrorCode::usage, "this program is started by `rhoray`, which sets RHORAY_OUTPUT_FD and RHORAY_DOING",
           "call `rhoray`");
  is_worker = true;
  set_library_text_sink([](const std::string& line) { std::fputs((line + "\n").c_str(), stderr); });
  try {
    use_scratch_folder();
    act(descriptor_named("RHORAY_INPUT_FD"), output);
    return 0;
  } catch (const Error& error) {
    refuse(error.code(), error.what(), error.hint());
  } catch (const std::bad_alloc&) {
    refuse(ErrorCode::resource, concat(doing, ": out of memory"), "allow more with --memory");
  } catch (const std::exception& error) {
    note_library_text(error.what());
    refuse(ErrorCode::internal, concat(doing, ": failed unexpectedly"), "-v prints the reason that was given");
  }
}

}  // namespace rhoray::preprocess
