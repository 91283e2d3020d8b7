#include "preprocess/mesh/subdivide/refine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "preprocess/mesh/subdivide/comparison.h"
#include "preprocess/mesh/subdivide/edge_table.h"
#include "preprocess/mesh/subdivide/fine_place.h"
#include "preprocess/mesh/subdivide/spread_points.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t grain = 1024;

/// Limits of the number of points or tetrahedra: a constant for any mesh, plus an amount for each
/// curved cell. Cells of real meshes become 6 to a few hundred tetrahedra.
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
constexpr std::size_t most_in_any_mesh = 0;  // a damaged cell reaches the limit, under sanitizers in 90 s
#else
constexpr std::size_t most_in_any_mesh = std::size_t{1} << 19;
#endif
constexpr std::size_t most_per_cell = 4096;

/// In a tetrahedron, a quadratic function differs from its linear interpolant by at most 6/4 of the
/// largest difference at the midpoints of the edges.
constexpr double beyond_edges = 1.5;
/// The same between the sampled centres of faces and tetrahedra, for other kinds: measured, not
/// proved.
constexpr double beyond_middles = 1.25;

// Edges of a tetrahedron by their corners, and the edge between two corners.
constexpr std::uint8_t edge_ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
constexpr std::uint8_t edge_between[4][4] = {{0, 0, 1, 2}, {0, 0, 3, 4}, {1, 3, 0, 5}, {2, 4, 5, 0}};
constexpr std::uint8_t face_corners[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};

struct Tet {
  std::array<std::uint32_t, 4> points;
  std::array<std::uint32_t, 6> edges;
  std::array<FinePlace, 4> places;
  std::uint32_t curved_cell;
};

bool names_a_point_twice(const Tet& tet) {
  const auto& p = tet.points;
  return p[0] == p[1] || p[0] == p[2] || p[0] == p[3] || p[1] == p[2] || p[1] == p[3] || p[2] == p[3];
}

class Refinement {
 public:
  Refinement(CellMesh& mesh, std::span<const CurvedCell> cells, const RefineOptions& options)
      : mesh_(mesh),
        cells_(cells),
        comparison_(mesh, cells, options.counted),
        spread_(mesh, cells),
        options_(options),
        old_point_count_(mesh.points.size()),
        cut_for_(comparison_.share_count(), 0) {
    require_room(mesh.points.size());
  }

  RefinedCells run(std::span<const CornerTetrahedronOfCell> tets, const Progress& progress) {
    Array<Tet> current = taken(tets);
    while (!current.empty()) {
      if (progress) progress("refining curved cells", finished_.size(), 0);
      cut(std::move(current));
      current = unfinished_again();
    }
    return result(tets);
  }

 private:
  Array<Edge>& edges() { return table_.edges; }
  const Array<Edge>& edges() const { return table_.edges; }

  /// A cell whose nodes are far from the positions that its kind expects never follows its
  /// tetrahedra. Without a limit, a damaged file of 300 bytes is cut until the memory is full.
  void require_room(std::size_t count) const {
    const std::size_t most =
        std::min<std::size_t>(no_point - 1, old_point_count_ + most_in_any_mesh + most_per_cell * cells_.size());
    if (count <= most) return;
    throw Error(ErrorCode::resource,
                concat("curved cells: found more than ", most, " points or tetrahedra for ", cells_.size(),
                       " curved cells; expected fewer"),
                "a larger --max-error makes fewer tetrahedra; a damaged cell needs very many");
  }

