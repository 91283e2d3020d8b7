#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/base/affine.h"
#include "render/clip.h"
#include "render/query/batch.h"
#include "render/query/machine.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Parts of whole groups of rays that a clip region keeps. A ray has one part, and a second one
/// behind a gap that is cut away.
struct KeptParts {
  LaneArray<double> t_min, t_max;  ///< t_max below t_min: nothing is kept
  LaneArray<double> again;         ///< start of the second part; infinity: there is none

  KeptParts() = default;
  explicit KeptParts(std::size_t capacity) : t_min(capacity), t_max(capacity), again(capacity) {}
};

/// A clip region, prepared for intersection with rays.
class ClipRegion {
 public:
  explicit ClipRegion(const Clip& clip, Machine machine);

  bool cuts_away() const { return cuts_away_; }

  /// Finds the interval of t in which rays (world axes) lie in all half spaces, whether that part
  /// is kept or cut away. An empty interval has `from` above `to`. Whole groups of the batch are
  /// written.
  void find_spans(const RayBatch& rays, double* from, double* to) const;

  /// Finds the parts that are kept of rays that start at t = 0.
  /// @param rays  world axes
  void find_kept(const RayBatch& rays, KeptParts& kept) const;

  /// The half spaces in another frame.
  class InFrame;

 private:
  static void find_spans_inline(const ClipRegion& region, const RayBatch& rays, double* from, double* to);
  static void find_kept_inline(const ClipRegion& region, const RayBatch& rays, KeptParts& kept);

  std::vector<HalfSpace> halves_;
  bool cuts_away_;
  Machine machine_;
};

/// Tests whether the region removes boxes of a tree completely.
class ClipRegion::InFrame {
 public:
  InFrame(const ClipRegion& region, const Affine& world_from_data, const SurfaceBoxes& boxes);

  /// Returns true only if that is certain, whatever rounding does to rays and boxes.
  bool takes_away(const BoxNode& node, std::size_t child) const;

 private:
  /// factor . p + constant measures how far a point p of the tree's frame is inside the half space.
  struct Function {
    Vec3 factor;
    double constant, slack;
  };

  std::vector<Function> functions_;
  double margin_;
  bool cuts_away_;
};

}  // namespace rhoray::render
