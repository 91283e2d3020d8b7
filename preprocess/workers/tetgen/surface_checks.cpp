#include "preprocess/workers/tetgen/surface_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "formats/base/error.h"
#include "preprocess/workers/tetgen/triangle_crossings.h"

namespace rhoray::preprocess {

namespace {

using Point = std::array<double, 3>;
constexpr std::size_t most_places = 5;  // named in a message; more would not be read

std::string text_of(const Point& p) {
  return concat("(", p[0], ", ", p[1], ", ", p[2], ")");
}

bool is_finite(const Point& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

std::uint64_t facet_count(const NeutralSurface& s) {
  return s.facet_offsets.size() - 1;
}

std::span<const std::uint64_t> corners_of(const NeutralSurface& s, std::uint64_t facet) {
  return std::span(s.facet_corners)
      .subspan(s.facet_offsets[facet], s.facet_offsets[facet + 1] - s.facet_offsets[facet]);
}

Point centre_of(const NeutralSurface& s, std::uint64_t facet) {
  Point centre{};
  const auto corners = corners_of(s, facet);
  for (const std::uint64_t c : corners)
    for (std::size_t axis = 0; axis < 3; ++axis)
      centre[axis] += s.points[c][axis] / static_cast<double>(corners.size());
  return centre;
}

/// Places of one kind of fault: how many, and sentences about the first few.
class Places {
 public:
  void add(const std::string& place) {
    if (count_++ < most_places) text_ += concat(text_.empty() ? "" : "; ", place);
  }
  std::uint64_t count() const { return count_; }
  std::string sentence(std::string_view singular, std::string_view plural) const {
    return concat(count_text(count_, singular, plural), ": ", text_, count_ > most_places ? "; ..." : "");
  }

 private:
  std::uint64_t count_ = 0;
  std::string text_;
};

/// What was found, in words and as facets.
struct Findings {
  std::vector<std::string> sentences;
  std::string hint;  ///< of the first sentence
  std::vector<FaultyFacet> facets;

  void add(const Places& places, std::string_view singular, std::string_view plural, std::string_view what_to_do) {
    if (places.count() > 0) add(places.sentence(singular, plural), what_to_do);
  }
  void add(std::string sentence, std::string_view what_to_do) {
    if (sentences.empty()) hint = what_to_do;
    sentences.push_back(std::move(sentence));
  }
  void refuse_if_any() const {
    if (sentences.empty()) return;
    std::string all = "surface: " + sentences.front();
    for (std::size_t i = 1; i < sentences.size(); ++i) all += "; besides, " + sentences[i];
    throw Error(ErrorCode::invalid, all, hint);
  }
};

void check_sizes(const NeutralSurface& s) {
  constexpr std::uint64_t most = std::numeric_limits<int>::max() / 3;  // TetGen counts in int, three per point
  if (s.points.size() < 4 || facet_count(s) < 4)
    throw Error(ErrorCode::invalid, concat("surface: ", s.points.size(), " points and ", facet_count(s),
                                           " facets; expected at least 4 of each"));
  if (s.points.size() > most || facet_count(s) > most)
    throw Error(ErrorCode::unsupported, concat("surface: ", s.points.size(), " points and ", facet_count(s),
                                               " facets; TetGen takes at most ", most, " of each"));
  if (!s.point_sizes.empty() && s.point_sizes.size() != s.points.size())
    throw Error(ErrorCode::invalid, concat("surface: ", s.point_sizes.size(),
                                           " wanted sizes; expected one for each of ", s.points.size(), " points"));
}

void check_sizes_and_seeds(const NeutralSurface& s, Findings& found) {
  Places sizes, seeds;
  for (std::size_t i = 0; i < s.point_sizes.size(); ++i)
    if (!(s.point_sizes[i] >= 0 && std::isfinite(s.point_sizes[i])))
      sizes.add(concat("point ", i, " asks for ", s.point_sizes[i]));
  for (const Point& hole : s.holes)
    if (!is_finite(hole)) seeds.add(concat("hole ", text_of(hole)));
  for (const auto& opening : s.openings)
    if (!is_finite(opening.seed)) seeds.add(concat("opening ", text_of(opening.seed)));
  for (const auto& region : s.regions)
    if (!is_finite(region.seed) || !std::isfinite(region.attribute) || !std::isfinite(region.max_volume))
      seeds.add(concat("region ", text_of(region.seed)));
  found.add(sizes, "target size that is not 0 (none) or positive", "target sizes that are not 0 (none) or positive",
            "correct the sizes");
  found.add(seeds, "seed that is not finite", "seeds that are not finite",
            "correct the seeds of holes, openings and regions");
}

void check_points(const NeutralSurface& s, Findings& found) {
  Places points;
  for (std::size_t i = 0; i < s.points.size(); ++i)
    if (!is_finite(s.points[i])) points.add(concat("point ", i, " is ", text_of(s.points[i])));
  if (points.count() == 0) return;
  found.add(points, "point with a coordinate that is not a finite number",
            "points with a coordinate that is not a finite number", "repair the surface first");
  for (std::uint64_t f = 0; f < facet_count(s); ++f)
    for (const std::uint64_t corner : corners_of(s, f))
      if (!is_finite(s.points[corner])) {
        found.facets.push_back({f, FacetFault::not_finite});
        break;
      }
}

/// Gives points with the same coordinates one number; the others stay behind unused.
void weld(NeutralSurface& s) {
  Array<std::uint64_t> order(s.points.size());
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  std::sort(order.begin(), order.end(), [&](std::uint64_t a, std::uint64_t b) {
    return s.points[a] != s.points[b] ? s.points[a] < s.points[b] : a < b;
  });
  Array<std::uint64_t> first_alike(s.points.size());
  std::uint64_t welded = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool alike = i > 0 && s.points[order[i]] == s.points[order[i - 1]];
    first_alike[order[i]] = alike ? first_alike[order[i - 1]] : order[i];
    welded += alike;
  }
  if (welded == 0) return;
  for (std::uint64_t& corner : s.facet_corners) corner = first_alike[corner];
  s.notes.push_back(concat(welded, " points with the coordinates of another were merged with it"));
}

/// Leaves out points that no facet uses: TetGen would make them vertices of the mesh.
void drop_unused_points(NeutralSurface& s) {
  constexpr std::uint64_t unused = ~std::uint64_t{0};
  Array<std::uint64_t> new_index(s.points.size(), unused);
  for (const std::uint64_t corner : s.facet_corners) new_index[corner] = 0;
  std::uint64_t kept = 0;
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    if (new_index[i] == unused) continue;
    new_index[i] = kept;
    s.points[kept] = s.points[i];
    if (!s.point_sizes.empty()) s.point_sizes[kept] = s.point_sizes[i];
    ++kept;
  }
  s.points.resize(kept);
  if (!s.point_sizes.empty()) s.point_sizes.resize(kept);
  for (std::uint64_t& corner : s.facet_corners) corner = new_index[corner];
}

/// Rings of a face that is made of several may be single points or lines that lie in it.
void check_facets(const NeutralSurface& s, Findings& found) {
  Places flat;
  for (std::uint64_t f = 0; f < facet_count(s); ++f) {
    const auto corners = corners_of(s, f);
    Array<std::uint64_t> sorted(corners.begin(), corners.end());
    std::sort(sorted.begin(), sorted.end());
    const bool repeats = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    if (corners.empty() || (corners.size() < 3 && s.facet_faces.empty()))
      flat.add(concat("facet ", f, " has ", corners.size(), " corners"));
    else if (corners.size() == 3 &&
             (repeats || are_collinear(s.points[corners[0]], s.points[corners[1]], s.points[corners[2]])))
      flat.add(concat("facet ", f, " at ", text_of(centre_of(s, f))));
    else
      continue;
    found.facets.push_back({f, FacetFault::flat});
  }
  found.add(flat, "facet without area", "facets without area", "remove them, or collapse their shortest edges");
}

void check_twins(const NeutralSurface& s, Findings& found) {
  std::vector<Array<std::uint64_t>> keys(facet_count(s));
  for (std::uint64_t f = 0; f < keys.size(); ++f) {
    const auto corners = corners_of(s, f);
    keys[f].assign(corners.begin(), corners.end());
    std::sort(keys[f].begin(), keys[f].end());
  }
  Array<std::uint64_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::uint64_t a, std::uint64_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  Places twice;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (keys[order[i]] == keys[order[i - 1]]) {
      twice.add(concat("facets ", order[i - 1], " and ", order[i], " at ", text_of(centre_of(s, order[i]))));
      found.facets.push_back({order[i], FacetFault::twin});
    }
  found.add(twice, "duplicate facet", "duplicate facets", "touching bodies must share one facet, given once");
}

/// Triangles with what the search for crossings needs, and which facets they are.
struct Triangles {
  std::vector<std::array<std::uint64_t, 3>> corners;
  std::vector<std::uint64_t> facets;
};

Triangles sound_triangles(const NeutralSurface& s, const Findings& found) {
  std::vector<bool> faulty(facet_count(s), false);
  for (const FaultyFacet& f : found.facets) faulty[f.facet] = true;
  Triangles triangles;
  for (std::uint64_t f = 0; f < facet_count(s); ++f)
    if (const auto c = corners_of(s, f); !faulty[f] && c.size() == 3) {
      triangles.corners.push_back({c[0], c[1], c[2]});
      triangles.facets.push_back(f);
    }
  return triangles;
}

void check_crossings(const NeutralSurface& s, const Triangles& triangles, Findings& found) {
  const Crossings crossings = find_crossings(s.points, triangles.corners, most_places);
  if (crossings.pair_count == 0) return;
  std::string places;
  for (const Crossing& c : crossings.first_pairs)
    places += concat(places.empty() ? "" : "; ", "facets ", triangles.facets[c.first], " and ",
                     triangles.facets[c.second], " at ", text_of(c.place));
  found.add(concat(count_text(crossings.pair_count, "pair of facets intersects", "pairs of facets intersect"), ": ",
                   places, crossings.pair_count > crossings.first_pairs.size() ? "; ..." : "", "; expected none"),
            "repair the surface at these places, or make it again from the volume");
  for (const std::uint64_t t : crossings.triangles) found.facets.push_back({triangles.facets[t], FacetFault::crossing});
}

void check_closed(const NeutralSurface& s, const Triangles& triangles, bool solids_may_touch, Findings& found) {
  struct Edge {
    std::uint64_t low, high, facet;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.corners.size());
  for (std::size_t t = 0; t < triangles.corners.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles.corners[t][i], triangles.corners[t][(i + 1) % 3]);
      edges.push_back({low, high, triangles.facets[t]});
    }
  std::sort(edges.begin(), edges.end());
  Places open, crowded;
  for (std::size_t i = 0, next; i < edges.size(); i = next) {
    next = i;
    while (next < edges.size() && edges[next].low == edges[i].low && edges[next].high == edges[i].high) ++next;
    const std::size_t count = next - i;
    if (count == 2 || (solids_may_touch && count % 2 == 0)) continue;
    const std::string place = concat(text_of(s.points[edges[i].low]), " to ", text_of(s.points[edges[i].high]));
    if (count == 1)
      open.add(concat("facet ", edges[i].facet, " at ", place));
    else
      crowded.add(concat(count, " at ", place));
    for (std::size_t k = i; k < next; ++k)
      found.facets.push_back({edges[k].facet, count == 1 ? FacetFault::at_open_edge : FacetFault::at_crowded_edge});
  }
  found.add(open, "open edge (one facet where two should meet)", "open edges (one facet where two should meet)",
            "close the surface; without that its inside is not defined");
  found.add(crowded, "edge where more than two facets meet", "edges where more than two facets meet",
            "separate the parts, or give .smesh with a region seed in each region");
}

