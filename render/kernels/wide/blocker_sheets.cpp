#include "render/kernels/wide/blocker_sheets.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <utility>

namespace rhoray::render::wide {

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

/// A place as the light sees it; sums and products of what single precision holds are nearly exact in double.
struct Place {
  double x, y;
};

/// Twice the area that is passed round counter-clockwise.
double turn(const Place& a, const Place& b, const Place& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

using Corner = std::array<float, 3>;

std::uint64_t mixed(std::uint64_t bits) {
  bits *= 0x9e37'79b9'7f4a'7c15;
  return bits ^ bits >> 32;
}

std::uint64_t hash_of(const Corner& p) {
  constexpr std::uint64_t factor[3] = {0xff51'afd7'ed55'8ccd, 0xc4ce'b9fe'1a85'ec53, 0xd6e8'feb8'6659'fd93};
  std::uint64_t sum = 0;
  for (std::size_t a = 0; a < 3; ++a)
    sum += factor[a] * std::bit_cast<std::uint32_t>(p[a] + 0.0F);  // of zeros there are two
  return sum;
}

/// A facet as the light sees it, counter-clockwise.
struct SeenFacet {
  int count;  ///< of its corners
  Corner corner[4];
  Place place[4];
  std::uint64_t hash[4];  ///< of the corners
  std::uint32_t edge[4];  ///< from each corner to the next: where it stands among Edges
  float lowest;           ///< height

  int next(int c) const { return c + 1 < count ? c + 1 : 0; }
};

/// Facets that keep their side of every edge when their corners move by the margin.
std::vector<SeenFacet> seen_facets(const SeenFromLight& seen, double margin, std::span<const FacetCorners> facets) {
  std::vector<SeenFacet> all;
  all.reserve(facets.size());
  for (const FacetCorners& of : facets) {
    SeenFacet& facet = all.emplace_back();
    facet.count = of[2] == of[3] ? 3 : 4, facet.lowest = nowhere;
    double size = 0;
    for (int c = 0; c < facet.count; ++c) {
      const Corner& p = facet.corner[c] = of[static_cast<std::size_t>(c)];
      const auto along = [&](int axis) { return static_cast<double>(p[static_cast<std::size_t>(axis)]); };
      const double w = along(seen.height_axis());
      const Place here = {along(seen.place_axis(0)) - seen.slope(0) * w, along(seen.place_axis(1)) - seen.slope(1) * w};
      facet.place[c] = here;
      facet.hash[c] = hash_of(p);
      facet.lowest = std::min(facet.lowest, static_cast<float>(seen.sign() * w));
      size = std::max({size, std::abs(here.x - facet.place[0].x), std::abs(here.y - facet.place[0].y)});
    }
    const Place* p = facet.place;
    const double abc = turn(p[0], p[1], p[2]), acd = facet.count == 4 ? turn(p[0], p[2], p[3]) : abc;
    // Each corner moves by the margin: sides are at most 4 sizes long, all together.
    const double least = 16 * margin * (size + margin);
    if (!((abc > least && acd > least) || (abc < -least && acd < -least))) {
      all.pop_back();
      continue;
    }
    if (abc > 0) continue;
    std::reverse(facet.corner, facet.corner + facet.count);
    std::reverse(facet.place, facet.place + facet.count);
    std::reverse(facet.hash, facet.hash + facet.count);
  }
  return all;
}

/// How often each edge is passed, by which its facets lie on either side of it, once each, or not. Open addressing.
class Edges {
 public:
  /// @param facets  their edges are given their places
  explicit Edges(std::span<SeenFacet> facets) : facets_(facets) {
    std::size_t most = 0;
    for (const SeenFacet& facet : facets) most += static_cast<std::size_t>(facet.count);
    edges_.resize(std::bit_ceil(most + most / 4 + 1));
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      for (int c = 0; c < facets[f].count; ++c) pass(f, c);
  }

  bool is_inner(std::uint32_t place) const { return edges_[place].up == 1 && edges_[place].down == 1; }
  std::uint32_t first_facet(std::uint32_t place) const { return edges_[place].facet; }

 private:
  struct Edge {
    static constexpr std::uint32_t none = 0xffffffff;
    std::uint32_t facet = none;  ///< that was the first to pass it, upwards
    std::uint8_t c = 0, up = 0, down = 0;
  };

  void pass(std::uint32_t f, int c) {
    SeenFacet& facet = facets_[f];
    const Corner &from = facet.corner[c], &to = facet.corner[facet.next(c)];
    const std::size_t last = edges_.size() - 1;
    for (std::size_t at = mixed(facet.hash[c] + facet.hash[facet.next(c)]) & last;; at = (at + 1) & last) {
      Edge& edge = edges_[at];
      if (edge.facet == Edge::none) edge.facet = f, edge.c = static_cast<std::uint8_t>(c);
      const SeenFacet& first = facets_[edge.facet];
      const Corner &begin = first.corner[edge.c], &end = first.corner[first.next(edge.c)];
      const bool is_up = begin == from && end == to;
      if (!is_up && !(begin == to && end == from)) continue;
      facet.edge[c] = static_cast<std::uint32_t>(at);
      std::uint8_t& count = is_up ? edge.up : edge.down;
      count = count == 0 ? 1 : 2;
      return;
    }
  }

  std::span<SeenFacet> facets_;
  std::vector<Edge> edges_;
};

/// The squares, taken larger by a margin, that the box around some places touches.
struct TouchedSquares {
  int from[2], to[2];

  TouchedSquares(const Squares& squares, double margin, std::initializer_list<Place> places) {
    Place low{nowhere, nowhere}, high{-nowhere, -nowhere};
    for (const Place& p : places) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)}, high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    const double least[2] = {low.x - margin, low.y - margin}, most[2] = {high.x + margin, high.y + margin};
    for (int i = 0; i < 2; ++i) {
      const auto square = [&](double at) {
        return static_cast<int>(std::clamp((at - squares.first[i]) * squares.per_length, 0.0, squares.count[i] - 1.0));
      };
      from[i] = square(least[i]), to[i] = square(most[i]);
    }
  }
};

std::size_t row_of(const Squares& squares, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(squares.count[0]);
}

/// The facets in an order in which those of a sheet, that share inner edges, stand together.
class Sheets {
 public:
  Sheets(std::span<const SeenFacet> facets, const Edges& edges) : sheet_of_(facets.size()), order_(facets.size()) {
    std::iota(sheet_of_.begin(), sheet_of_.end(), 0U);
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      for (int c = 0; c < facets[f].count; ++c)
        if (const std::uint32_t edge = facets[f].edge[c]; edges.first_facet(edge) != f && edges.is_inner(edge))
          join(f, edges.first_facet(edge));
    std::vector<std::uint32_t> place(facets.size() + 1, 0);
    for (std::uint32_t f = 0; f < facets.size(); ++f) ++place[(sheet_of_[f] = first_of(f)) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (std::uint32_t f = 0; f < facets.size(); ++f) order_[place[sheet_of_[f]]++] = f;
  }

  /// Calls act(numbers of its facets) for each.
  template <class Act>
  void for_each(const Act& act) const {
    for (std::size_t first = 0, end = 0; first < order_.size(); first = end) {
      for (end = first; end < order_.size() && sheet_of_[order_[end]] == sheet_of_[order_[first]];) ++end;
      act(std::span(order_).subspan(first, end - first));
    }
  }

 private:
  /// Of those that are known to be of one sheet.
  std::uint32_t first_of(std::uint32_t facet) {
    while (sheet_of_[facet] != facet) facet = sheet_of_[facet] = sheet_of_[sheet_of_[facet]];
    return facet;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a), b = first_of(b);
    sheet_of_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<std::uint32_t> sheet_of_, order_;
};

/// What is found out square by square, sheet after sheet.
class SheetSquares {
 public:
  explicit SheetSquares(const Squares& squares, double margin)
      : squares_(squares), margin_(margin), of_sheet_(squares.size()), heights_(squares.size() + 1, -nowhere) {}

