#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "render/traverse/octant.h"

namespace rhoray::render::wide {

/// Encloses the rays of a group while they cross a slab of the mirrored lattice. All of them lie
/// between planes first and last of the major axis and, on each of the other two axes, between two
/// rising lines.
struct Frustum {
  struct Line {
    double at_zero, slope;
    RHORAY_INLINE double at(double w) const { return at_zero + w * slope; }
  };

  int major;
  int minor[2];        ///< in rising order
  double first, last;  ///< on the major axis
  Line low[2], high[2];
};

/// Cells of some size on both minor axes, from the first to the last that the frustum meets in a
/// slab.
struct SlabRectangle {
  int first[2], last[2];

  RHORAY_INLINE bool is_empty() const { return first[0] > last[0] || first[1] > last[1]; }
};

/// floor(x), or the nearer of the two ends if it lies outside [lowest, highest]; lowest for NaN.
RHORAY_INLINE int floored_within(double x, int lowest, int highest) {
  const double within = x > lowest ? (x < highest ? x : highest) : lowest;
  const int whole = static_cast<int>(within);
  return whole - (within < whole);
}

/// @param slab   number of the slab of `edge` planes
/// @param count  cells of this size per axis
RHORAY_INLINE SlabRectangle rectangle_in_slab(const Frustum& frustum, int slab, int edge, const int* count) {
  const double low = slab * static_cast<double>(edge), high = low + edge, scale = 1.0 / edge;
  const double w_low = low < frustum.first ? frustum.first : low, w_high = high > frustum.last ? frustum.last : high;
  SlabRectangle cells;
  for (int m = 0; m < 2; ++m) {
    const int end = count[frustum.minor[m]];
    const double from = frustum.low[m].at(w_low) * scale, to = frustum.high[m].at(w_high) * scale;
    cells.first[m] = floored_within(from, 0, end);
    cells.last[m] = floored_within(to, -1, end - 1);
  }
  return cells;
}

/// Index computations for an array with one number for each node or super node of the lattice.
struct MirroredPlaces {
  std::ptrdiff_t first = 0, step[3];

  /// @param count  nodes or super nodes per axis
  RHORAY_INLINE MirroredPlaces(const MirroredLattice& lattice, const int* count)
      : step{1, count[0], static_cast<std::ptrdiff_t>(count[0]) * count[1]} {
    for (int a = 0; a < 3; ++a)
      if (lattice.is_mirrored(a)) first += (count[a] - 1) * step[a], step[a] = -step[a];
  }

  /// Index of the element with these coordinates along axes w, u, v.
  RHORAY_INLINE std::ptrdiff_t of(int w, int at_w, int u, int at_u, int v, int at_v) const {
    return first + at_w * step[w] + at_u * step[u] + at_v * step[v];
  }
};

/// Calls visit(block) for the blocks that have a bit and that the frustum meets, with positions in
/// the mirrored lattice. The order is front to back for each ray of the group. Ends when visit
/// returns false. Visit may make the frustum narrower; this takes effect at the next slab of nodes.
/// @param nodes, super_nodes  as in Occupancy, or the union of several
template <class Words, class Visit>
RHORAY_INLINE void walk_blocks(const Frustum& frustum, const MirroredLattice& lattice, const Words& nodes,
                               const Words& super_nodes, Visit&& visit) {
  const int w = frustum.major, u = frustum.minor[0], v = frustum.minor[1];
  const int* node_count = lattice.node_count;
  const int super_node_count[3] = {node_count[0] / 4, node_count[1] / 4, node_count[2] / 4};
  const int first_node = floored_within(frustum.first / 16, 0, node_count[w] - 1),
            last_node = floored_within(frustum.last / 16, 0, node_count[w] - 1);

  const MirroredPlaces node_places(lattice, node_count), super_node_places(lattice, super_node_count);
  for (int slab = first_node; slab <= last_node; ++slab) {
    if (slab == first_node || slab % 4 == 0) {
      const SlabRectangle high = rectangle_in_slab(frustum, slab / 4, 64, super_node_count);
      std::uint64_t any = 0;
      for (int j = high.first[1]; j <= high.last[1]; ++j)
        for (int i = high.first[0]; i <= high.last[0]; ++i)
          any |= super_nodes[super_node_places.of(w, slab / 4, u, i, v, j)];
      if (any == 0) {
        slab |= 3;
        continue;
      }
    }
    const SlabRectangle cells = rectangle_in_slab(frustum, slab, 16, node_count);
    SlabRectangle blocks[4];
    bool has_blocks = false;
    for (int j = cells.first[1]; j <= cells.last[1]; ++j)
      for (int i = cells.first[0]; i <= cells.last[0]; ++i) {
        const std::uint64_t stored = nodes[node_places.of(w, slab, u, i, v, j)];
        if (stored == 0) continue;
        if (!has_blocks) {
          const int block_count[3] = {4 * node_count[0], 4 * node_count[1], 4 * node_count[2]};
          for (int s = 0; s < 4; ++s) blocks[s] = rectangle_in_slab(frustum, 4 * slab + s, 4, block_count);
          has_blocks = true;
        }
        std::uint64_t met = 0;
        for (int s = 0; s < 4; ++s)
          met |= spread_bits(range_bits(blocks[s].first[0] - 4 * i, blocks[s].last[0] - 4 * i), u) *
                 spread_bits(range_bits(blocks[s].first[1] - 4 * j, blocks[s].last[1] - 4 * j), v) *
                 spread_bits(1u << s, w);
        for (std::uint64_t bits = met & mirrored_bits(stored, lattice.octant); bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          int block[3];
          block[w] = 4 * slab, block[u] = 4 * i, block[v] = 4 * j;
          block[0] += bit & 3, block[1] += bit >> 2 & 3, block[2] += bit >> 4;
          if (!visit(static_cast<const int*>(block))) return;
        }
      }
  }
}

}  // namespace rhoray::render::wide
