#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>

#include "formats/base/stopping.h"
#include "formats/details/range_checks.h"

namespace rhoray::formats::details {
namespace {

constexpr std::uint64_t width = ClusterShape::width;
constexpr std::uint64_t range_piece = 1 << 12;  // cells, leaf cells or clusters
constexpr std::uint64_t stop_piece = 64;        // of these, between two checks of the stop token

Vec3 to_vec(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

template <class T>
bool have_data(std::span<const T> values, const std::array<std::uint32_t, 4>& vertices) {
  return std::all_of(vertices.begin(), vertices.end(), [&](std::uint32_t v) { return is_value(values[v]); });
}

/// Calls act(index) for each index, with the threads and the watch of a check.
template <class Act>
void for_each_watched(const char* phase, std::uint64_t count, const CheckOptions& options, const Act& act) {
  ProgressMeter meter(options.watch.progress, phase, count);
  for_each_until_stopped(count, range_piece, stop_piece, options.threads, options.watch.stop, act, &meter);
}

// ---- leaf lists ---------------------------------------------------------------------------------

/// A tetrahedron in units of leaf cells, relative to the low corner of the lattice.
///
/// A box and a tetrahedron are disjoint exactly when their projections onto some axis are disjoint.
/// The axes to test are those of the box, the face normals, and the cross products of box axes and
/// edges. Any direction that separates them is a valid proof, so rounding of the direction itself
/// does no harm.
class TetInLattice {
 public:
  /// Leaf cells are enlarged by this much on every side, in leaf cells. It far exceeds rounding,
  /// which reaches 2e-10 at 2^20 leaf cells on an axis. A packer has to list tetrahedra within this
  /// distance.
  static constexpr double margin = 1e-8;

  TetInLattice(const LeafLattice& lattice, const std::array<Vec3, 4>& points) {
    std::array<Vec3, 4> q;
    for (std::size_t v = 0; v < 4; ++v) q[v] = (points[v] - lattice.low) / lattice.leaf_size;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [lo, hi] = std::minmax({q[0][axis], q[1][axis], q[2][axis], q[3][axis]});
      const double last = static_cast<double>(lattice.macro.leaf_count[axis] - 1);
      first_[axis] = static_cast<std::int64_t>(std::clamp(std::floor(lo - margin), 0.0, last));
      end_[axis] = static_cast<std::int64_t>(std::clamp(std::floor(hi + margin), 0.0, last)) + 1;
    }
    const std::array<Vec3, 6> edges{q[1] - q[0], q[2] - q[0], q[3] - q[0], q[2] - q[1], q[3] - q[1], q[3] - q[2]};
    std::size_t next = 0;
    const auto add = [&](const Vec3& normal) {
      const auto [lo, hi] = std::minmax({normal.dot(q[0]), normal.dot(q[1]), normal.dot(q[2]), normal.dot(q[3])});
      directions_[next++] = {normal, lo, hi};
    };
    for (const Vec3& face :
         {edges[0].cross(edges[1]), edges[0].cross(edges[2]), edges[1].cross(edges[2]), edges[3].cross(edges[4])})
      add(face);
    for (const Vec3& edge : edges) {
      add({0, edge.z, -edge.y});
      add({-edge.z, 0, edge.x});
      add({edge.y, -edge.x, 0});
    }
  }

  /// Leaf cells of the tetrahedron's bounding box: first <= leaf cell < end.
  const Index3& first() const { return first_; }
  const Index3& end() const { return end_; }

  /// True when no point of the tetrahedron lies in these leaf cells, which must be inside its
  /// bounding box.
  bool is_apart_from(const Index3& first, const Index3& end) const {
    const Vec3 middle = 0.5 * (Vec3(first) + Vec3(end)), half = 0.5 * (Vec3(end) - Vec3(first)) + Vec3(margin);
    for (const Direction& d : directions_) {
      const double at = d.normal.dot(middle);
      const double reach =
          std::abs(d.normal.x) * half.x + std::abs(d.normal.y) * half.y + std::abs(d.normal.z) * half.z;
      if (at + reach < d.lo || at - reach > d.hi) return true;
    }
    return false;
  }

 private:
  struct Direction {
    Vec3 normal;
    double lo, hi;  ///< of the tetrahedron's projection
  };
  std::array<Direction, 22> directions_;
  Index3 first_, end_;
};

/// Calls visit(leaf cell) until it returns false, for all leaf cells that a tetrahedron touches and
/// some close to them. Halves the tetrahedron's block of leaf cells down to a few cells. So the
/// work grows with the leaf cells touched, not with those of the bounding box.
template <class Visit>
bool for_leaves_near(const TetInLattice& tet, const Index3& first, const Index3& end, const std::stop_token& stop,
                     Visit& visit) {
  constexpr std::int64_t few = 32;
  const Index3 size = end - first;
  if (volume(size) > few) {
    end_if_stopped(stop);
    const bool is_around_all = first == tet.first() && end == tet.end();
    if (!is_around_all && tet.is_apart_from(first, end)) return true;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    Index3 middle_end = end, middle_first = first;
    middle_end[axis] = middle_first[axis] = first[axis] + size[axis] / 2;
    return for_leaves_near(tet, first, middle_end, stop, visit) && for_leaves_near(tet, middle_first, end, stop, visit);
  }
  for (std::int64_t z = first.z; z < end.z; ++z)
    for (std::int64_t y = first.y; y < end.y; ++y)
      for (std::int64_t x = first.x; x < end.x; ++x)
        if (!visit({x, y, z})) return false;
  return true;
}

class LeafLists {
 public:
  LeafLists(const TetMesh& mesh, const CheckOptions& options, Findings& findings)
      : mesh_(mesh),
        lattice_(mesh.description().lattice),
        leaf_count_(static_cast<std::uint64_t>(volume(lattice_.macro.leaf_count))),
        options_(options),
        findings_(findings) {}

