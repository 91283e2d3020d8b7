#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "formats/base/progress.h"
#include "render/framebuffer.h"
#include "render/load.h"
#include "render/method.h"
#include "render/query/machine.h"
#include "render/scene.h"

namespace rhoray::render {

/// A rectangle of pixels.
struct PixelRect {
  int x = 0, y = 0;  ///< its first column and row
  int width = 0, height = 0;

  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

struct FrameOptions {
  int width = 960;
  int height = 720;
  /// Only these pixels are asked for. They have the same bits as in the whole picture. Other
  /// pixels of the framebuffer may be written too, or keep their content. Counts include traced
  /// ones.
  std::optional<PixelRect> window{};
  ChannelSet channels{};
  /// Maximum number of samples per pixel. 1: only the ray through the pixel centre. More: pixels at
  /// edges get further rays, spread over the pixel, as long as these differ. The colour is their
  /// mean in linear light. Channels are those of the centre ray.
  int antialiasing = 1;
  unsigned threads = 0;  ///< 0 = all cores
  /// Whose kernels trace and shade. This processor must have it. None: chosen_machine().
  std::optional<Machine> machine{};
  /// False visits every leaf cell on every ray with scalar kernels: same result in double.
  bool use_hierarchy = true;
  /// MIP: prune with the value at the previous ray's t (paper, section 4.3); same picture.
  bool use_last_t = true;
  /// Transparent surfaces in one traversal per ray, where kernels support it; false traces again
  /// behind each crossing, which is the reference.
  bool one_pass = true;
  bool time_phases = false;  ///< fills FrameStatistics::Phases; costs a few per cent of the time
};

/// What was traced for one frame. Counts do not depend on the number of threads.
struct FrameStatistics {
  /// CPU seconds, summed over threads (paper, Table 1); 0 unless FrameOptions::time_phases.
  struct Phases {
    double traversal = 0;     ///< rays made and moved from cell to cell, macrocells looked up
    double intersection = 0;  ///< cells and tetrahedra intersected
    double shading = 0;       ///< hits converted to colours and channels
  };
  std::uint64_t rays = 0;
  /// Of these: not traced, because they pass no region in which a hit is possible.
  std::uint64_t rays_ruled_out = 0;
  /// Traced rays that a clip region shortens; 0 when it removes nothing of any layer.
  std::uint64_t rays_clipped = 0;
  std::uint64_t rays_clipped_away = 0;  ///< of these: nothing remains of the ray
  std::uint64_t clear_crossings = 0;    ///< crossings of transparent surfaces that contribute light
  std::uint64_t rays_through = 0;       ///< of these: the ray continues behind
  std::uint64_t shadow_rays = 0;        ///< from hits to lights that may be occluded
  /// From hits into their surroundings, for ambient occlusion.
  std::uint64_t occlusion_rays = 0;
  std::uint64_t slice_lookups = 0;  ///< points at which slices looked up the field
  std::uint64_t edge_pixels = 0;    ///< pixels with further samples; 0 without antialiasing
  /// Of `rays`: samples beyond the first of a pixel; 0 without antialiasing.
  std::uint64_t edge_samples = 0;
  std::uint64_t hits = 0;
  std::uint64_t macrocells_visited = 0;
  std::uint64_t cells_visited = 0;  ///< leaf cells whose values or lists were read
  /// Trilinear cells whose cubic was formed, or tetrahedra intersected.
  std::uint64_t cells_solved = 0;
  std::uint64_t samples_taken = 0;  ///< by the sampled methods
  std::uint64_t rays_redone = 0;    ///< certified: rays that single precision could not decide
  std::uint64_t rays_exact = 0;     ///< certified and exact: rays decided by exact arithmetic
  /// Hits of exact arithmetic at which the field only touches the isovalue.
  std::uint64_t touches = 0;
  /// Largest bound of all hits; NaN where the method proves none.
  double largest_error = 0;
  std::uint64_t highlights_shaded = 0;  ///< hits for which the specular effect was computed
  std::uint64_t normals_smoothed = 0;   ///< hits for which gradients at a cell's points were read
  /// Hits for which the field that colours the surface was read.
  std::uint64_t colors_looked_up = 0;
  std::uint64_t texture_lookups = 0;  ///< hits for which texels were read
  Phases phases;
  /// Of wall_s: time to prepare what is kept with the dataset and was missing: data for the
  /// isovalue, gradients at points.
  double preparation_s = 0;
  double wall_s = 0;
  /// Not part of wall_s: proof before the first frame of a method that proves.
  RangeProof range_proof;
  /// What the kernel used is compiled for: scalar, baseline, avx2 or avx512.
  std::string_view machine;
};

/// Returns the method used when none is named. Surfaces get the level `float` in datasets for which
/// wide kernels find them, where it takes a fraction of the time. Everything else gets `double`.
/// The result does not depend on the machine.
Method default_method(const Dataset& dataset, Mode mode);

/// Where the tiles of a frame are traced.
enum class Arena {
  own,     ///< on threads of its own
  callers  ///< in the oneTBB arena in which the frame is called, with as many threads as it has
};

/// The threads that trace frames and their memory, to be kept from one frame to the next. Only one
/// frame may use it at a time. Pictures do not depend on its contents: a frame with it is the same,
/// bit for bit, as one without.
class RenderContext {
 public:
  class Implementation;

