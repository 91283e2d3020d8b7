#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/triangles/facet_block.h"

namespace rhoray::render {

/// Which facets of a surface meet at their edges, and how they are turned: it depends on the surface alone, and takes
/// longer to find out than most that is asked about it. Edge c of a facet goes from corner c to the next one.
///
/// 17 bytes a facet; and while it is found, 8 bytes for each place of a table of edges, of which there are 5 to 10 for
/// each facet.
class FacetNeighbours {
 public:
  /// What lies beyond an edge: a facet, or one of two places behind those of facets; and whether it is turned as the
  /// facet itself, so that, passed round the ways that turns() says, they pass the edge in opposite ways, as parts of
  /// one sheet do.
  using Beyond = std::uint32_t;
  static constexpr std::size_t place_of(Beyond beyond) { return beyond / 2; }
  static constexpr unsigned is_alike(Beyond beyond) { return beyond % 2; }  ///< 0 or 1

  std::size_t place_count() const { return beyond_.size() + 2; }
  Beyond no_edge() const { return 2 * count() + 1; }  ///< it has no length
  Beyond nothing() const { return 2 * count() + 3; }  ///< or two facets and more

  static constexpr std::uint32_t most_facets = std::uint32_t{1} << 30;
  /// @param count  at most most_facets
  FacetNeighbours(const FacetBlock* blocks, const FacetField* fields, std::uint32_t count);

  std::uint32_t count() const { return static_cast<std::uint32_t>(beyond_.size()); }
  const std::array<Beyond, 4>& of(std::uint32_t facet) const { return beyond_[facet]; }

  /// How the corners of each turn, seen from where the field is higher. Of a facet so thin that rounding hides it: as
  /// its neighbours are turned.
  enum class Turn : std::uint8_t { unknown, counter_clockwise, clockwise };
  const Turn* turns() const { return turns_.data(); }

  std::size_t size_bytes() const { return beyond_.size() * (sizeof(beyond_[0]) + sizeof(turns_[0])); }

 private:
  void find_beyond(const FacetBlock* blocks);
  void find_turns(const FacetBlock* blocks, const FacetField* fields);

  std::vector<std::array<Beyond, 4>> beyond_;
  std::vector<Turn> turns_;
};

}  // namespace rhoray::render
