#include "preprocess/tetrahedralize/surface_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "formats/base/trouble.h"
#include "preprocess/tetrahedralize/triangle_crossings.h"

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

/// Faults of one kind: how many, and sentences about the first few.
class Faults {
 public:
  void add(const std::string& place) {
    if (count_++ < most_places) places_ += concat(places_.empty() ? "" : "; ", place);
  }
  std::uint64_t count() const { return count_; }

  void refuse_if_any(std::string_view what, std::string_view hint) const {
    if (count_ == 0) return;
    throw Error(Trouble::invalid,
                concat("surface: ", count_, " ", what, ": ", places_, count_ > most_places ? "; ..." : ""),
                std::string(hint));
  }

 private:
  std::uint64_t count_ = 0;
  std::string places_;
};

void check_sizes(const NeutralSurface& s) {
  constexpr std::uint64_t most = std::numeric_limits<int>::max() / 3;  // TetGen counts in int, three per point
  if (s.points.size() < 4 || facet_count(s) < 4)
    throw Error(Trouble::invalid, concat("surface: ", s.points.size(), " points and ", facet_count(s),
                                         " facets; expected at least 4 of each"));
  if (s.points.size() > most || facet_count(s) > most)
    throw Error(Trouble::unsupported, concat("surface: ", s.points.size(), " points and ", facet_count(s),
                                             " facets; TetGen takes at most ", most, " of each"));
  if (!s.point_sizes.empty() && s.point_sizes.size() != s.points.size())
    throw Error(Trouble::invalid, concat("surface: ", s.point_sizes.size(), " wanted sizes; expected one for each of ",
                                         s.points.size(), " points"));
}

void check_numbers(const NeutralSurface& s) {
  Faults points, sizes, seeds;
  for (std::size_t i = 0; i < s.points.size(); ++i)
    if (!is_finite(s.points[i])) points.add(concat("point ", i, " is ", text_of(s.points[i])));
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
  points.refuse_if_any("points with a coordinate that is not a finite number", "repair the surface first");
  sizes.refuse_if_any("wanted sizes that are not 0 (none) or positive", "correct the sizes");
  seeds.refuse_if_any("seeds that are not finite numbers", "correct the seeds of holes, openings and regions");
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
void check_facets(const NeutralSurface& s) {
  Faults flat;
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
  }
  flat.refuse_if_any("facets without area", "remove them, or collapse their shortest edges");
}

void check_duplicates(const NeutralSurface& s) {
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
  Faults twice;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (keys[order[i]] == keys[order[i - 1]])
      twice.add(concat("facets ", order[i - 1], " and ", order[i], " at ", text_of(centre_of(s, order[i]))));
  twice.refuse_if_any("facets that are there twice", "touching bodies must share one facet, given once");
}

void check_crossings(const NeutralSurface& s, std::span<const std::array<std::uint64_t, 3>> triangles) {
  const Crossings found = find_crossings(s.points, triangles, most_places);
  if (found.pair_count == 0) return;
  std::string places;
  for (const Crossing& c : found.first_pairs)
    places += concat(places.empty() ? "" : "; ", "facets ", c.first, " and ", c.second, " at ", text_of(c.place));
  throw Error(Trouble::invalid,
              concat("surface: ", found.pair_count, " pairs of facets cross: ", places,
                     found.pair_count > found.first_pairs.size() ? "; ..." : "", "; expected none"),
              "mend the surface at these places, or make it anew from the volume");
}

void check_closed(const NeutralSurface& s, std::span<const std::array<std::uint64_t, 3>> triangles) {
  std::vector<std::array<std::uint64_t, 2>> edges;
  edges.reserve(3 * triangles.size());
  for (const auto& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = std::minmax(t[i], t[(i + 1) % 3]);
      edges.push_back({a, b});
    }
  std::sort(edges.begin(), edges.end());
  Faults open, crowded;
  for (std::size_t i = 0, next; i < edges.size(); i = next) {
    next = i;
    while (next < edges.size() && edges[next] == edges[i]) ++next;
    if (next - i == 2) continue;
    const std::string place = concat(text_of(s.points[edges[i][0]]), " to ", text_of(s.points[edges[i][1]]));
    if (next - i == 1)
      open.add(place);
    else
      crowded.add(concat(next - i, " at ", place));
  }
  open.refuse_if_any("open edges (one facet where two should meet)", "close the surface: its inside is not defined");
  crowded.refuse_if_any("edges where more than two facets meet",
                        "separate the parts, or give .smesh with a region seed in each chamber");
}

}  // namespace

NeutralSurface checked_surface(NeutralSurface surface) {
  check_sizes(surface);
  check_numbers(surface);
  weld(surface);
  drop_unused_points(surface);
  if (are_coplanar(surface.points))
    throw Error(Trouble::invalid, concat("surface: all ", surface.points.size(), " points lie in one plane"),
                "a flat sheet encloses nothing that could be filled");
  check_facets(surface);
  if (surface.facet_faces.empty()) check_duplicates(surface);  // a ring may be the outline of a facet beside it

  std::vector<std::array<std::uint64_t, 3>> triangles;
  for (std::uint64_t f = 0; f < facet_count(surface); ++f)
    if (const auto c = corners_of(surface, f); c.size() == 3) triangles.push_back({c[0], c[1], c[2]});
  if (triangles.size() != facet_count(surface) || !surface.facet_faces.empty()) return surface;
  if (surface.holes.empty() && surface.regions.empty()) check_closed(surface, triangles);
  check_crossings(surface, triangles);
  return surface;
}

}  // namespace rhoray::preprocess
