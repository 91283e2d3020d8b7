#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>

#include "render/framebuffer.h"
#include "render/load.h"
#include "render/method.h"
#include "render/scene.h"

namespace rhoray::render {

struct FrameOptions {
  int width = 1280;
  int height = 720;
  ChannelSet channels{};
  /// Most samples of a pixel. 1: the ray through its middle is all. More: pixels at edges get further rays, spread over
  /// the pixel, as long as these differ; a colour is their mean in linear light. Channels are those of the middle.
  int antialiasing = 1;
  unsigned threads = 0;       ///< 0 = all cores
  bool use_hierarchy = true;  ///< false walks every leaf cell on every ray by scalar kernels: the same in double
  bool use_last_t =
      true;  ///< MIP: prune with the value at the last ray's t (paper, section 4.3); the picture is the same
  bool one_pass = true;  ///< clear surfaces by one walk along each ray, where kernels have it; false asks again behind
                         ///< each crossing, which is the reference
  bool time_phases = false;  ///< fills FrameStatistics::Phases; costs a few per cent of time
};

/// What was traced for one frame. Counts do not depend on the number of threads.
struct FrameStatistics {
  struct Phases {             ///< CPU seconds, summed over threads (paper, Table 1); 0 unless FrameOptions::time_phases
    double traversal = 0;     ///< rays made and moved from cell to cell, macrocells looked up
    double intersection = 0;  ///< cells and tetrahedra solved
    double shading = 0;       ///< hits made into colours and channels
  };
  std::uint64_t rays = 0;
  std::uint64_t rays_ruled_out = 0;  ///< of these: known to meet nothing by where it can be met, and not traced
  std::uint64_t rays_clipped = 0;    ///< traced ones that a clip region shortens; 0 where it takes nothing of any layer
  std::uint64_t rays_clipped_away = 0;  ///< of these: nothing is left of them
  std::uint64_t clear_crossings = 0;    ///< of surfaces that are not opaque, of which light is shown
  std::uint64_t rays_through = 0;       ///< of these: behind which the ray goes on
  std::uint64_t shadow_rays = 0;        ///< from hits to lights that may be blocked
  std::uint64_t occlusion_rays = 0;     ///< from hits into their surroundings
  std::uint64_t slice_lookups = 0;      ///< places of which slices asked for the field's value
  std::uint64_t edge_pixels = 0;        ///< that got further samples; 0 without antialiasing
  std::uint64_t edge_samples = 0;       ///< of `rays`: beyond the first of a pixel; 0 without antialiasing
  std::uint64_t hits = 0;
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;      ///< leaf cells whose values or lists were read
  std::uint64_t cells_solved = 0;       ///< trilinear cells whose cubic was formed, or tetrahedra intersected
  std::uint64_t samples_taken = 0;      ///< by the sampled methods
  std::uint64_t rays_redone = 0;        ///< certified: rays that single precision could not decide
  std::uint64_t rays_exact = 0;         ///< certified and judged: rays decided by exact arithmetic
  std::uint64_t touches = 0;            ///< judged hits at which the field only touches the isovalue
  double largest_error = 0;             ///< of all hits' bounds; NaN where the method proves none
  std::uint64_t highlights_shaded = 0;  ///< hits for which the specular effect was computed
  std::uint64_t normals_smoothed = 0;   ///< hits for which gradients at a cell's points were read
  std::uint64_t colors_looked_up = 0;   ///< hits for which the field that colours the surface was read
  std::uint64_t texture_lookups = 0;    ///< hits for which texels were read
  Phases phases;
  double preparation_s = 0;  ///< of wall_s: what is kept with the volume and was not there yet made ready: the
                             ///< isovalue, gradients at points
  double wall_s = 0;
  RangeProof range_proof;    ///< not of wall_s: before the first frame by a method that proves
  std::string_view machine;  ///< what the kernel that answered is compiled for: scalar, baseline, avx2 or avx512
};

/// What answers who names no method: surfaces at the level `float` in volumes of which wide kernels find them, where
/// it takes a fraction of the time; all else at `double`. It does not depend on the machine.
Method default_method(const Volume& volume, Mode mode);

/// Memory of the threads that trace frames, to be kept from one frame to the next; one frame uses it at a time. It
/// holds nothing that a picture depends on: a frame with it is the same, bit for bit, as one without.
class RenderContext {
 public:
  class Implementation;

  RenderContext();
  ~RenderContext();
  RenderContext(RenderContext&&) noexcept;
  RenderContext& operator=(RenderContext&&) noexcept;

  Implementation& implementation() { return *implementation_; }  ///< for the room's inside

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Traces one ray through the middle of every pixel, and further ones where FrameOptions::antialiasing asks for them.
/// The framebuffer is the same, bit for bit, for any number of threads. Refuses a picture without pixels, a scene
/// without layers, a layer of a volume that is not there, an isovalue, a clip region or a camera that is not finite, a
/// clip box that is empty, a mode that is not one of the volume's kind, a method that does not answer the question,
/// smooth normals of a grid, colours by a field beside a texture, a light or fog that is not finite, the channel
/// `error` where the method proves nothing, and, of layers in view, colours by a field that is not there
/// (ErrorCode::usage). Of layers outside the view that shade nothing in it nothing is read. Refuses certified and exact
/// answers about data of which the stored ranges do not hold (Volume::prove_ranges, ErrorCode::invalid).
FrameStatistics render(std::span<const Volume> volumes, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer);

/// As above, in memory that is kept: that of the threads, and the framebuffer's own where the last frame had its size
/// and its channels.
FrameStatistics render(std::span<const Volume> volumes, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer, RenderContext& memory);

// A scene of one volume.
FrameStatistics render(const Volume& volume, const Scene& scene, const FrameOptions& options, Framebuffer& framebuffer);
FrameStatistics render(const Volume& volume, const Scene& scene, const FrameOptions& options, Framebuffer& framebuffer,
                       RenderContext& memory);

/// How a picture comes into being for someone who looks on.
struct Refinement {
  /// The first pass traces one pixel of first_spacing x first_spacing, each later one halves the spacing: 2 shows a
  /// quarter of the rays first. A power of 2 up to 16; 1 is a plain frame.
  int first_spacing = 2;
  /// Called after each pass, while nothing is traced, with the spacing of the pixels traced so far; every other pixel
  /// looks as its neighbour to the left and above that was traced. False ends the frame.
  std::function<bool(int spacing)> pass_done = nullptr;
  /// Ends the frame within the time of one tile; pixels of the pass that was not finished are then of one spacing or of
  /// the other, and of a first pass that was not finished as the framebuffer had them.
  std::stop_token stop{};
};

/// Renders in passes. The finished picture is that of render, bit for bit; counts of cells may differ. A frame that was
/// ended early has traced fewer rays than the picture has pixels.
FrameStatistics refine(std::span<const Volume> volumes, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory);
FrameStatistics refine(const Volume& volume, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory);

}  // namespace rhoray::render
