#pragma once

#include <array>
#include <cstdint>

#include "formats/base/checks.h"

/// Rays of one octant walk through a mirrored lattice in which every component of their directions
/// is positive or zero. So a ray only moves up in each coordinate, and the order x + 4 y + 16 z of
/// a node's blocks is front to back for all of them.
namespace rhoray::render::wide {

/// Mirrors 64 bits on the axes of the octant. Each (x, y, z), 0 to 3 each, has bit x + 4 y + 16 z.
RHORAY_INLINE std::uint64_t mirrored_bits(std::uint64_t bits, unsigned octant) {
  if (octant & 1) {
    bits = (bits >> 1 & 0x5555555555555555) | (bits & 0x5555555555555555) << 1;
    bits = (bits >> 2 & 0x3333333333333333) | (bits & 0x3333333333333333) << 2;
  }
  if (octant & 2) {
    bits = (bits >> 4 & 0x0f0f0f0f0f0f0f0f) | (bits & 0x0f0f0f0f0f0f0f0f) << 4;
    bits = (bits >> 8 & 0x00ff00ff00ff00ff) | (bits & 0x00ff00ff00ff00ff) << 8;
  }
  if (octant & 4) {
    bits = (bits >> 16 & 0x0000ffff0000ffff) | (bits & 0x0000ffff0000ffff) << 16;
    bits = bits >> 32 | bits << 32;
  }
  return bits;
}

/// A set of coordinates 0 to 3 on an axis (4 bits), as the bits of that axis among the 64 where the
/// other coordinates are 0. The product of sets of different axes is the box that they span.
RHORAY_INLINE std::uint64_t spread_bits(unsigned set, int axis) {
  constexpr std::uint64_t y[16] = {0x0000, 0x0001, 0x0010, 0x0011, 0x0100, 0x0101, 0x0110, 0x0111,
                                   0x1000, 0x1001, 0x1010, 0x1011, 0x1100, 0x1101, 0x1110, 0x1111};
  const auto z = [](unsigned s) {
    return (s & 1) | static_cast<std::uint64_t>(s & 2) << 15 | static_cast<std::uint64_t>(s & 4) << 30 |
           static_cast<std::uint64_t>(s & 8) << 45;
  };
  return axis == 0 ? set : axis == 1 ? y[set] : z(set);
}

/// The coordinates 0 to 3 that lie in first..last, as bits.
RHORAY_INLINE unsigned range_bits(int first, int last) {
  first = first < 0 ? 0 : first;
  last = last > 3 ? 3 : last;
  return first > last ? 0u : (0xfu << first) & (0xfu >> (3 - last));
}

/// The lattice as rays of an octant see it. Mirrored axes begin where the last super node of the
/// occupancy ends, so that blocks, nodes and super nodes map to blocks, nodes and super nodes.
struct MirroredLattice {
  unsigned octant;    ///< bit a: axis a is mirrored
  int node_count[3];  ///< multiples of 4

  RHORAY_INLINE MirroredLattice(unsigned mirrored, const std::array<int, 3>& nodes)
      : octant(mirrored), node_count{nodes[0], nodes[1], nodes[2]} {}

  RHORAY_INLINE bool is_mirrored(int axis) const { return (octant >> axis & 1) != 0; }

  /// Position of mirrored plane k of an axis; exact.
  RHORAY_INLINE double plane(int axis, int k) const { return is_mirrored(axis) ? 16.0 * node_count[axis] - k : k; }

  /// Maps a mirrored block to its block, and vice versa; the same for nodes and super nodes with
  /// their counts.
  RHORAY_INLINE int block(int axis, int mirrored) const {
    return is_mirrored(axis) ? 4 * node_count[axis] - 1 - mirrored : mirrored;
  }
  RHORAY_INLINE int node(int axis, int mirrored) const {
    return is_mirrored(axis) ? node_count[axis] - 1 - mirrored : mirrored;
  }
  RHORAY_INLINE int super_node(int axis, int mirrored) const {
    return is_mirrored(axis) ? node_count[axis] / 4 - 1 - mirrored : mirrored;
  }
};

}  // namespace rhoray::render::wide
