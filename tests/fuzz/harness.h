#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "formats/base/error.h"

/// The interface between a fuzz harness and its driver. The driver is libFuzzer (preset `fuzz`,
/// clang) or replay.cpp (any compiler). A harness defines LLVMFuzzerTestOneInput, and the other two
/// if it needs them.
extern "C" {
int LLVMFuzzerInitialize(int* argc, char*** argv);
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// Changes `data` in place, which has room for `max_size` bytes; returns the new size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);
/// The driver's own mutation, which treats its input as plain bytes.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
}

namespace rhoray::tests {

/// Stops the program unless the refusal is acceptable for a user's bad input: not a defect of ours,
/// one line of text, and not longer than a screen. Prints it when RHORAY_FUZZ_SAY is set.
void check_refusal(const Error& error);

/// A file in memory whose content is replaced for each input, with a name by which it can be opened
/// again.
class InputFile {
 public:
  InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  void put(const std::uint8_t* data, std::size_t size);
  int descriptor() const { return descriptor_; }
  const std::string& path() const { return path_; }

 private:
  int descriptor_;
  std::string path_;
};

}  // namespace rhoray::tests
