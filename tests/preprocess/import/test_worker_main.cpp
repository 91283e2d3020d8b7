// A worker that ends in the way its first argument names, so that run_worker can be held to its promises.

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/trouble.h"
#include "preprocess/neutral.h"
#include "preprocess/worker/child_process.h"

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
  } else if (verb == "refuse") {
    std::fputs("a library's chatter\n", stderr);
    throw Error(Trouble::unsupported, "bone.vtu, cells: found 3 hexahedra; expected linear\ntetrahedra",
                "make it tetrahedra");
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
    throw Error(Trouble::invalid, "the last word");
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
