#pragma once

#include <cstdint>
#include <string>

namespace rhoray::tests {

/// A packed file with valid checksums and some numbers changed.
struct Mutant {
  std::string bytes;
  std::string description;  ///< what was changed, for messages
};

/// Returns mutant number `index` of a packed file; the same for the same index on every machine.
///
/// One in three changes a number in the header's text; the others change one to three elements of
/// arrays. The new numbers are those that break loops and indices: zero, one, neighbours of the old
/// number, neighbours of powers of two at which types end, infinities, NaN, denormal and very large
/// numbers. Checksums are computed again.
Mutant make_mutant(const std::string& file, std::uint64_t index);

}  // namespace rhoray::tests