  std::uint32_t edge_of(std::uint32_t a, std::uint32_t b, FinePlace at_a, FinePlace at_b, std::uint32_t curved_cell) {
    if (a > b) return edge_of(b, a, at_b, at_a, curved_cell);
    spread_.settle(curved_cell, a, at_a, b, at_b);
    double length2 = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = mesh_.points[a][axis] - mesh_.points[b][axis];
      length2 += d * d;
    }
    // a NaN would spoil the order
    if (!(length2 <= std::numeric_limits<double>::max())) length2 = 0;
    return table_.find_or_add({{a, b}, {at_a, at_b}, curved_cell, no_point, length2});
  }

  Array<Tet> taken(std::span<const CornerTetrahedronOfCell> tets) {
    Array<Tet> result;
    result.reserve(tets.size());
    for (const CornerTetrahedronOfCell& from : tets) {
      const CurvedCell& cell = cells_[from.curved_cell];
      Tet& tet = result.emplace_back();
      tet.curved_cell = from.curved_cell;
      for (std::size_t i = 0; i < 4; ++i) {
        tet.points[i] = static_cast<std::uint32_t>(mesh_.cell_nodes[mesh_.cell_offsets[cell.cell] + from.corners[i]]);
        tet.places[i] = fine(cell.shape->node_places()[from.corners[i]]);
      }
      for (std::size_t e = 0; e < 6; ++e) {
        const auto [i, j] = edge_ends[e];
        tet.edges[e] = edge_of(tet.points[i], tet.points[j], tet.places[i], tet.places[j], tet.curved_cell);
      }
    }
    return result;
  }

  /// By length, then by ids: a total order of all edges.
  std::uint32_t longest_edge(const Tet& tet) const {
    std::uint32_t best = 0;
    for (std::uint32_t e = 1; e < 6; ++e) {
      const Edge &a = edges()[tet.edges[e]], &b = edges()[tet.edges[best]];
      if (std::tie(a.length2, a.ends) > std::tie(b.length2, b.ends)) best = e;
    }
    return best;
  }

  bool has_cut_edge(const Tet& tet) const {
    return std::any_of(tet.edges.begin(), tet.edges.end(),
                       [&](std::uint32_t e) { return edges()[e].middle != no_point; });
  }

  /// Cuts tetrahedra and their parts until no error is too large and no longest edge is cut.
  void cut(Array<Tet> current) {
    Array<Tet> next;
    // the index in Shares of the error that is too large
    std::vector<std::optional<std::size_t>> strays;
    while (!current.empty()) {
      measure_new_edges();
      strays.assign(current.size(), std::nullopt);
      parallel_for(current.size(), grain, [&](const IndexRange& part) {
        Scratch scratch(comparison_);
        for (std::size_t t = part.begin(); t < part.end(); ++t) strays[t] = straying_share(current[t], scratch);
      });
      std::vector<std::uint32_t> to_cut;
      for (std::size_t t = 0; t < current.size(); ++t) {
        const std::uint32_t e = current[t].edges[longest_edge(current[t])];
        const bool is_far = strays[t] && may_be_cut(edges()[e]);
        if (is_far) ++cut_for_[*strays[t]];
        if ((is_far || has_cut_edge(current[t])) && edges()[e].middle == no_point) to_cut.push_back(e);
      }
      make_middles(std::move(to_cut));
      next.clear();
      for (const Tet& tet : current) {
        const std::uint32_t e = longest_edge(tet);
        if (edges()[tet.edges[e]].middle == no_point)
          finished_.push_back(tet);
        else
          cut(tet, e, next);
      }
      require_room(finished_.size() + next.size());
      std::swap(current, next);
    }
  }

  /// Both halves keep the orientation: the midpoint replaces one end.
  void cut(const Tet& tet, std::uint32_t e, Array<Tet>& halves) {
    const std::uint8_t i = edge_ends[e][0], j = edge_ends[e][1];
    const std::uint32_t point = edges()[tet.edges[e]].middle;
    FinePlace at_i = tet.places[i], at_j = tet.places[j];
    if (tet.points[i] < tet.points[j])
      spread_.settle(tet.curved_cell, tet.points[i], at_i, tet.points[j], at_j);
    else
      spread_.settle(tet.curved_cell, tet.points[j], at_j, tet.points[i], at_i);
    spread_.add_middle(tet.curved_cell, tet.points[i], tet.points[j], point);
    const FinePlace place = middle(at_i, at_j);
    std::array<std::uint32_t, 4> to_corner;
    for (std::uint8_t k = 0; k < 4; ++k)
      to_corner[k] = edge_of(point, tet.points[k], place, tet.places[k], tet.curved_cell);
    for (const auto& [kept, replaced] : {std::pair{i, j}, std::pair{j, i}}) {
      Tet& half = halves.emplace_back(tet);
      half.points[replaced] = point;
      half.places[replaced] = place;
      for (std::uint8_t k = 0; k < 4; ++k)
        if (k != replaced) half.edges[edge_between[replaced][k]] = to_corner[k];
      // of a collapsed cell, whose nodes coincide
      if (names_a_point_twice(half)) halves.pop_back();
    }
  }

  /// Takes back finished tetrahedra that have an edge cut for a neighbour.
  Array<Tet> unfinished_again() {
    Array<Tet> again;
    std::size_t kept = 0;
    for (const Tet& tet : finished_) {
      if (has_cut_edge(tet))
        again.push_back(tet);
      else
        finished_[kept++] = tet;
    }
    finished_.resize(kept);
    return again;
  }

  bool may_be_cut(const Edge& edge) const {
    const auto& [a, b] = edge.end_places;
    int stretch = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) stretch = std::max(stretch, std::abs(a[axis] - b[axis]));
    return stretch >= options_.finest * fine_steps;
  }

  /// Scratch data of measuring, kept between measurements for its memory.
  struct Scratch {
    explicit Scratch(const Comparison& comparison)
        : weights(comparison.most_nodes()), shares(comparison.share_count()) {}
    std::vector<double> weights;
    Sample curved, straight, end, other_end;
    Shares shares;
  };

  /// Measures the distance between an edge and the cell that represents it. For quadratic
  /// tetrahedra, the midpoint suffices. For other kinds, the number of samples is the number of
  /// possible zeros plus one. The edge's ends are sampled in the same cell. Where neighbours do not
  /// agree about a face, as in a mesh that does not conform, cutting does not repair it.
  void measure_edge(const Edge& edge, Scratch& scratch) const {
    const CellPlace a = coarse(edge.end_places[0]), b = coarse(edge.end_places[1]);
    const int sections = cells_[edge.curved_cell].shape->degree_along_lines();
    scratch.shares.assign(comparison_.share_count(), 0);
    Sample &at_a = scratch.end, &at_b = scratch.other_end;
    comparison_.sample_cell(edge.curved_cell, a, scratch.weights, at_a);
    comparison_.sample_cell(edge.curved_cell, b, scratch.weights, at_b);
    scratch.straight.resize(comparison_.sample_size());
    for (int i = 1; i < sections; ++i) {
      const double t = static_cast<double>(i) / sections;
      const CellPlace place{(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
      comparison_.sample_cell(edge.curved_cell, place, scratch.weights, scratch.curved);
      for (std::size_t k = 0; k < at_a.size(); ++k) scratch.straight[k] = (1 - t) * at_a[k] + t * at_b[k];
      comparison_.raise(scratch.curved, scratch.straight, beyond_edges, scratch.shares);
    }
  }

  void measure_new_edges() {
    const std::size_t width = comparison_.share_count(), begin = edge_shares_.size() / width;
    edge_shares_.resize(edges().size() * width);
    parallel_for(edges().size() - begin, grain, [&](const IndexRange& part) {
      Scratch scratch(comparison_);
      for (std::size_t e = begin + part.begin(); e < begin + part.end(); ++e) {
        measure_edge(edges()[e], scratch);
        std::copy(scratch.shares.begin(), scratch.shares.end(),
                  edge_shares_.begin() + static_cast<std::ptrdiff_t>(e * width));
      }
    });
  }

  std::span<const double> shares_of_edge(std::uint32_t e) const {
    const std::size_t width = comparison_.share_count();
    return std::span(edge_shares_).subspan(e * width, width);
  }

  /// Measures the distance from the cell at the centre of some corners of a tetrahedron.
  void measure_middle(const Tet& tet, std::span<const std::uint8_t> corners, Scratch& scratch) const {
    const double share = 1 / static_cast<double>(corners.size());
    CellPlace rough{}, place{};
    for (const std::uint8_t corner : corners)
      for (std::size_t axis = 0; axis < 3; ++axis) rough[axis] += share * coarse(tet.places[corner])[axis];
    scratch.straight.assign(comparison_.sample_size(), 0);
    for (const std::uint8_t corner : corners) {
      FinePlace settled = tet.places[corner];
      spread_.move(tet.curved_cell, tet.points[corner], settled, fine(rough));
      const CellPlace at = coarse(settled);
      for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += share * at[axis];
      comparison_.sample_cell(tet.curved_cell, at, scratch.weights, scratch.end);
      for (std::size_t i = 0; i < scratch.end.size(); ++i) scratch.straight[i] += share * scratch.end[i];
    }
    comparison_.sample_cell(tet.curved_cell, place, scratch.weights, scratch.curved);
    comparison_.raise(scratch.curved, scratch.straight, 1, scratch.shares);
  }

  /// Raises scratch.shares to the errors at the centres of the tetrahedron and its faces.
  void measure_middles(const Tet& tet, Scratch& scratch) const {
    constexpr std::uint8_t all_corners[] = {0, 1, 2, 3};
    scratch.shares.assign(comparison_.share_count(), 0);
    if (cells_[tet.curved_cell].shape->is_quadratic_in_tetrahedra()) return;  // its edges suffice
    for (const auto& face : face_corners) measure_middle(tet, face, scratch);
    measure_middle(tet, all_corners, scratch);
  }

  /// Returns the index of the largest share when it is too large.
  std::optional<std::size_t> too_large(std::span<const double> shares, double factor) const {
    const auto largest = std::max_element(shares.begin(), shares.end());
    if (!(factor * *largest > options_.max_error)) return std::nullopt;
    return static_cast<std::size_t>(largest - shares.begin());
  }

  /// Returns the index of the share in which a tetrahedron's error is too large: along its edges,
  /// or else in between.
  std::optional<std::size_t> straying_share(const Tet& tet, Scratch& scratch) const {
    scratch.shares.assign(comparison_.share_count(), 0);
    raise_to_edges(tet, scratch.shares);
    if (const std::optional<std::size_t> share = too_large(scratch.shares, 1)) return share;
    measure_middles(tet, scratch);
    return too_large(scratch.shares, beyond_middles);
  }

  void raise_to_edges(const Tet& tet, Shares& shares) const {
    for (const std::uint32_t e : tet.edges)
      for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = std::max(shares[i], shares_of_edge(e)[i]);
  }

  /// Returns the cell's own node in the middle of an edge. Returns no_point when there is none, or
  /// when it is an end (collapsed cells).
  std::uint32_t node_in_middle(const Edge& edge) const {
    const CurvedCell& cell = cells_[edge.curved_cell];
    const CellPlace wanted = coarse(middle(edge.end_places[0], edge.end_places[1]));
    const auto places = cell.shape->node_places();
    const auto found = std::find(places.begin(), places.end(), wanted);
    if (found == places.end()) return no_point;
    const auto node = static_cast<std::uint64_t>(found - places.begin());
    const auto point = static_cast<std::uint32_t>(mesh_.cell_nodes[mesh_.cell_offsets[cell.cell] + node]);
    return point == edge.ends[0] || point == edge.ends[1] ? no_point : point;
  }

  void make_middles(std::vector<std::uint32_t> to_cut) {
    std::sort(to_cut.begin(), to_cut.end());
    to_cut.erase(std::unique(to_cut.begin(), to_cut.end()), to_cut.end());
    const std::size_t old_count = mesh_.points.size();
    std::vector<std::uint32_t> made;
    for (const std::uint32_t e : to_cut) {
      Edge& edge = edges()[e];
      edge.middle = node_in_middle(edge);
      if (edge.middle != no_point) continue;
      edge.middle = static_cast<std::uint32_t>(old_count + made.size());
      made.push_back(e);
    }
    const std::size_t count = old_count + made.size();
    require_room(count);
    mesh_.points.resize(count);
    for (NeutralField& field : mesh_.point_fields)
      field.values.resize(count * static_cast<std::size_t>(field.component_count));
    parallel_for(made.size(), grain, [&](const IndexRange& part) {
      Scratch scratch(comparison_);
      for (std::size_t i = part.begin(); i < part.end(); ++i) {
        const Edge& edge = edges()[made[i]];
        comparison_.sample_cell(edge.curved_cell, coarse(middle(edge.end_places[0], edge.end_places[1])),
                                scratch.weights, scratch.curved);
        comparison_.store(scratch.curved, old_count + i);
      }
    });
  }

  RefinementError error() const {
    const std::size_t width = comparison_.share_count(), part_count = (finished_.size() + grain - 1) / grain;
    std::vector<Shares> parts(part_count, Shares(width, 0));
    parallel_for_each(part_count, [&](std::size_t part) {
      Scratch scratch(comparison_);
      for (std::size_t t = part * grain; t < std::min(finished_.size(), (part + 1) * grain); ++t) {
        measure_middles(finished_[t], scratch);
        raise_to_edges(finished_[t], scratch.shares);
        for (std::size_t i = 0; i < width; ++i) parts[part][i] = std::max(parts[part][i], scratch.shares[i]);
      }
    });
    Shares largest(width, 0);
    for (const Shares& part : parts)
      for (std::size_t i = 0; i < width; ++i) largest[i] = std::max(largest[i], part[i]);
    return {.geometric = largest.front(), .of_fields = {largest.begin() + 1, largest.end()}};
  }

  /// @param source  the tetrahedra at the start
  RefinedCells result(std::span<const CornerTetrahedronOfCell> source) const {
    std::vector<std::size_t> places(cells_.size() + 1, 0);
    for (const Tet& tet : finished_) ++places[tet.curved_cell + 1];
    for (std::size_t c = 0; c < cells_.size(); ++c) places[c + 1] += places[c];
    RefinedCells refined;
    refined.cut_cells = count_cut_cells(source, places);
    refined.cut_for = cut_for_;
    refined.tets.resize(finished_.size());
    refined.curved_cells.resize(finished_.size());
    for (const Tet& tet : finished_) {
      const std::size_t place = places[tet.curved_cell]++;
      std::copy(tet.points.begin(), tet.points.end(), refined.tets[place].begin());
      refined.curved_cells[place] = tet.curved_cell;
    }
    refined.error = error();
    return refined;
  }

  /// @param first_tets  for each curved cell its first tetrahedron of the result, and at the end
  ///                    their number
  std::uint64_t count_cut_cells(std::span<const CornerTetrahedronOfCell> source,
                                const std::vector<std::size_t>& first_tets) const {
    std::vector<std::size_t> counts(cells_.size(), 0);
    for (const CornerTetrahedronOfCell& tet : source) ++counts[tet.curved_cell];
    std::uint64_t cut = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c)
      if (first_tets[c + 1] - first_tets[c] > counts[c]) ++cut;
    return cut;
  }

  CellMesh& mesh_;
  std::span<const CurvedCell> cells_;
  Comparison comparison_;
  SpreadPoints spread_;
  RefineOptions options_;
  std::size_t old_point_count_;
  EdgeTable table_;
  Array<double> edge_shares_;  ///< Shares of each edge
  Array<Tet> finished_;
  std::vector<std::uint64_t> cut_for_;  ///< as in RefinedCells
};

}  // namespace

RefinedCells refine(CellMesh& mesh, std::span<const CurvedCell> cells, std::span<const CornerTetrahedronOfCell> tets,
                    const RefineOptions& options, const Progress& progress) {
  return Refinement(mesh, cells, options).run(tets, progress);
}

}  // namespace rhoray::preprocess
