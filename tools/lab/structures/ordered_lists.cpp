#include "tools/lab/structures/ordered_lists.h"

namespace rhoray::study {

OrderedLists::OrderedLists(const render::TetData& packed, const std::function<void(std::span<std::uint32_t>)>& reorder)
    : packed_(packed) {
  const formats::LeafListsView lists = packed.mesh().leaf_lists();
  first_packed_ = lists.items.data();
  items_.assign(lists.items.begin(), lists.items.end());
  for (std::size_t leaf = 0; leaf + 1 < lists.offsets.size(); ++leaf)
    reorder(std::span(items_).subspan(lists.offsets[leaf], lists.offsets[leaf + 1] - lists.offsets[leaf]));
}

}  // namespace rhoray::study
