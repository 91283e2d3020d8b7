#pragma once

#include <cstddef>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::tests {

/// Makes padding inaccessible for the address sanitizer. While an object lives, every byte of a
/// mapped packed file that belongs to no array is poisoned. A read beyond an array's end is then
/// reported although it stays within the mapping. The mutator leaves room between arrays for this.
/// Has no effect without the sanitizer.
class GuardedPadding {
 public:
  explicit GuardedPadding(const formats::PackedFile& file);
  GuardedPadding(const GuardedPadding&) = delete;
  GuardedPadding& operator=(const GuardedPadding&) = delete;
  ~GuardedPadding();

 private:
  formats::PackedFile file_;  ///< keeps the mapping
  const std::byte* start_ = nullptr;
};

}  // namespace rhoray::tests
