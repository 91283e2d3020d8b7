#pragma once

#include <cstdint>

#include "formats/base/checks.h"
#include "render/grid/block_samples.h"

/// Reading samples of a source that has bricks.
namespace rhoray::render::wide {

/// Reads the 5 x 5 x 5 samples of a block, x + 5 y + 25 z; beyond the grid's ends the last samples
/// are repeated. They lie in at most two bricks on each axis, because a brick has at least as many
/// samples as a block has cells.
/// @param first  first sample of the block
template <class T>
void read_block_from_bricks(const SampleSource& source, const int* first, T* values) {
  const int shift = source.bricks.shift;
  std::uint64_t address[3][5];
  int last_of_near[3] = {};  ///< on each axis, the last sample in the first brick
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 5; ++i) {
      const int at = first[a] + i, last = source.count[a] - 1;
      address[a][i] = source.address[a][at < last ? at : last];
      if (address[a][i] >> shift == address[a][0] >> shift) last_of_near[a] = i;
    }
  OneBrick<T> bricks[2][2][2];  // z, y, x: the first and the last on each axis
  for (int b = 0; b < 8; ++b)
    bricks[b >> 2][b >> 1 & 1][b & 1] = OneBrick<T>(
        source, (address[0][4 * (b & 1)] + address[1][4 * (b >> 1 & 1)] + address[2][4 * (b >> 2)]) >> shift);
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 5; ++j) {
      const OneBrick<T>* row = bricks[k > last_of_near[2]][j > last_of_near[1]];
      const std::uint64_t begin = address[1][j] + address[2][k];
      for (int i = 0; i < 5; ++i)
        values[i + 5 * j + 25 * k] = row[i > last_of_near[0]].at_address(begin + address[0][i]);
    }
}

}  // namespace rhoray::render::wide
