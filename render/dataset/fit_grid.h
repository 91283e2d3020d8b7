#pragma once

#include "render/dataset/loaded_dataset.h"

namespace rhoray::render::wide {

/// The dataset's grid if SIMD kernels accept it, else null: a uniform grid whose samples can be
/// addressed directly, whose macro levels are trees of 64 children and whose bricks are no smaller
/// than the blocks of the lowest level.
inline const UniformGrid* fit_grid(const LoadedDataset& dataset) {
  const auto* grid = std::get_if<UniformGrid>(&dataset.view);
  if (grid == nullptr || !grid->source() || grid->lattice().factor != 4) return nullptr;
  const SampleSource::Bricks& bricks = grid->source()->bricks;
  return bricks.slots == nullptr || bricks.shift >= 6 ? grid : nullptr;
}

}  // namespace rhoray::render::wide
