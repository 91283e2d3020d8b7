#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/triangles/facet_block.h"

namespace rhoray::render {

/// The neighbours of a surface's facets across their edges, and the facets' orientation. It depends
/// on the surface alone, and takes longer to compute than most queries. Edge c of a facet goes from
/// corner c to the next one.
///
/// Uses 17 bytes per facet. During construction also 8 bytes per slot of an edge table, with 5 to
/// 10 slots per facet.
class FacetNeighbours {
 public:
  /// What is on the other side of an edge. place_of gives the index of a facet, or one of two
  /// special indices above those of facets. is_alike tells whether it has the same orientation as
  /// this facet. Two facets traversed in the directions that turns() gives then pass the edge in
  /// opposite directions, as parts of one oriented sheet do.
  using Beyond = std::uint32_t;
  static constexpr std::size_t place_of(Beyond beyond) { return beyond / 2; }
  static constexpr unsigned is_alike(Beyond beyond) { return beyond % 2; }  ///< 0 or 1

  std::size_t place_count() const { return beyond_.size() + 2; }
  Beyond no_edge() const { return 2 * count() + 1; }  ///< the edge has no length
  Beyond nothing() const { return 2 * count() + 3; }  ///< no facet, or two and more

  static constexpr std::uint32_t most_facets = std::uint32_t{1} << 30;
  /// @param count  at most most_facets
  /// @param stop   ends it (ErrorCode::interrupted)
  FacetNeighbours(const FacetBlock* blocks, const FacetField* fields, std::uint32_t count,
                  const std::stop_token& stop = {});

  std::uint32_t count() const { return static_cast<std::uint32_t>(beyond_.size()); }
  const std::array<Beyond, 4>& of(std::uint32_t facet) const { return beyond_[facet]; }

  /// The orientation of each facet's corners, seen from the side where the field is higher. A facet
  /// so thin that rounding hides its orientation takes that of its neighbours.
  enum class Turn : std::uint8_t { unknown, counter_clockwise, clockwise };
  const Turn* turns() const { return turns_.data(); }

  std::size_t size_bytes() const { return beyond_.size() * (sizeof(beyond_[0]) + sizeof(turns_[0])); }

 private:
  void find_beyond(const FacetBlock* blocks, const std::stop_token& stop);
  void find_turns(const FacetBlock* blocks, const FacetField* fields, const std::stop_token& stop);

  std::vector<std::array<Beyond, 4>> beyond_;
  std::vector<Turn> turns_;
};

}  // namespace rhoray::render
