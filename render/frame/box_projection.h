#pragma once

#include <cstddef>

#include "formats/base/affine.h"
#include "render/frame/camera_rays.h"
#include "render/frame/pixel_lattice.h"
#include "render/query/machine.h"
#include "render/traverse/surface_boxes.h"

namespace rhoray::render {

/// Range of a lattice's columns and rows whose rays may meet the boxes of a node. The numbers may
/// have any size; first > last where there is no such ray.
struct ProjectedNode {
  double first_column[BoxNode::size], last_column[BoxNode::size], first_row[BoxNode::size], last_row[BoxNode::size];
};

/// Where a camera sees boxes of a data's frame.
///
/// Rays are o + s (f + a u + b v), where a and b are picture coordinates from -1 to 1. Rays of an
/// orthographic camera are o + a u + b v + s f. Take the cross products of the edges, each times
/// the sign that makes det = f . (u x v) positive:
///
///     depth = (u x v) . (p - o)    across = (v x f) . (p - o)    down = (f x u) . (p - o)
///
/// They are det times s, s a and s b (orthographic: s, a, b). So a = across / depth (across / det).
/// Over a box in front of the eye, a has its extremes at corners. For a box that reaches the eye's
/// plane or is behind it, only points of positive depth count. Where across is at least q > 0 in
/// all of the box, a is at least q / (the largest depth), and has no upper bound. The same holds
/// for the other side.
///
/// Every bound is moved outward by more than all rounding: that of these functions, of the rays,
/// and of the positions that a kernel computes along a ray. Let R be the largest sum of magnitudes
/// along an axis in any of them: positions in the dataset, the eye, the ray's relevant length, in
/// steps of the data's frame. The error of a position is a few units of 2^-53 R. The error of a
/// function is that times the magnitudes of the cross product's terms. 2^-44 is used for all of
/// them together: 512 such units.
class BoxProjection {
 public:
  /// @param bounds  of the contents of all boxes, data frame
  BoxProjection(const CameraRays& camera, const Affine& data_from_world, const Affine& world_from_data,
                const Box3& bounds);

  /// False where rounding hides the orientation of the picture to the dataset: then any ray may
  /// meet anything.
  bool is_certain() const { return is_certain_; }

  /// Projects boxes of one tree onto one lattice.
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
  OntoLattice(const BoxProjection& projection, const SurfaceBoxes& boxes, const PixelLattice& lattice, Machine machine);

  void project(const BoxNode& node, ProjectedNode& out) const;

 private:
  /// factor . p + constant for a position p in the tree's frame; its error is below slack.
  struct Function {
    double factor[3];
    double constant, slack;
  };
  /// Maps a picture coordinate to a lattice's column or row: coordinate * scale + offset.
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
