#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/base/affine.h"
#include "render/camera.h"
#include "render/load.h"
#include "render/method.h"

namespace rhoray::render {

/// A ray origin + t * direction, t >= 0, in the volume's own frame: in a grid the frame of its sample positions
/// (0, 1, 2, ... or the axis tables'), in a mesh that of its points relative to the mesh's origin. These doubles are
/// what the kernels compute with; nothing is rounded on the way. The direction need not be of unit length.
struct FrameRay {
  Vec3 origin;
  Vec3 direction;
};

/// Where a ray first crosses the isosurface.
struct FrameHit {
  double t = std::numeric_limits<double>::infinity();  ///< in lengths of the ray's direction; infinity: nothing was hit
  std::uint64_t cell = 0;                              ///< as Framebuffer::cell
  Vec3 gradient{0, 0, 0};                              ///< of the field there, volume frame
  /// How far t may be from the exact one; NaN where the method proves nothing.
  double error = std::numeric_limits<double>::quiet_NaN();

  bool is_miss() const { return t == std::numeric_limits<double>::infinity(); }
};

struct TraceOptions {
  double isovalue = 0;
  Method method{};       ///< how a cell's crossing is found
  unsigned threads = 0;  ///< 0 = all cores
};

/// Answers rays of any kind as `render` answers those of a camera: hits[i] is for rays[i], the same for any number of
/// threads. Refuses an isovalue that is not finite (Trouble::usage).
void trace(const Volume& volume, const TraceOptions& options, std::span<const FrameRay> rays, std::span<FrameHit> hits);

/// The rays that `render` sends through the middles of the pixels, rows from the top; t is a distance in world units.
std::vector<FrameRay> camera_rays(const Volume& volume, const Camera& camera, int width, int height);

/// From the frame of these rays to world units.
Affine world_from_frame(const Volume& volume);

}  // namespace rhoray::render
