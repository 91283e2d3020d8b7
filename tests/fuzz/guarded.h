#pragma once

#include <cstddef>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::tests {

/// With the address sanitizer: while this lives, every byte of a mapped packed file that belongs to no array is
/// forbidden, so that a read beyond an array's end is reported although it stays within the mapping. The mutator leaves
/// room between arrays for that. Without the sanitizer it does nothing.
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
