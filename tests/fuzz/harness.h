#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "formats/base/error.h"

/// What a fuzz harness and its driver say to each other. The driver is libFuzzer (preset `fuzz`, clang) or replay.cpp
/// (any compiler). A harness defines LLVMFuzzerTestOneInput, and the other two where it needs them.
extern "C" {
int LLVMFuzzerInitialize(int* argc, char*** argv);
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// Changes `data` in place, which has room for `max_size` bytes; returns the new size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);
/// The driver's own mutation, which knows bytes only.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
}

namespace rhoray::tests {

/// Stops the program unless the refusal is what a user may see for bad input: no defect of ours, one line of text, and
/// not longer than a screen. Prints it when RHORAY_FUZZ_SAY is set.
void check_refusal(const Error& error);

/// A file in memory whose content is replaced for each input, and the name by which it can be opened again.
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
