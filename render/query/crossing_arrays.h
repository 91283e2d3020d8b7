#pragma once

#include <cstddef>
#include <cstdint>

#include "render/query/all_hits.h"
#include "render/query/batch_arrays.h"

namespace rhoray::render::wide {

/// The crossings with one surface as plain arrays.
struct CrossingArrays {
  HitArrays hits[CrossingList::most];
  std::uint8_t* count;
};

inline CrossingArrays arrays_of(CrossingList& list) {
  CrossingArrays arrays{.hits = {}, .count = list.count.data()};
  for (std::size_t k = 0; k < CrossingList::most; ++k) arrays.hits[k] = arrays_of(list.hits(k));
  return arrays;
}

}  // namespace rhoray::render::wide