  /// Adds a facet to the sheet: it covers the middles between the edges through which it is left towards lower and
  /// higher x.
  void add(const SeenFacet& facet) {
    const Place* p = facet.place;
    const TouchedSquares touched(squares_, margin_, {p[0], p[1], p[2], p[facet.count - 1]});
    double per_y[4];
    for (int c = 0; c < facet.count; ++c) {
      const Place &a = p[c], &b = p[facet.next(c)];
      per_y[c] = a.y == b.y ? 0 : (b.x - a.x) / (b.y - a.y);
    }
    for (int y = touched.from[1]; y <= touched.to[1]; ++y) {
      OfSheet* row = of_sheet_.data() + row_of(squares_, y);
      for (int x = touched.from[0]; x <= touched.to[0]; ++x) row[x].lowest = std::min(row[x].lowest, facet.lowest);
      const double middle = squares_.first[1] + (y + 0.5) / squares_.per_length;
      double low = -nowhere, high = nowhere;
      bool is_met = true;
      for (int c = 0; c < facet.count; ++c) {
        const Place &a = p[c], &b = p[facet.next(c)];
        const double x = a.x + (middle - a.y) * per_y[c];
        if (b.y > a.y)
          high = std::min(high, x);
        else if (b.y < a.y)
          low = std::max(low, x);
        else
          is_met &= (b.x > a.x) == (middle > a.y);
      }
      if (!is_met || !(low < high)) continue;
      const auto to_squares = [&](double x) { return (x - squares_.first[0]) * squares_.per_length - 0.5; };
      const int first = std::max(touched.from[0], static_cast<int>(std::ceil(to_squares(low))));
      const int last = std::min(touched.to[0], static_cast<int>(std::floor(to_squares(high))));
      for (int x = first; x <= last; ++x) row[x].is_covered = true;
    }
  }

