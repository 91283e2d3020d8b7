#include "render/triangles/facet_neighbours.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "formats/base/checks.h"
#include "formats/base/stopping.h"
#include "render/triangles/facet_block.h"

namespace rhoray::render {

namespace {

constexpr std::uint64_t facets_per_check = 1 << 11;

struct Corner {
  float at[3];

  Corner(const FacetBlock* blocks, std::uint32_t facet, unsigned c) {
    const auto& corner = blocks[facet / FacetBlock::size].corner[c % 4];
    for (std::size_t a = 0; a < 3; ++a) at[a] = corner[a][facet % FacetBlock::size];
  }
  bool operator==(const Corner& other) const {
    return at[0] == other.at[0] && at[1] == other.at[1] && at[2] == other.at[2];
  }
  Vec3 operator-(const Corner& other) const {
    const auto along = [&](std::size_t a) { return static_cast<double>(at[a]) - static_cast<double>(other.at[a]); };
    return {along(0), along(1), along(2)};
  }
  std::uint32_t hash() const {
    constexpr std::uint32_t factor[3] = {0xed55'8ccd, 0x1a85'ec53, 0x6659'fd93};
    std::uint32_t sum = 0;
    // Adding 0 turns -0 into +0.
    for (std::size_t a = 0; a < 3; ++a) sum += factor[a] * std::bit_cast<std::uint32_t>(at[a] + 0.0F);
    return (sum ^ sum >> 15) * 0x2c1b'3c6d;
  }
};

/// The edges seen so far, each with the facet that had it first. Open addressing.
class Edges {
 public:
  struct Edge {
    static constexpr std::uint32_t none = 0xffffffff;
    std::uint32_t place = none;  ///< 4 * facet + c
    std::uint32_t hash = 0;      ///< the same for both directions
  };

  explicit Edges(std::size_t most) : edges_(std::bit_ceil(most + most / 4 + 1)) {}

  /// Returns the edge with this hash for which `is` is true, or a free slot for it.
  template <class Is>
  Edge& find(std::uint32_t hash, const Is& is) {
    const std::size_t last = edges_.size() - 1;
    for (std::size_t at = (hash ^ hash >> 16) & last;; at = (at + 1) & last) {
      Edge& edge = edges_[at];
      if (edge.place == Edge::none || (edge.hash == hash && is(edge.place))) return edge;
    }
  }

 private:
  std::vector<Edge> edges_;
};

}  // namespace

FacetNeighbours::FacetNeighbours(const FacetBlock* blocks, const FacetField* fields, std::uint32_t count,
                                 const std::stop_token& stop)
    : beyond_(count), turns_(count, Turn::unknown) {
  RHORAY_CHECK(count <= most_facets);
  for (auto& of_facet : beyond_) of_facet.fill(nothing());
  find_beyond(blocks, stop);
  find_turns(blocks, fields, stop);
  for (std::uint32_t f = 0; f < count; ++f)
    for (Beyond& beyond : beyond_[f])
      if (place_of(beyond) < count) beyond ^= static_cast<Beyond>(turns_[f] != turns_[place_of(beyond)]);
}

/// At this stage two facets are alike when, traversed from corner to corner, they pass their edge
/// in opposite directions.
void FacetNeighbours::find_beyond(const FacetBlock* blocks, const std::stop_token& stop) {
  const Beyond several = nothing() + 2;
  Edges edges(4 * beyond_.size());
  for_each_until_stopped(0, beyond_.size(), facets_per_check, stop, [&](std::uint64_t facet) {
    const auto f = static_cast<std::uint32_t>(facet);
    const Corner corner[5] = {{blocks, f, 0}, {blocks, f, 1}, {blocks, f, 2}, {blocks, f, 3}, {blocks, f, 0}};
    std::uint32_t hash[5];
    for (std::size_t c = 0; c < 4; ++c) hash[c] = corner[c].hash();
    hash[4] = hash[0];
    for (unsigned c = 0; c < 4; ++c) {
      const Corner &from = corner[c], &to = corner[c + 1];
      if (from == to) {
        beyond_[f][c] = no_edge();
        continue;
      }
      bool is_alike = false;
      Edges::Edge& edge = edges.find(hash[c] + hash[c + 1], [&](std::uint32_t place) {
        const Corner begin(blocks, place / 4, place % 4), end(blocks, place / 4, place % 4 + 1);
        is_alike = begin == to && end == from;
        return is_alike || (begin == from && end == to);
      });
      if (edge.place == Edges::Edge::none) {
        edge = {4 * f + c, hash[c] + hash[c + 1]};
        continue;
      }
      const std::uint32_t first = edge.place / 4;
      Beyond& of_first = beyond_[first][edge.place % 4];
      if (of_first == nothing()) {
        of_first = 2 * f + is_alike, beyond_[f][c] = 2 * first + is_alike;
        continue;
      }
      // A third facet or more at this edge.
      if (of_first != several)
        for (Beyond& of_second : beyond_[place_of(of_first)])
          if (place_of(of_second) == first) of_second = several;
      of_first = beyond_[f][c] = several;
    }
  });
  for (auto& of_facet : beyond_)
    for (Beyond& beyond : of_facet)
      if (beyond == several) beyond = nothing();
}

void FacetNeighbours::find_turns(const FacetBlock* blocks, const FacetField* fields, const std::stop_token& stop) {
  std::vector<std::uint32_t> thin;
  for_each_until_stopped(0, beyond_.size(), facets_per_check, stop, [&](std::uint64_t facet) {
    const auto f = static_cast<std::uint32_t>(facet);
    const Corner a(blocks, f, 0), b(blocks, f, 1), c(blocks, f, 2), d(blocks, f, 3);
    const Vec3 ac = c - a, bd = d - b, normal = ac.cross(bd);
    const FacetField& field = fields[f];
    const Vec3 gradient(field.gradient[0], field.gradient[1], field.gradient[2]);
    const double along = normal.dot(gradient), largest = normal.length() * gradient.length();
    // Corners have an error of 2^-25. The error of the normal does not matter as long as its side
    // is certain.
    if (normal.length() > 0x1p-18 * (ac.length() + bd.length()) && std::abs(along) > largest / 2)
      turns_[f] = along > 0 ? Turn::counter_clockwise : Turn::clockwise;
    else
      thin.push_back(f);
  });
  const auto turn_as_a_neighbour = [&](std::uint32_t f) {
    for (const Beyond beyond : beyond_[f]) {
      if (place_of(beyond) >= count() || turns_[place_of(beyond)] == Turn::unknown) continue;
      const bool is_clockwise = turns_[place_of(beyond)] == Turn::clockwise;
      turns_[f] = is_clockwise == (is_alike(beyond) != 0) ? Turn::clockwise : Turn::counter_clockwise;
      return true;
    }
    return false;
  };
  for (bool any = true; any;) {
    end_if_stopped(stop);
    const auto left = std::remove_if(thin.begin(), thin.end(), turn_as_a_neighbour);
    any = left != thin.end();
    thin.erase(left, thin.end());
  }
  for (const std::uint32_t f : thin) turns_[f] = Turn::counter_clockwise;
}

}  // namespace rhoray::render
