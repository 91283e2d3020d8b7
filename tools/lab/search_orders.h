#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "tools/lab/search_field.h"

/// Search orders for the largest value on rays. Each counts its work.
namespace rhoray::study {

/// The work of a search. For groups, a region counts once for all rays.
struct Work {
  double regions = 0;    ///< bounds of cubes of 16 and of 4 cells that were read
  double blocks = 0;     ///< cubes of 4 cells that were opened
  double in_blocks = 0;  ///< pairs (ray, cube of 4 cells) whose cells were traversed
  double cells = 0;      ///< pairs (ray, cell) whose bound was examined
  double cubics = 0;     ///< cubics formed
  double solved = 0;     ///< cubics whose critical points were computed

  void add(const Work& other) {
    regions += other.regions, blocks += other.blocks, in_blocks += other.in_blocks;
    cells += other.cells, cubics += other.cubics, solved += other.solved;
  }
};

struct Best {
  double value = -std::numeric_limits<double>::infinity();
  double t = std::numeric_limits<double>::infinity();

  /// False if a region that begins at t_in cannot change the result.
  bool may_improve(double bound, double t_in) const { return bound > value || (bound == value && t_in < t); }
  void offer(double found, double at) {
    if (found > value || (found == value && at < t)) value = found, t = at;
  }
};

/// Offers the field's value on the ray at t.
void guess(const Field& field, const Line& ray, double t, Best& best);

// For single rays.

/// The paper's queue: the region with the largest bound first, down to cells.
void queue(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work);
void front_to_back(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work);

// For groups.

/// A region that rays of a group pass, and these rays.
struct Shared {
  Index3 cell;
  float bound;
  double nearest;
  std::vector<std::pair<std::size_t, Passage>> rays;
};

struct Group {
  std::vector<Line> rays;
  std::vector<std::pair<double, double>> inside;
};

std::vector<Shared> shared_regions(const Field& field, const Group& group, int level_index);

enum class Order { bound, bound_of_node, front_to_back };

/// Searches the regions of the group in one order for all rays. Reads the nodes first, then the
/// blocks of nodes that may improve the result.
void in_group(const Field& field, const Group& group, const std::vector<Shared>& nodes,
              const std::vector<Shared>& blocks, Order order, std::vector<Best>& best, Work& work);

/// Searches for each ray first the block with the largest bound among those it passes.
void dive(const Field& field, const Group& group, const std::vector<Shared>& blocks, std::vector<Best>& best,
          Work& work);

}  // namespace rhoray::study
