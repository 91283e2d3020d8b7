#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace rhoray::study {

namespace hilbert {

/// One state of the curve's recursion: the octant in which it begins, and the axis along which it
/// leaves (C. H. Hamilton, Compact Hilbert indices, 2006, for three dimensions).
struct State {
  unsigned entry = 0, axis = 0;

  constexpr unsigned index() const { return 3 * entry + axis; }
  static constexpr State of(unsigned index) { return {index / 3, index % 3}; }
};
inline constexpr unsigned state_count = 24;

constexpr unsigned rotated_left(unsigned octant, unsigned count) {
  count %= 3;
  return ((octant << count) | (octant >> (3 - count))) & 7;
}
constexpr unsigned gray_code(unsigned rank) {
  return rank ^ (rank >> 1);
}

/// Returns the octant's rank along the curve in this state. The state becomes that of the octant's
/// own part of the curve.
constexpr unsigned step(State& state, unsigned octant) {
  // Rotates to the right by axis + 1.
  const unsigned code = rotated_left(octant ^ state.entry, 2 - state.axis);
  // The number whose Gray code is `code`.
  const unsigned rank = code ^ (code >> 1) ^ (code >> 2);
  const unsigned entry = rank == 0 ? 0 : gray_code((rank - 1) & ~1U);
  const auto turns =
      // Turns of the axis.
      static_cast<unsigned>(rank == 0 ? 0 : std::countr_one(rank % 2 == 0 ? rank - 1 : rank));
  state.entry ^= rotated_left(entry, state.axis + 1);
  state.axis = (state.axis + turns + 1) % 3;
  return rank;
}

/// Three levels of the recursion at once. For a state and three bits of each coordinate, an entry
/// has 9 bits of the position and, above them, the next state.
constexpr auto make_three_levels() {
  std::array<std::uint16_t, std::size_t{state_count} << 9> table{};
  for (unsigned from = 0; from < state_count; ++from)
    for (unsigned bits = 0; bits < 512; ++bits) {
      State state = State::of(from);
      unsigned position = 0;
      for (unsigned level = 3; level-- > 0;) {
        const unsigned octant = (bits >> (6 + level) & 1) | (bits >> (3 + level) & 1) << 1 | (bits >> level & 1) << 2;
        position = position << 3 | step(state, octant);
      }
      table[from << 9 | bits] = static_cast<std::uint16_t>(state.index() << 9 | position);
    }
  return table;
}
inline constexpr auto three_levels = make_three_levels();

}  // namespace hilbert

/// The position of a small cube on a Hilbert curve through a large one of 2^21 x 2^21 x 2^21, from
/// 0 to 2^63 - 1. Cubes at consecutive positions share a face.
/// @param x, y, z  below 2^21
constexpr std::uint64_t hilbert_position(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint64_t position = 0;
  unsigned state = 0;
  for (int level = 18; level >= 0; level -= 3) {
    const unsigned bits = (x >> level & 7) << 6 | (y >> level & 7) << 3 | (z >> level & 7);
    const unsigned found = hilbert::three_levels[state << 9 | bits];
    position = position << 9 | (found & 511);
    state = found >> 9;
  }
  return position;
}

}  // namespace rhoray::study
