#pragma once

#include <cstddef>
#include <cstdint>

namespace rhoray::tests {

struct MutationOptions {
  /// Whether to change also bytes of the header's text, and the file without sealing it again.
  bool header_text_too = false;
};

/// Mutates a packed file with knowledge of the format. Changes numbers and lists of the metadata,
/// elements and sizes of arrays, both together, and the list of arrays. Then lays the file out
/// again and seals it, with at least 64 bytes between arrays (guarded.h). A file that it cannot
/// take apart is changed byte by byte.
/// @return  the new size; the file is in `data`, which has room for max_size bytes
std::size_t mutate_packed(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                          const MutationOptions& options = {});

}  // namespace rhoray::tests
