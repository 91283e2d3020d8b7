// The driver for compilers without libFuzzer. Runs a harness once for every named file and for
// every file in the named folders. With --mutations, it also runs that many mutated copies of each.
// With --starve, it runs each file again and again while one allocation fails: each of the first N,
// and N spread over the rest. All memory must be free again afterwards, and only std::bad_alloc or
// a refusal may result. The environment variable RHORAY_ALLOCATIONS sets another N.
#include <execinfo.h>
#include <signal.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/harness.h"

namespace {

/// Calls of new; number of the call that fails, 0: none; blocks not freed.
std::atomic<std::uint64_t> allocations{0}, fails_at{0}, live{0};

void* failing_frames[32];  ///< where the failing allocation was made
int failing_frame_count = 0;

void* allocate(std::size_t bytes, std::size_t alignment) {
  if (++allocations == fails_at) {
    failing_frame_count = ::backtrace(failing_frames, static_cast<int>(std::size(failing_frames)));
    throw std::bad_alloc();
  }
  void* const memory = alignment <= __STDCPP_DEFAULT_NEW_ALIGNMENT__
                           ? std::malloc(std::max<std::size_t>(bytes, 1))
                           : std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  ++live;
  return memory;
}

void* allocate_or_null(std::size_t bytes, std::size_t alignment) noexcept {
  try {
    return allocate(bytes, alignment);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void release(void* memory) noexcept {
  if (memory == nullptr) return;
  --live;
  std::free(memory);
}

}  // namespace

// All variants are replaced: the address sanitizer reports mismatched new and delete as an error.
void* operator new(std::size_t bytes) {
  return allocate(bytes, 1);
}
void* operator new[](std::size_t bytes) {
  return allocate(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 1);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  release(memory);
}
void operator delete[](void* memory) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  release(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  release(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  release(memory);
}
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  release(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  release(memory);
}

namespace {

std::minstd_rand random_numbers;

std::size_t below(std::size_t count) {
  return random_numbers() % count;
}

struct Request {
  std::size_t mutations = 0;  ///< per file
  /// Number of first allocations that fail; as many again are spread over the rest.
  std::size_t starve = 0;
  unsigned seed = 1;
  /// CPU time limit per input; an input that takes more ends the program.
  unsigned seconds_each = 20;
  /// File in which each input is stored before it is run, so that it is there after a crash.
  std::string last;
  std::vector<std::string> files;
};

std::size_t number(const char* text) {
  char* end = nullptr;
  const unsigned long value = std::strtoul(text, &end, 10);
  if (end == text || *end != '\0') {
    std::fprintf(stderr, "found '%s'; expected a number\n", text);
    std::exit(2);
  }
  return value;
}

void add_files(const std::string& path, std::vector<std::string>& files) {
  if (!std::filesystem::exists(path)) {
    std::fprintf(stderr, "%s: is not there\n", path.c_str());
    std::exit(3);
  }
  if (!std::filesystem::is_directory(path)) {
    // Harnesses may change the working directory.
    files.push_back(std::filesystem::absolute(path).string());
    return;
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(std::filesystem::absolute(entry.path()).string());
}

Request request_of(int argc, char** argv) {
  Request request;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value =
        word == "--mutations" || word == "--seed" || word == "--seconds" || word == "--last" || word == "--starve";
    if (!has_value) {
      add_files(word, request.files);
      continue;
    }
    if (++i == argc) {
      std::fprintf(stderr, "%s: no value given\n", word.c_str());
      std::exit(2);
    }
    if (word == "--mutations") request.mutations = number(argv[i]);
    if (word == "--starve") {
      const char* const more = std::getenv("RHORAY_ALLOCATIONS");
      request.starve = number(more != nullptr ? more : argv[i]);
    }
    if (word == "--seed") request.seed = static_cast<unsigned>(number(argv[i]));
    if (word == "--seconds") request.seconds_each = static_cast<unsigned>(number(argv[i]));
    if (word == "--last") request.last = argv[i];
  }
  std::sort(request.files.begin(), request.files.end());
  if (request.files.empty()) {
    std::fprintf(stderr,
                 "usage: %s [--mutations N] [--starve N] [--seed S] [--seconds S] [--last FILE] FILE_OR_FOLDER...\n",
                 argv[0]);
    std::exit(2);
  }
  return request;
}

std::vector<std::uint8_t> content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", path.c_str());
    std::exit(3);
  }
  return bytes;
}

void run(const Request& request, const std::vector<std::uint8_t>& bytes) {
  if (!request.last.empty()) {
    std::ofstream file(request.last, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  const auto limit_cpu_time = [](unsigned seconds) {
    const itimerval limit{.it_interval = {0, 0}, .it_value = {static_cast<time_t>(seconds), 0}};
    if (::setitimer(ITIMER_PROF, &limit, nullptr) != 0) std::abort();
  };
  limit_cpu_time(request.seconds_each);
  // A copy of exactly this size, so that the address sanitizer sees reads beyond its end.
  const std::vector<std::uint8_t> exact(bytes.begin(), bytes.end());
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
  limit_cpu_time(0);
}

constexpr int exit_of_json = 77, exit_not_met = 78;

/// True when the failed allocation was the JSON library's. Its destructor allocates
/// (json_value::destroy); if that fails, the program ends. Its constructor from a list leaks what
/// it made before.
bool failed_in_json() {
  char** const names = ::backtrace_symbols(failing_frames, failing_frame_count);
  for (int i = 0; names != nullptr && i < failing_frame_count; ++i) {
    if (std::strstr(names[i], "nlohmann") != nullptr) return true;
    // A frame of ours, nearer than the library's.
    if (std::strstr(names[i], "6rhoray") != nullptr) return false;
  }
  return false;
}

/// Ends this copy of the process after a failed allocation that was not handled.
[[noreturn]] void end_unsaved(const std::string& what) {
  if (failed_in_json()) ::_exit(exit_of_json);
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

extern "C" void on_abort(int signal) {
  constexpr char words[] = "an allocation had failed here:\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, words, sizeof words - 1);
  ::backtrace_symbols_fd(failing_frames, failing_frame_count, STDERR_FILENO);
  ::signal(signal, SIG_DFL);  // which ends the process when this returns to abort
}

[[noreturn]] void on_terminate() {
  end_unsaved("the program was ended");
}

/// Runs the harness once, in a copy of this process, while the allocation of this number fails.
/// Returns its exit code.
int run_starved(const Request& request, const std::vector<std::uint8_t>& bytes, std::uint64_t number) {
  const pid_t child = ::fork();
  if (child < 0) {
    std::perror("fork");
    std::exit(5);
  }
  int status = 0;
  if (child != 0) {
    while (::waitpid(child, &status, 0) < 0) {
    }
    if (!WIFEXITED(status)) {
      std::fprintf(stderr, "allocation %lu failed: ended by signal %d\n", number, WTERMSIG(status));
      std::abort();
    }
    return WEXITSTATUS(status);
  }
  std::set_terminate(on_terminate);
  ::signal(SIGABRT, on_abort);
  const std::uint64_t before = live;
  const std::uint64_t last = allocations + number;
  fails_at = last;
  try {
    run(request, bytes);
  } catch (const std::bad_alloc&) {
  }
  const bool was_met = allocations >= last;
  fails_at = 0;
  if (live != before)
    end_unsaved(std::to_string(static_cast<std::int64_t>(live - before)) + " allocations were not freed");
  ::_exit(was_met ? 0 : exit_not_met);
}

/// @return  number of allocations that failed
std::size_t starve(const Request& request, const std::string& path, const std::vector<std::uint8_t>& bytes) {
  void* frame = nullptr;
  ::backtrace(&frame, 1);  // loads a library on the first call
  run(request, bytes);     // objects that are created once stay
  run(request, bytes);
  const std::uint64_t before = allocations;
  run(request, bytes);
  const std::uint64_t count = allocations - before;  // includes the copy of the input
  const std::uint64_t first = std::min<std::uint64_t>(request.starve, count), rest = count - first;
  const std::uint64_t step = std::max<std::uint64_t>(1, rest / request.starve);
  std::size_t failures = 0, in_json = 0;
  for (std::uint64_t number = 1; number <= count; number += number < first ? 1 : step) {
    const int code = run_starved(request, bytes, number);
    if (code != 0 && code != exit_of_json && code != exit_not_met) {
      std::fprintf(stderr, "%s, allocation %lu: exit code %d\n", path.c_str(), number, code);
      std::abort();
    }
    failures += code != exit_not_met ? 1 : 0;
    in_json += code == exit_of_json ? 1 : 0;
  }
  std::fprintf(stderr, "%s: %zu of %lu allocations failed, %zu of them were not saved by the JSON library\n",
               path.c_str(), failures, count, in_json);
  return failures;
}

}  // namespace

extern "C" {

// Defaults for harnesses that define neither.
[[gnu::weak]] int LLVMFuzzerInitialize(int*, char***) {
  return 0;
}

[[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                                  unsigned) {
  return LLVMFuzzerMutate(data, size, max_size);
}

std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  const std::size_t acts = 1 + below(4);
  for (std::size_t act = 0; act < acts; ++act) {
    const std::size_t kind = size == 0 ? 1 : below(5);
    const std::size_t at = size == 0 ? 0 : below(size);
    if (kind == 0) {
      data[at] = static_cast<std::uint8_t>(data[at] ^ (1U << below(8)));
    } else if (kind == 1 && size < max_size) {
      std::memmove(data + at + 1, data + at, size - at);
      data[at] = static_cast<std::uint8_t>(below(256));
      ++size;
    } else if (kind == 2 && size > 1) {
      const std::size_t count = 1 + below(std::min<std::size_t>(size - at, 16));
      std::memmove(data + at, data + at + count, size - at - count);
      size -= count;
    } else if (kind == 3) {
      constexpr std::uint8_t odd[] = {0, 1, 0x7f, 0x80, 0xff, '0', '9', '-', '.', ' ', '\n', '"'};
      data[at] = odd[below(std::size(odd))];
    } else if (size > 0) {  // a piece from elsewhere
      const std::size_t from = below(size), count = 1 + below(std::min<std::size_t>({size - from, size - at, 32}));
      std::memmove(data + at, data + from, count);
    }
  }
  return size;
}

}  // extern "C"

int main(int argc, char** argv) {
  const Request request = request_of(argc, argv);
  LLVMFuzzerInitialize(&argc, &argv);
  constexpr std::size_t most_bytes = std::size_t{1} << 17;
  std::size_t changed_count = 0, failure_count = 0;
  for (const std::string& path : request.files) {
    const std::vector<std::uint8_t> whole = content_of(path);
    run(request, whole);
    if (request.starve > 0) failure_count += starve(request, path, whole);
    random_numbers.seed(request.seed);
    std::vector<std::uint8_t> changed = whole;
    for (std::size_t i = 0; i < request.mutations; ++i, ++changed_count) {
      constexpr std::size_t generations = 5;  // the copy is reset to the file after this many
      if (i % generations == 0) changed = whole;
      const std::size_t room = std::max(most_bytes, changed.size()), before = changed.size();
      changed.resize(room);
      changed.resize(LLVMFuzzerCustomMutator(changed.data(), before, room, static_cast<unsigned>(random_numbers())));
      run(request, changed);
    }
  }
  std::fprintf(stderr, "%zu files and %zu changed copies, %zu failed allocations\n", request.files.size(),
               changed_count, failure_count);
  return request.starve > 0 && failure_count == 0 ? 1 : 0;
}