  void check() {
    if (!check_points(mesh_, options_, findings_)) return;  // otherwise cells may lie outside the lattice
    for_each_watched("checking leaf lists (cells)", mesh_.description().cell_count, options_,
                     [&](std::uint64_t cell) { check_cell(cell); });
  }

  template <class T>
  void check_ranges(std::size_t field) {
    const std::span<const T> values = mesh_.values<T>(field);
    const MacroLevelsView<T> levels = mesh_.macro_levels<T>(field);
    const std::string what = concat("macro levels of field '", mesh_.description().fields[field].name, "'");
    for_each_watched("checking ranges (leaf cells)", leaf_count_, options_,
                     [&](std::uint64_t leaf) { check_range<T>(leaf, values, levels.ranges[0], what); });
    check_levels_upward(levels, what, options_, findings_);
  }

 private:
  void check_cell(std::uint64_t cell) {
    std::array<Vec3, 4> points;
    for (std::size_t v = 0; v < 4; ++v) points[v] = to_vec(mesh_.points()[mesh_.cell(cell)[v]]);
    const TetInLattice tet(lattice_, points);
    const auto is_listed_or_apart = [&](const Index3& at) {
      const std::uint64_t leaf = linear_order(lattice_.macro.leaf_count, at.x, at.y, at.z);
      const std::span<const std::uint32_t> list = mesh_.leaf_lists().list(leaf);
      if (std::binary_search(list.begin(), list.end(), static_cast<std::uint32_t>(cell))) return true;
      if (tet.is_apart_from(at, at + Index3(1, 1, 1))) return true;
      findings_.add("a cell missing from the list of a leaf cell that it touches", cell,
                    [&] { return concat("cell ", cell, " touches leaf ", leaf, ", which lists ", list.size()); });
      return false;  // one leaf cell is enough for a finding
    };
    for_leaves_near(tet, tet.first(), tet.end(), options_.watch.stop, is_listed_or_apart);
  }

  template <class T>
  void check_range(std::uint64_t leaf, std::span<const T> values, std::span<const T> ranges, const std::string& what) {
    Interval<T> needed;
    for (const std::uint32_t cell : mesh_.leaf_lists().list(leaf)) {
      const std::array<std::uint32_t, 4> vertices = mesh_.cell(cell);
      if (!have_data(values, vertices)) continue;
      for (const std::uint32_t v : vertices) needed.include(values[v]);
    }
    const Interval<T> stored{ranges[2 * leaf], ranges[2 * leaf + 1]};
    if (holds(stored, needed)) return;
    findings_.add(concat(what, ": an interval lacks a value of its leaf cell"), leaf, [&] {
      return concat("leaf ", leaf, " has ", interval_text(stored), ", the cells of its list need ",
                    interval_text(needed));
    });
  }