  /// @param arena  with `callers`, FrameOptions::threads limits only the threads that prepare
  explicit RenderContext(Arena arena = Arena::own);
  ~RenderContext();
  RenderContext(RenderContext&&) noexcept;
  RenderContext& operator=(RenderContext&&) noexcept;

  /// Calls act(index, worker) for every index below `count`, on these threads. `worker` is below
  /// worker_count(threads), and no two calls at a time have the same one. An exception of a call
  /// ends the work and is rethrown.
  /// @param threads  as FrameOptions::threads
  void for_each(std::size_t count, unsigned threads,
                const std::function<void(std::size_t index, std::size_t worker)>& act);
  std::size_t worker_count(unsigned threads);

  Implementation& implementation() { return *implementation_; }  ///< for use inside render only

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Traces one ray through the centre of every pixel, and further ones where
/// FrameOptions::antialiasing requests them. The framebuffer is the same, bit for bit, for any
/// number of threads.
///
/// Refuses with ErrorCode::usage:
/// - a picture or window without pixels, a window beyond the picture
/// - a scene without layers, a layer of a dataset that does not exist
/// - an isovalue, clip region, camera, light or fog that is not finite; a clip box that is empty
/// - a mode that does not fit the dataset's kind, a method that does not answer the query
/// - colours by a field together with a texture
/// - the channel `error` when the method proves nothing
/// - for layers in view: colours by a field that does not exist
///
/// Reads nothing of layers outside the view that shade nothing in it. Refuses certified and exact
/// results for data whose stored ranges do not hold (Dataset::prove_ranges, ErrorCode::invalid).
FrameStatistics render(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer);

/// As above, but reuses memory: that of the threads, and the framebuffer's own when the last frame
/// had the same size and channels.
FrameStatistics render(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer, RenderContext& memory);

// For a scene of one dataset.
FrameStatistics render(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer);
FrameStatistics render(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       Framebuffer& framebuffer, RenderContext& memory);

/// How a picture is refined while someone watches.
struct Refinement {
  /// The first pass traces one pixel of each first_spacing x first_spacing block; each later pass
  /// halves the spacing. With 2, a quarter of the rays is shown first. A power of 2 up to 16; 1 is
  /// a plain frame.
  int first_spacing = 2;
  /// Called after each pass with the spacing of the pixels traced so far; nothing is traced
  /// meanwhile. Every other pixel is a copy of its traced neighbour to the left and above.
  /// Returning false ends the frame.
  std::function<bool(int spacing)> pass_done = nullptr;
  /// A stop request ends the frame within the time of one tile. It also ends the proof of stored
  /// ranges and, between its steps, the preparation: then nothing is traced. Pixels of an
  /// unfinished pass have either spacing; those of an unfinished first pass may keep the
  /// framebuffer's previous content.
  Watch watch{};
};

/// Renders in passes. The finished picture is the same as that of `render`, bit for bit; counts of
/// cells may differ. A frame that was ended early has traced fewer rays than the picture has
/// pixels.
FrameStatistics refine(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory);
FrameStatistics refine(const Dataset& dataset, const Scene& scene, const FrameOptions& options,
                       const Refinement& refinement, Framebuffer& framebuffer, RenderContext& memory);

}  // namespace rhoray::render
