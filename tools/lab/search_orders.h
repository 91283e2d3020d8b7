#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "tools/lab/search_field.h"

/// Orders in which to look for the largest value on rays, each counting what it looks at.
namespace rhoray::study {

/// What a search looked at. Of groups: regions count once for all rays.
struct Work {
  double regions = 0;    ///< bounds of cubes of 16 and of 4 cells that were read
  double blocks = 0;     ///< cubes of 4 cells that were opened
  double in_blocks = 0;  ///< (ray, cube of 4 cells) in which cells were walked
  double cells = 0;      ///< (ray, cell) whose bound was looked at
  double cubics = 0;     ///< formed
  double solved = 0;     ///< of these, those whose critical points were looked for

  void add(const Work& other) {
    regions += other.regions, blocks += other.blocks, in_blocks += other.in_blocks;
    cells += other.cells, cubics += other.cubics, solved += other.solved;
  }
};

struct Best {
  double value = -std::numeric_limits<double>::infinity();
  double t = std::numeric_limits<double>::infinity();

  /// False where a region that begins at t_in can change nothing.
  bool may_improve(double bound, double t_in) const { return bound > value || (bound == value && t_in < t); }
  void offer(double found, double at) {
    if (found > value || (found == value && at < t)) value = found, t = at;
  }
};

/// A value that the ray reaches at t.
void guess(const Field& field, const Line& ray, double t, Best& best);

// Of rays alone.

/// The paper's queue: the region with the largest bound first, down to cells.
void queue(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work);
void front_to_back(const Field& field, const Line& ray, double t_in, double t_out, Best& best, Work& work);

// Of groups.

/// A region that rays of a group pass, and which.
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

/// Regions of the group in one order for all rays; nodes are read first, then the blocks of those that may improve.
void in_group(const Field& field, const Group& group, const std::vector<Shared>& nodes,
              const std::vector<Shared>& blocks, Order order, std::vector<Best>& best, Work& work);

/// For each ray first the block with the largest bound among those it passes.
void dive(const Field& field, const Group& group, const std::vector<Shared>& blocks, std::vector<Best>& best,
          Work& work);

}  // namespace rhoray::study