  /// The squares that touch an edge at which the sheet ends are not known to be covered by it.
  void end_at(const Place& a, const Place& b) {
    const TouchedSquares touched(squares_, margin_, {a, b});
    for (int y = touched.from[1]; y <= touched.to[1]; ++y) {
      OfSheet* row = of_sheet_.data() + row_of(squares_, y);
      for (int x = touched.from[0]; x <= touched.to[0]; ++x) row[x].has_rim = true;
    }
  }

  /// Takes over what was found of the sheet, in the squares that a facet of it touches.
  void finish(const SeenFacet& facet) {
    const Place* p = facet.place;
    const TouchedSquares touched(squares_, margin_, {p[0], p[1], p[2], p[facet.count - 1]});
    for (int y = touched.from[1]; y <= touched.to[1]; ++y) {
      const std::size_t row = row_of(squares_, y);
      for (std::size_t s = row + static_cast<std::size_t>(touched.from[0]);
           s <= row + static_cast<std::size_t>(touched.to[0]); ++s) {
        const OfSheet found = of_sheet_[s];
        if (found.is_covered && !found.has_rim) heights_[s] = std::max(heights_[s], found.lowest);
        of_sheet_[s] = {};
      }
    }
  }

  std::vector<float>& heights() { return heights_; }

 private:
  struct OfSheet {
    float lowest = nowhere;   ///< of the facets that touch the square
    bool is_covered = false;  ///< its middle, by a facet
    bool has_rim = false;
  };

  const Squares& squares_;
  const double margin_;
  std::vector<OfSheet> of_sheet_;
  std::vector<float> heights_;
};

}  // namespace

std::vector<float> heights_below_sheets(const SeenFromLight& seen, const Squares& squares, double margin,
                                        std::span<const FacetCorners> facets) {
  std::vector<SeenFacet> of_sheets = seen_facets(seen, margin, facets);
  const Edges edges(of_sheets);
  SheetSquares found(squares, margin);
  Sheets(of_sheets, edges).for_each([&](std::span<const std::uint32_t> sheet) {
    for (const std::uint32_t f : sheet) {
      const SeenFacet& facet = of_sheets[f];
      found.add(facet);
      for (int c = 0; c < facet.count; ++c)
        if (!edges.is_inner(facet.edge[c])) found.end_at(facet.place[c], facet.place[facet.next(c)]);
    }
    for (const std::uint32_t f : sheet) found.finish(of_sheets[f]);
  });
  return std::move(found.heights());
}

}  // namespace rhoray::render::wide
