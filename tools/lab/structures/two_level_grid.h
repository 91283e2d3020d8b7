#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/mesh_search.h"
#include "tools/lab/structures/plain_mesh.h"

namespace rhoray::study {

/// Ranges of the cells of a lattice and of the macrocells above it.
struct RangeLevels {
  render::WalkLattice lattice;
  std::vector<std::vector<Interval<float>>> levels;  ///< [level][position, x fastest]

  std::size_t at(int level, const Index3& cell) const;
  int top() const { return static_cast<int>(levels.size()) - 1; }
  std::uint64_t bytes() const;
};

/// A uniform lattice whose cells are divided again. Each cell has its own lattice, with about one
/// leaf cell for each tetrahedron whose centre is in it.
class TwoLevelGrid {
 public:
  /// @param cells_per_top_cell  average number of tetrahedra for one cell of the upper lattice
  TwoLevelGrid(const PlainMesh& mesh, double cells_per_top_cell);

  std::uint64_t bytes() const;  ///< without the mesh's
  std::uint64_t item_count() const { return items_.size(); }

  /// Passes on the lists of the leaf cells along the ray that may hold the isosurface, front to
  /// back.
  /// @param begins  (t_in): false to stop
  /// @param list    (the tetrahedra that a leaf cell lists)
  /// @param ends    (t_out): false to stop
  template <class Begins, class List, class Ends>
  void walk(const render::RayQuery& query, const render::Ray& ray, render::KernelCounters& counters, Begins&& begins,
            List&& list, Ends&& ends) const;

 private:
  struct TopCell {
    std::uint32_t first_leaf = 0;
    std::array<std::uint16_t, 3> count{};  ///< of leaf cells
  };
  void divide(const PlainMesh& mesh);
  void collect_ranges(const PlainMesh& mesh);
  Index3 top_cell_of(const Vec3& point) const;

  Vec3 low_, top_size_;
  RangeLevels upper_;
  std::vector<TopCell> top_cells_;
  std::vector<Interval<float>> leaf_ranges_;
  std::vector<std::uint32_t> starts_;  ///< leaf cells + 1
  std::vector<std::uint32_t> items_;
};

template <class Begins, class List, class Ends>
void TwoLevelGrid::walk(const render::RayQuery& query, const render::Ray& ray, render::KernelCounters& counters,
                        Begins&& begins, List&& list, Ends&& ends) const {
  using namespace render;
  const double iso = query.isovalue;
  const auto can_cross = [&](const Interval<float>& range) { return range.lo < iso && iso <= range.hi; };
  Ray on_top = ray;
  on_top.origin = (ray.origin - low_) / top_size_;
  on_top.direction = ray.direction / top_size_;
  const PlaneTimes planes(on_top);
  const std::optional<Segment> segment = clip_to_lattice(on_top, planes, upper_.lattice.leaf_count);
  if (!segment) return;
  auto enters = [&](int level, const CellVisit& visit) {
    ++counters.macrocells_visited;
    return can_cross(upper_.levels[static_cast<std::size_t>(level)][upper_.at(level, visit.cell)]);
  };
  auto top_cell = [&](const CellVisit& visit) {
    if (visit.has_no_length()) return true;
    if (!begins(visit.t_in)) return false;
    ++counters.macrocells_visited;
    const std::size_t place = upper_.at(0, visit.cell);
    if (!can_cross(upper_.levels[0][place])) return true;
    const TopCell& cell = top_cells_[place];
    const WalkLattice lattice{{cell.count[0], cell.count[1], cell.count[2]}, 1};
    const Vec3 counts{static_cast<double>(cell.count[0]), static_cast<double>(cell.count[1]),
                      static_cast<double>(cell.count[2])};
    Ray inside = on_top;
    inside.origin = (on_top.origin - Vec3(visit.cell)) * counts;
    inside.direction = on_top.direction * counts;
    const PlaneTimes inner_planes(inside);
    return walk_level(
        inside, inner_planes, lattice, 1, whole_level(lattice, 1), visit.t_in, visit.t_out, [&](const CellVisit& at) {
          if (at.has_no_length()) return true;
          if (!begins(at.t_in)) return false;
          ++counters.cells_visited;
          const auto leaf =
              cell.first_leaf + static_cast<std::size_t>(
                                    (at.cell.z * lattice.leaf_count.y + at.cell.y) * lattice.leaf_count.x + at.cell.x);
          if (!can_cross(leaf_ranges_[leaf])) return true;
          list(std::span(items_).subspan(starts_[leaf], starts_[leaf + 1] - starts_[leaf]));
          return ends(at.t_out);
        });
  };
  const int top = query.use_hierarchy ? upper_.top() : 0;
  const std::int64_t edge = upper_.lattice.cell_edge(top);
  walk_hierarchy(on_top, planes, upper_.lattice, top, whole_level(upper_.lattice, edge), segment->t_in, segment->t_out,
                 enters, top_cell);
}

}  // namespace rhoray::study
