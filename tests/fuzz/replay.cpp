// The driver for compilers without libFuzzer: runs a harness once for every file that is named, and for every file in
// the folders that are named. With --mutations it also runs that many changed copies of each.
#include <sys/time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/harness.h"

namespace {

std::minstd_rand random_numbers;

std::size_t below(std::size_t count) {
  return random_numbers() % count;
}

struct Request {
  std::size_t mutations = 0;  ///< of each file
  unsigned seed = 1;
  unsigned seconds_each = 20;  ///< of CPU time; an input that takes more ends the program
  std::string last;            ///< where each input is kept before it is run, so that it is there after a crash
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
    files.push_back(std::filesystem::absolute(path).string());  // harnesses may change the working folder
    return;
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(std::filesystem::absolute(entry.path()).string());
}

Request request_of(int argc, char** argv) {
  Request request;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = word == "--mutations" || word == "--seed" || word == "--seconds" || word == "--last";
    if (!has_value) {
      add_files(word, request.files);
      continue;
    }
    if (++i == argc) {
      std::fprintf(stderr, "%s: no value given\n", word.c_str());
      std::exit(2);
    }
    if (word == "--mutations") request.mutations = number(argv[i]);
    if (word == "--seed") request.seed = static_cast<unsigned>(number(argv[i]));
    if (word == "--seconds") request.seconds_each = static_cast<unsigned>(number(argv[i]));
    if (word == "--last") request.last = argv[i];
  }
  std::sort(request.files.begin(), request.files.end());
  if (request.files.empty()) {
    std::fprintf(stderr, "usage: %s [--mutations N] [--seed S] [--seconds S] [--last FILE] FILE_OR_FOLDER...\n",
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
  // A copy of exactly this size, so that the address sanitizer sees what is read beyond its end.
  const std::vector<std::uint8_t> exact(bytes.begin(), bytes.end());
  LLVMFuzzerTestOneInput(exact.data(), exact.size());
  limit_cpu_time(0);
}

}  // namespace

extern "C" {

// Harnesses that need neither leave these.
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
  std::size_t changed_count = 0;
  for (const std::string& path : request.files) {
    const std::vector<std::uint8_t> whole = content_of(path);
    run(request, whole);
    random_numbers.seed(request.seed);
    std::vector<std::uint8_t> changed = whole;
    for (std::size_t i = 0; i < request.mutations; ++i, ++changed_count) {
      constexpr std::size_t generations = 5;  // after which the file itself is taken again
      if (i % generations == 0) changed = whole;
      const std::size_t room = std::max(most_bytes, changed.size()), before = changed.size();
      changed.resize(room);
      changed.resize(LLVMFuzzerCustomMutator(changed.data(), before, room, static_cast<unsigned>(random_numbers())));
      run(request, changed);
    }
  }
  std::fprintf(stderr, "%zu files and %zu changed copies\n", request.files.size(), changed_count);
}