  const TetMesh& mesh_;
  const LeafLattice& lattice_;
  std::uint64_t leaf_count_;
  const CheckOptions& options_;
  Findings& findings_;
};

// ---- clusters -----------------------------------------------------------------------------------

std::string entry_text(int level, std::uint64_t entry) {
  return concat("entry ", entry, " of level ", level);
}

/// Checks that every entry above level 0 contains the block below it, on the calling thread.
/// @param text_of  (entry, its block, the block below): stored range, and the range needed
template <class Block, class Holds, class TextOf>
void check_upward(const ClusterShape& shape, const std::vector<std::span<const Block>>& levels, const std::string& what,
                  const CheckOptions& options, Findings& findings, const Holds& holds_below, const TextOf& text_of) {
  for (int level = 1; level <= shape.top_level(); ++level) {
    const auto l = static_cast<std::size_t>(level);
    for_each_until_stopped(0, shape.count(level), range_piece, options.watch.stop, [&](std::uint64_t entry) {
      const Block &block = levels[l][entry / width], &below = levels[l - 1][entry];
      if (!holds_below(entry % width, block, below))
        findings.add(what, entry,
                     [&] { return concat(entry_text(level, entry), text_of(entry % width, block, below)); });
    });
  }
}

Interval<float> box_interval(const BoxBlock& block, std::size_t entry, std::size_t axis) {
  return {block.lo[axis][entry], block.hi[axis][entry]};
}

/// The range that a block's entries need on an axis. Entries beyond the last are empty and do not
/// count.
Interval<float> needed_box(const BoxBlock& below, std::size_t axis) {
  Interval<float> needed;
  for (std::size_t e = 0; e < width; ++e)
    if (!box_interval(below, e, axis).is_empty()) needed.include(box_interval(below, e, axis));
  return needed;
}

bool holds_boxes(std::size_t entry, const BoxBlock& block, const BoxBlock& below) {
  bool all = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t e = 0; e < width; ++e)  // written so that a NaN does not hold
      all = all && block.lo[axis][entry] <= below.lo[axis][e] && block.hi[axis][entry] >= below.hi[axis][e];
  return all;
}

std::string box_text(const CellClustersView& clusters, std::size_t entry, const BoxBlock& block) {
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Interval<double> side{static_cast<double>(block.lo[axis][entry]) * clusters.box_unit,
                                static_cast<double>(block.hi[axis][entry]) * clusters.box_unit};
    text += concat(axis == 0 ? "" : " x ", interval_text(side));
  }
  return text;
}

void check_box(const TetMesh& mesh, std::uint64_t cluster, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  const BoxBlock& block = clusters.boxes[0][cluster / width];
  std::array<Interval<double>, 3> box;
  for (std::size_t axis = 0; axis < 3; ++axis)
    box[axis] = {static_cast<double>(block.lo[axis][cluster % width]) * clusters.box_unit,
                 static_cast<double>(block.hi[axis][cluster % width]) * clusters.box_unit};
  for (const std::uint32_t vertex : clusters.table(cluster)) {
    const std::array<double, 3>& p = mesh.points()[vertex];
    if (box[0].contains(p[0]) && box[1].contains(p[1]) && box[2].contains(p[2])) continue;
    findings.add("a cluster that reaches out of its box", cluster, [&] {
      return concat("cluster ", cluster, " has ", box_text(clusters, cluster % width, block), ", its point ", vertex,
                    " lies at (", p[0], ", ", p[1], ", ", p[2], ")");
    });
    return;
  }
}

void check_boxes(const TetMesh& mesh, const CheckOptions& options, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  for_each_watched("checking boxes (clusters)", clusters.cluster_count(), options,
                   [&](std::uint64_t cluster) { check_box(mesh, cluster, findings); });
  check_upward(clusters.shape, clusters.boxes, "a box that does not hold those below it", options, findings,
               holds_boxes, [&](std::size_t entry, const BoxBlock& block, const BoxBlock& below) {
                 BoxBlock needed{};
                 for (std::size_t axis = 0; axis < 3; ++axis)
                   needed.lo[axis][0] = needed_box(below, axis).lo, needed.hi[axis][0] = needed_box(below, axis).hi;
                 return concat(" has ", box_text(clusters, entry, block), ", below it ", box_text(clusters, 0, needed));
               });
}

template <class T>
Interval<T> needed_range(const RangeBlock<T>& below) {
  Interval<T> needed;
  for (std::size_t e = 0; e < width; ++e)
    if (below.lo[e] <= below.hi[e]) needed.include({below.lo[e], below.hi[e]});
  return needed;
}

/// The range of the values of those of a cluster's cells that have data.
template <class T>
Interval<T> needed_range(const CellClustersView& clusters, std::uint64_t cluster, std::span<const T> values) {
  Interval<T> range;
  for (std::uint64_t cell = clusters.first_cell(cluster); cell < clusters.end_cell(cluster); ++cell) {
    const std::array<std::uint32_t, 4> vertices = clusters.cell(cell);
    if (!have_data(values, vertices)) continue;
    for (const std::uint32_t v : vertices) range.include(values[v]);
  }
  return range;
}

/// The range of the values at a cluster's vertices. It equals that of the cells if all vertices
/// have data; nothing if one has none.
template <class T>
std::optional<Interval<T>> range_of_table(std::span<const std::uint32_t> table, std::span<const T> values) {
  Interval<T> range;
  T gap = 0;  // NaN where a value is not finite
  for (const std::uint32_t vertex : table) {
    const T value = values[vertex];
    gap += value - value;
    range.include(value);
  }
  return gap == 0 ? std::optional(range) : std::nullopt;
}

