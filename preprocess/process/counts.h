#pragma once

#include <cstdint>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// Sends the result of a worker that writes a file: some counts, as a packed file of kind "counts".
void hand_over_counts(const std::vector<std::uint64_t>& counts, int descriptor);

/// Refuses when there are not as many as expected.
std::vector<std::uint64_t> take_counts(const formats::PackedFile& file, std::size_t expected);

}  // namespace rhoray::preprocess
