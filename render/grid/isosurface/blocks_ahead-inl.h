// A group's list of blocks ahead: as soon as each ray has one, all rays pass theirs together, each
// in its own lane.
#if defined(RHORAY_WIDE_BLOCKS_AHEAD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_BLOCKS_AHEAD_INL_H
#undef RHORAY_WIDE_BLOCKS_AHEAD_INL_H
#else
#define RHORAY_WIDE_BLOCKS_AHEAD_INL_H
#endif

#include <cstdint>

#include <hwy/highway.h>

#include "render/grid/isosurface/parts.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The slot in which a block's samples are kept, and the key that identifies the block.
struct KeptPlace {
  std::size_t place;
  std::uint64_t key;
};
/// @param block  not mirrored, or mirrored if all blocks are mirrored the same way
template <class Block>
HWY_INLINE KeptPlace kept_place_of(const int* block) {
  KeptPlace at{0, 0};
  int shift = 0;
  for (int a = 0; a < 3; ++a) {
    const auto position = static_cast<std::uint64_t>(block[a]);
    at.place |= (position & ((1U << Block::place_bits[a]) - 1)) << shift;
    at.key |= position << (21 * a);
    shift += Block::place_bits[a];
  }
  return at;
}

template <class Block>
HWY_INLINE void clear(ListOfBlocks<Block>& ahead) {
  ahead.count = 0, ahead.rays = 0;
  for (std::uint64_t& places : ahead.places) places = 0;
}

/// True where the list has room and keeps no other block in the same slot.
template <class Block>
HWY_INLINE bool fits(const ListOfBlocks<Block>& ahead, const int* block) {
  const std::size_t place = kept_place_of<Block>(block).place;
  return ahead.count < ListOfBlocks<Block>::capacity && (ahead.places[place / 64] >> place % 64 & 1) == 0;
}

/// Toggles whether a block's slot is taken.
template <class Block>
HWY_INLINE void turn_place(ListOfBlocks<Block>& ahead, const int* block) {
  const std::size_t place = kept_place_of<Block>(block).place;
  ahead.places[place / 64] ^= std::uint64_t{1} << place % 64;
}

/// Adds a block of which only the position and the rays are known.
template <class Block>
HWY_INLINE Block& add(ListOfBlocks<Block>& ahead, const int* block, std::uint64_t rays) {
  Block& added = ahead.block[ahead.count++];
  for (int a = 0; a < 3; ++a) added.block[a] = block[a];
  added.rays = rays;
  ahead.rays |= rays;
  turn_place(ahead, block);
  return added;
}

/// Lets each ray that has blocks ahead pass the first of them.
/// @param alive  rays that still have blocks to pass; passing may remove some of them
/// @param fetch  (block), called before any ray passes it
/// @param pass   (first ray, lanes from there): the lanes that have taken blocks
/// @param settle (block), called when the rays of all blocks before it are known; returns the rays
///               for which it is kept
template <class Block, class Fetch, class Pass, class Settle>
HWY_INLINE void pass_first_ahead(ListOfBlocks<Block>& ahead, const std::uint64_t& alive, std::size_t ray_count,
                                 Fetch&& fetch, Pass&& pass, Settle&& settle) {
  std::uint64_t waiting = alive;
  for (std::size_t b = 0; b < ahead.count; ++b) {
    Block& block = ahead.block[b];
    block.taken = block.rays & waiting;
    block.rays &= ~block.taken;
    waiting &= ~block.taken;
    if (block.taken != 0) fetch(block);
  }
  const std::uint64_t going = alive & ~waiting;
  for (std::size_t r = 0; r < ray_count; r += float_lanes)
    if (const std::uint64_t lanes = going >> r & first_rays(float_lanes); lanes != 0) pass(r, lanes);
  std::size_t kept = 0;
  ahead.rays = 0;
  for (std::size_t b = 0; b < ahead.count; ++b) {
    if ((settle(ahead.block[b]) & alive) == 0) {
      turn_place(ahead, ahead.block[b].block);
      continue;
    }
    ahead.rays |= ahead.block[b].rays;
    if (kept != b) ahead.block[kept] = ahead.block[b];
    ++kept;
  }
  ahead.count = kept;
}
template <class Block, class Fetch, class Pass>
HWY_INLINE void pass_first_ahead(ListOfBlocks<Block>& ahead, const std::uint64_t& alive, std::size_t ray_count,
                                 Fetch&& fetch, Pass&& pass) {
  pass_first_ahead(ahead, alive, ray_count, fetch, pass, [](const Block& block) { return block.rays; });
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