/// All that can be told; geometry is looked at only when the points are numbers.
Findings examine(NeutralSurface& surface, bool solids_may_touch) {
  Findings found;
  check_points(surface, found);
  check_sizes_and_seeds(surface, found);
  if (!found.sentences.empty()) return found;
  weld(surface);
  drop_unused_points(surface);
  if (are_coplanar(surface.points))
    throw Error(ErrorCode::invalid, concat("surface: all ", surface.points.size(), " points lie in one plane"),
                "a flat sheet encloses nothing that could be filled");
  check_facets(surface, found);
  if (surface.facet_faces.empty()) check_twins(surface, found);  // a ring may be the outline of a facet beside it

  bool triangles_only = surface.facet_faces.empty();
  for (std::uint64_t f = 0; f < facet_count(surface); ++f)
    triangles_only = triangles_only && corners_of(surface, f).size() <= 3;
  if (!triangles_only) return found;
  const Triangles triangles = sound_triangles(surface, found);
  if (surface.holes.empty() && surface.regions.empty()) check_closed(surface, triangles, solids_may_touch, found);
  check_crossings(surface, triangles, found);
  return found;
}

}  // namespace

NeutralSurface checked_surface(NeutralSurface surface, bool solids_may_touch) {
  check_sizes(surface);
  examine(surface, solids_may_touch).refuse_if_any();
  return surface;
}

std::vector<FaultyFacet> faulty_facets(NeutralSurface surface, bool solids_may_touch) {
  std::vector<FaultyFacet> facets = examine(surface, solids_may_touch).facets;
  const auto order = [](const FaultyFacet& f) { return std::pair(f.facet, f.fault); };
  std::sort(facets.begin(), facets.end(), [&](const auto& a, const auto& b) { return order(a) < order(b); });
  facets.erase(
      std::unique(facets.begin(), facets.end(), [&](const auto& a, const auto& b) { return order(a) == order(b); }),
      facets.end());
  return facets;
}

}  // namespace rhoray::preprocess
