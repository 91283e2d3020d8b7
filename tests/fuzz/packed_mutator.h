#pragma once

#include <cstddef>
#include <cstdint>

namespace rhoray::tests {

struct MutationOptions {
  bool header_text_too = false;  ///< also changes bytes of the header's text, and the file without sealing it again
};

/// A mutation of a packed file that knows the format: it changes numbers and lists of the metadata, elements and sizes
/// of arrays, both together, and the list of arrays; then it lays the file out again and seals it. Between arrays it
/// leaves at least 64 bytes (guarded.h). What it cannot take apart is changed byte by byte.
/// @return  the new size; the file stands in `data`, which has room for max_size bytes
std::size_t mutate_packed(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                          const MutationOptions& options = {});

}  // namespace rhoray::tests
