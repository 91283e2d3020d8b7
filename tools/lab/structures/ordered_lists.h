#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "render/mesh_search.h"

namespace rhoray::study {

/// The leaf lists of a packed mesh with their items in another order.
class OrderedLists {
 public:
  /// @param reorder  called once for each list; may rename its items
  OrderedLists(const render::TetData& packed, const std::function<void(std::span<std::uint32_t>)>& reorder);

  // The interface that walk_active_leaves expects of a view.
  render::WalkLattice lattice() const { return packed_.lattice(); }
  RHORAY_INLINE render::Ray on_lattice(const render::Ray& ray) const { return packed_.on_lattice(ray); }
  int level_count() const { return packed_.level_count(); }
  RHORAY_INLINE Interval<double> range(int level, const Index3& cell) const { return packed_.range(level, cell); }
  RHORAY_INLINE std::span<const std::uint32_t> tetrahedra_at(const Index3& leaf) const {
    const std::span<const std::uint32_t> packed = packed_.tetrahedra_at(leaf);
    return {items_.data() + (packed.data() - first_packed_), packed.size()};
  }

  /// Like TwoLevelGrid::walk.
  template <class Begins, class List, class Ends>
  void walk(const render::RayQuery& query, const render::Ray& ray, render::KernelCounters& counters, Begins&& begins,
            List&& list, Ends&& ends) const {
    render::walk_active_leaves(*this, query, ray, counters, begins, list, ends);
  }

 private:
  render::TetData packed_;
  const std::uint32_t* first_packed_;
  std::vector<std::uint32_t> items_;
};

}  // namespace rhoray::study