template <class T>
void check_cluster_ranges(const TetMesh& mesh, std::size_t field, const CheckOptions& options, Findings& findings) {
  const CellClustersView& clusters = mesh.clusters();
  const ClusterRangesView<T> levels = mesh.cluster_ranges<T>(field);
  const std::span<const T> values = mesh.values<T>(field);
  const std::string what = concat("ranges of field '", mesh.description().fields[field].name, "'");
  const auto check_cluster = [&](std::uint64_t cluster) {
    const RangeBlock<T>& block = levels[0][cluster / width];
    const Interval<T> stored{block.lo[cluster % width], block.hi[cluster % width]};
    const std::optional<Interval<T>> of_table = range_of_table(clusters.table(cluster), values);
    if (of_table && holds(stored, *of_table)) return;
    const Interval<T> needed = needed_range(clusters, cluster, values);
    if (holds(stored, needed)) return;
    findings.add(concat(what, ": a cluster's lacks a value of its cells"), cluster, [&] {
      return concat("cluster ", cluster, " has ", interval_text(stored), ", its cells need ", interval_text(needed));
    });
  };
  for_each_watched("checking ranges (clusters)", clusters.cluster_count(), options, check_cluster);
  check_upward(
      clusters.shape, levels, concat(what, ": an entry does not match the level below"), options, findings,
      [](std::size_t entry, const RangeBlock<T>& block, const RangeBlock<T>& below) {
        return holds(Interval<T>{block.lo[entry], block.hi[entry]}, needed_range(below));
      },
      [](std::size_t entry, const RangeBlock<T>& block, const RangeBlock<T>& below) {
        return concat(" has ", interval_text(Interval<T>{block.lo[entry], block.hi[entry]}), ", below it ",
                      interval_text(needed_range(below)));
      });
}

// ---- a field ------------------------------------------------------------------------------------

template <class T>
RangesRead read_values(std::span<const T> values, const std::stop_token& stop) {
  RangesRead read{.bytes = values.size_bytes()};
  for_each_until_stopped(0, values.size(), 1 << 16, stop, [&](std::uint64_t i) {
    if (is_value(values[i]))
      read.values.include(static_cast<double>(values[i]));
    else
      read.has_gaps = true;
  });
  return read;
}

/// Bytes of the compared arrays, without the field's values.
std::uint64_t structure_bytes(const TetMesh& mesh, std::size_t field) {
  std::uint64_t bytes = 0;
  const std::string ranges = concat("range.", field, ".");
  for (const ArrayEntry& array : mesh.file().arrays())
    if (array.name == "points" || array.name == "cells" || array.name.starts_with("leaf.") ||
        array.name.starts_with("cluster.") || array.name.starts_with(ranges))
      bytes += array.byte_count;
  return bytes;
}

}  // namespace

bool check_points(const TetMesh& mesh, const CheckOptions& options, Findings& findings) {
  const LeafLattice& lattice = mesh.description().lattice;
  const Index3& count = lattice.macro.leaf_count;
  std::atomic<bool> all_inside = true;
  for_each_watched("checking the lattice (points)", mesh.points().size(), options, [&](std::uint64_t point) {
    const Vec3 at = (to_vec(mesh.points()[point]) - lattice.low) / lattice.leaf_size;
    bool is_inside = true;
    for (int axis = 0; axis < 3; ++axis)
      is_inside = is_inside && at[axis] >= 0 && at[axis] <= static_cast<double>(count[axis]);
    if (is_inside) return;
    all_inside = false;
    findings.add("a point outside the lattice of leaf cells", point, [&] {
      return concat("point ", point, " lies at (", at.x, ", ", at.y, ", ", at.z, ") leaf cells, the lattice has ",
                    count.x, " x ", count.y, " x ", count.z);
    });
  });
  return all_inside;
}

void check_boxes_and_lists(const TetMesh& mesh, const CheckOptions& options, Findings& findings) {
  if (mesh.has_clusters())
    check_boxes(mesh, options, findings);
  else
    LeafLists(mesh, options, findings).check();
}

RangesRead check_ranges(const TetMesh& mesh, std::size_t field, const CheckOptions& options, Findings& findings) {
  const auto check_field = [&]<class T>(T) {
    if (mesh.has_clusters())
      check_cluster_ranges<T>(mesh, field, options, findings);
    else
      LeafLists(mesh, options, findings).check_ranges<T>(field);
    RangesRead read = read_values(mesh.values<T>(field), options.watch.stop);
    read.bytes += structure_bytes(mesh, field);
    return read;
  };
  return mesh.description().fields[field].type == ElementType::F32 ? check_field(float{}) : check_field(double{});
}

}  // namespace rhoray::formats::details
