#include "preprocess/mesh/subdivide/edge_table.h"

#include "formats/base/error.h"

namespace rhoray::preprocess {

std::uint32_t EdgeTable::find_or_add(const Edge& edge) {
  if (2 * (edges.size() + 1) > slots_.size()) grow();
  std::size_t slot = slot_of(edge.ends);
  for (; slots_[slot] != empty; slot = (slot + 1) & (slots_.size() - 1))
    if (edges[slots_[slot]].ends == edge.ends) return slots_[slot];
  slots_[slot] = static_cast<std::uint32_t>(edges.size());
  edges.push_back(edge);
  return slots_[slot];
}

std::size_t EdgeTable::slot_of(const std::array<std::uint32_t, 2>& ends) const {
  std::uint64_t key = (std::uint64_t{ends[0]} << 32 | ends[1]) * 0x9e3779b97f4a7c15U;
  key ^= key >> 32;
  return key & (slots_.size() - 1);
}

void EdgeTable::grow() {
  if (edges.size() >= empty / 4)
    throw Error(ErrorCode::resource, "curved cells: found more than 2^30 edges; expected fewer",
                "a larger --max-error makes fewer tetrahedra");
  slots_.assign(4 * slots_.size(), empty);
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    std::size_t slot = slot_of(edges[e].ends);
    while (slots_[slot] != empty) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = e;
  }
}

}  // namespace rhoray::preprocess
