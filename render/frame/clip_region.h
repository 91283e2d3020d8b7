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

/// What a clip region leaves of whole groups of rays: a part, and where something is cut away another one behind it.
struct KeptParts {
  LaneArray<double> t_min, t_max;  ///< t_max below t_min where nothing is left
  LaneArray<double> again;         ///< where the second part begins; infinity: there is none

  KeptParts() = default;
  explicit KeptParts(std::size_t capacity) : t_min(capacity), t_max(capacity), again(capacity) {}
};

/// A clip region as rays are held against it.
class ClipRegion {
 public:
  explicit ClipRegion(const Clip& clip, Machine machine = chosen_machine());

  bool cuts_away() const { return cuts_away_; }

  /// Between which t rays in world axes lie in all half spaces, whether it is kept or cut away; `from` above `to` where
  /// nowhere. Whole groups of the batch are written.
  void find_spans(const RayBatch& rays, double* from, double* to) const;

  /// What is left of rays that begin at t = 0.
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

/// Says of boxes of a tree that nothing is left of them.
class ClipRegion::InFrame {
 public:
  InFrame(const ClipRegion& region, const Affine& world_from_volume, const SurfaceBoxes& boxes);

  /// True only where that is certain, whatever rounding does to rays and boxes.
  bool takes_away(const BoxNode& node, std::size_t child) const;

 private:
  /// factor . p + constant, p a place of the tree's frame, is how far it lies inside.
  struct Function {
    Vec3 factor;
    double constant, slack;
  };

  std::vector<Function> functions_;
  double margin_;
  bool cuts_away_;
};

}  // namespace rhoray::render
