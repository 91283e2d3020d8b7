// A worker that ends in the way its first argument names, so that run_worker can be held to its
// promises.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/neutral.h"
#include "preprocess/process/child_process.h"

namespace {

using namespace rhoray;

void hand_back(const std::vector<std::uint64_t>& numbers, int output) {
  formats::FileDescription description;
  description.kind = "neutral-test";
  formats::PackedFileWriter writer(
      output, description,
      {{.name = "numbers", .type = formats::ElementType::U64, .shape = {numbers.size()}, .alignment = 64}});
  writer.write_all("numbers", std::span(numbers));
  writer.commit();
}

void act(const std::string& verb, int input, int output) {
  if (verb == "square") {
    const formats::PackedFile given = formats::PackedFile::from_descriptor(input, "input");
    std::vector<std::uint64_t> numbers;
    for (const std::uint64_t number : given.array<std::uint64_t>("numbers", {0})) numbers.push_back(number * number);
    hand_back(numbers, output);
  } else if (verb == "count-descriptors") {
    std::uint64_t open = 0;
    for (int descriptor = 0; descriptor < 256; ++descriptor)
      open += ::lseek(descriptor, 0, SEEK_CUR) >= 0 || ::isatty(descriptor) ? 1U : 0U;
    hand_back({open}, output);
  } else if (verb == "limits") {  // soft ones
    std::vector<std::uint64_t> numbers;
    for (const auto resource : {RLIMIT_DATA, RLIMIT_FSIZE, RLIMIT_NOFILE, RLIMIT_CORE}) {
      rlimit limit{};
      if (::getrlimit(resource, &limit) != 0) throw Error(ErrorCode::internal, "getrlimit");
      numbers.push_back(limit.rlim_cur);
    }
    hand_back(numbers, output);
  } else if (verb == "answer-without-end") {
    const std::string piece(std::size_t{1} << 20, 'x');
    while (::write(output, piece.data(), piece.size()) > 0) {
    }
    throw Error(ErrorCode::resource, std::strerror(errno));
  } else if (verb == "open-without-end") {
    std::uint64_t count = 0;
    int last = -1;
    for (int opened; (opened = ::open("/dev/null", O_RDONLY)) >= 0; last = opened) ++count;
    const std::string why = std::strerror(errno);
    for (int spare = last - 4; spare <= last; ++spare)
      ::close(spare);  // sanitizers need some to look at what is thrown
    throw Error(ErrorCode::resource, concat(why, " after ", count < 256 ? "fewer" : "more"));
  } else if (verb == "compute-now-and-then") {  // a little more than a tick of 10 ms, and a pause
    for (int round = 0; round < 8; ++round) {
      for (const std::clock_t begin = std::clock(); std::clock() - begin < CLOCKS_PER_SEC / 40;) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    hand_back({1}, output);
  } else if (verb == "write-now-and-then") {
    for (int round = 0; round < 8; ++round) {
      if (::write(STDERR_FILENO, ".", 1) != 1) throw Error(ErrorCode::internal, "write");
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    hand_back({1}, output);
  } else if (verb == "read-a-pipe") {
    int ends[2];
    char byte = 0;
    if (::pipe(ends) != 0 || ::read(ends[0], &byte, 1) != 0) throw Error(ErrorCode::internal, "pipe");
  } else if (verb == "close-and-sleep") {
    ::close(STDERR_FILENO);
    std::this_thread::sleep_for(std::chrono::seconds(60));
  } else if (verb == "lose-bytes") {
    const int file = ::memfd_create("lost", 0);
    if (::ftruncate(file, 4096) != 0) throw Error(ErrorCode::internal, "ftruncate");
    const volatile char* bytes = static_cast<const char*>(::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0));
    if (::ftruncate(file, 0) != 0) throw Error(ErrorCode::internal, "ftruncate");
    std::signal(SIGBUS, SIG_DFL);  // sanitizers would catch it
    hand_back({static_cast<std::uint64_t>(bytes[0])}, output);
  } else if (verb == "refuse") {
    std::fputs("a library's chatter\n", stderr);
    throw Error(ErrorCode::unsupported, "bone.vtu, cells: found 3 hexahedra; expected linear\ntetrahedra",
                "make it tetrahedra");
  } else if (verb == "refuse-controls") {
    std::fputs("chatter \1 of a library\n", stderr);
    throw Error(ErrorCode::invalid, "bone.mhd, key: found 'a\1b\x1b[31m'; expected c", "try\tthis");
  } else if (verb == "throw") {
    throw std::runtime_error("a library's exception");
  } else if (verb == "segfault") {
    std::fputs("about to fall\n", stderr);
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers would catch it
    std::raise(SIGSEGV);
  } else if (verb == "abort") {
    std::abort();
  } else if (verb == "loop") {
    volatile bool forever = true;
    while (forever) {
    }
  } else if (verb == "devour") {
    std::vector<std::vector<char>> pieces;
    for (;;) pieces.emplace_back(16 << 20, 'x');
  } else if (verb == "large-array") {
    const preprocess::Array<std::byte> large(256 << 20, std::byte{1});
    hand_back({large.size()}, output);
  } else if (verb == "chatter") {
    for (int line = 0; line < 200'000; ++line) std::fputs("a line that nobody asked for\n", stderr);
    throw Error(ErrorCode::invalid, "the last word");
  } else if (verb == "progress") {
    std::fputs("an unfinished line ", stderr);
    preprocess::report_worker_progress(3, 8);
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    preprocess::report_worker_progress(8, 8);
    preprocess::report_worker_progress(9, 8);  // too soon after the one before
    hand_back({1}, output);
  } else if (verb == "progress-and-sleep") {
    preprocess::report_worker_progress(1, 2);
    std::this_thread::sleep_for(std::chrono::seconds(60));
  } else if (verb == "print") {
    std::puts("this belongs nowhere");
    hand_back({1}, output);
  } else if (verb == "exit-99") {
    std::fputs("unexpected\n", stderr);
    std::exit(99);
  } else if (verb == "sleep") {
    std::this_thread::sleep_for(std::chrono::seconds(60));
  }  // "nothing": ends well without handing anything over
}

}  // namespace

int main(int count, char** words) {
  const std::string verb = count > 1 ? words[1] : "nothing";
  return preprocess::worker_main([&](int input, int output) { act(verb, input, output); });
}
