// Fuzzes the reader of packed files: seal, header, arrays, checksums.
#include <algorithm>

#include "formats/base/checks.h"
#include "formats/packed_file.h"
#include "tests/fuzz/harness.h"
#include "tests/fuzz/packed_mutator.h"

namespace {

using namespace rhoray;

/// Checks what every reader of the library relies on.
void check_layout(const formats::PackedFile& file) {
  std::uint64_t end = 0;
  for (const formats::ArrayEntry& array : file.arrays()) {
    RHORAY_CHECK(array.first_byte >= end && array.first_byte % 64 == 0);
    RHORAY_CHECK(array.byte_count <= file.file_bytes() && array.first_byte <= file.file_bytes() - array.byte_count);
    end = array.first_byte + array.byte_count;
    std::uint64_t elements = 1;
    for (const std::uint64_t size : array.shape) elements *= size;
    RHORAY_CHECK(elements == array.element_count());
  }
}

/// Reads an array with its own shape, and with a shape that it does not have.
void read_array(const formats::PackedFile& file, const formats::ArrayEntry& array) {
  formats::with_element_type(array.type, [&]<class T>(T) {
    const std::span<const T> values = file.array<T>(array.name, std::span(array.shape));
    RHORAY_CHECK(values.size() == array.element_count());
    T sum{};
    for (const T value : values) sum = static_cast<T>(value != value || value > sum ? value : sum);
    [[maybe_unused]] volatile T kept = sum;
    std::vector<std::uint64_t> other = array.shape;
    other.push_back(1);
    try {
      (void)file.array<T>(array.name, std::span(other));
      RHORAY_CHECK(false && "an array with another shape is refused");
    } catch (const Error& error) {
      tests::check_refusal(error);
    }
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tests::InputFile input;
  input.put(data, size);
  try {
    const formats::PackedFile file = formats::PackedFile::from_descriptor(input.descriptor(), "input.rho");
    RHORAY_CHECK(formats::PackedFile::looks_packed(input.path()));
    check_layout(file);
    for (const formats::ArrayEntry& array : file.arrays()) read_array(file, array);
    std::uint64_t end = 0;
    for (const formats::DamagedBlock& block : file.damaged_blocks(1)) {
      RHORAY_CHECK(block.first_byte >= end && block.byte_count > 0);
      end = block.first_byte + block.byte_count;
      RHORAY_CHECK(end <= file.file_bytes());
    }
  } catch (const Error& error) {
    tests::check_refusal(error);
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return tests::mutate_packed(data, size, max_size, seed, {.header_text_too = true});
}
