#pragma once

#include <cstddef>

#include "formats/base/affine.h"
#include "render/frame/camera_rays.h"
#include "render/frame/pixel_lattice.h"
#include "render/query/machine.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Between which columns and rows of a lattice the rays lie that may meet the boxes of a node; numbers of any size, and
/// first > last where there is no ray.
struct ProjectedNode {
  double first_column[BoxNode::size], last_column[BoxNode::size], first_row[BoxNode::size], last_row[BoxNode::size];
};

/// Where a camera sees boxes of a volume's frame.
///
/// Rays are o + s (f + a u + b v), a and b the picture's coordinates from -1 to 1; of an orthographic camera
/// o + a u + b v + s f. With the edges' cross products, each times the sign that makes det = f . (u x v) positive,
///
///     depth = (u x v) . (p - o)    across = (v x f) . (p - o)    down = (f x u) . (p - o)
///
/// are det times s, s a and s b (orthographic: s, a, b). So a = across / depth (across / det), which over a box in
/// front of the eye is largest and smallest at corners. Of a box that reaches the eye's plane, or lies behind it, only
/// points of depth above 0 count: where across is at least q > 0 in all of the box, a is at least q / (the largest
/// depth), and has no upper bound; the same on the other side.
///
/// Every bound is moved outward by more than all rounding: of these functions, of the rays, and of what a kernel makes
/// of a ray's places. With R the largest sum of magnitudes along an axis that any of them adds up (places in the
/// volume, the eye, the way of a ray as far as it matters, in steps of the volume's frame) each is off by a few units
/// of 2^-53 R on the way to a place, and by that times the cross product's terms in magnitude on the way to a function.
/// 2^-44 is taken for all of them together: 512 such units.
class BoxProjection {
 public:
  /// @param bounds  of all that boxes hold, volume frame
  BoxProjection(const CameraRays& camera, const Affine& volume_from_world, const Affine& world_from_volume,
                const Box3& bounds);

  /// False where rounding hides how the picture lies to the volume: then any ray may meet anything.
  bool is_certain() const { return is_certain_; }

  /// Ready to project boxes of one tree onto one lattice.
  class OntoLattice;

 private:
  struct Function {
    Vec3 factor;
    double slack;
  };
  Vec3 eye_;
  Function depth_, across_, down_;
  double det_, det_slack_;
  bool orthographic_;
  bool is_certain_;
};

class BoxProjection::OntoLattice {
 public:
  OntoLattice(const BoxProjection& projection, const SurfaceBoxes& boxes, const PixelLattice& lattice,
              Machine machine = chosen_machine());

  void project(const BoxNode& node, ProjectedNode& out) const;

 private:
  /// factor . p + constant for a place p of the tree's frame; off by less than the slack.
  struct Function {
    double factor[3];
    double constant, slack;
  };
  /// A picture coordinate times `scale`, plus `offset`, is a lattice's column or row.
  struct Steps {
    double scale, offset;
  };

  static void project_inline(const OntoLattice& onto, const BoxNode& node, ProjectedNode& out);

  Function depth_, across_, down_;
  double det_, det_slack_;
  double margin_;
  Steps columns_, rows_;
  bool orthographic_;
  Machine machine_;
};

}  // namespace rhoray::render
