#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "rhoray/export.h"
#include "rhoray/picture.h"
#include "rhoray/scene.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// The threads of a RenderContext.
struct ContextOptions {
  unsigned threads = 0;  ///< 0, or more than there are: the cores that this process may use
  /// Tiles are traced in the oneTBB arena of the thread that calls, with as many threads as it has.
  /// Preparing an isovalue still starts threads of its own, as many as `threads` says.
  bool uses_callers_arena = false;
};

/// Size and channels of a picture.
struct RenderOptions {
  Size size{};                   ///< sides from 1 to 65,536
  std::optional<Rect> window{};  ///< only these pixels; they are the whole picture's, bit for bit
  ChannelSet channels{};         ///< `error` needs a method that proves errors
  int max_samples = 1;           ///< per pixel, 1 to 64; pixels at edges get several (antialiasing)
};

/// What was traced. Counts do not depend on the number of threads.
struct Statistics {
  std::uint64_t rays = 0;            ///< from the eye
  std::uint64_t rays_ruled_out = 0;  ///< of these: not traced, because they pass nothing that can be hit
  std::uint64_t shadow_rays = 0, occlusion_rays = 0;
  std::uint64_t edge_pixels = 0;  ///< with more than one sample
  std::uint64_t hits = 0;         ///< rays from the eye that show something
  std::uint64_t macrocells_visited = 0, cells_visited = 0;
  std::uint64_t rays_exact = 0;  ///< decided by exact arithmetic
  double largest_error = 0;      ///< of all hits; NaN if a method proves nothing
  double preparation_s = 0;      ///< part of wall_s: what isovalues need and was not kept from before
  double range_proof_s = 0;      ///< not part of wall_s: once per dataset, for certified and exact
  double wall_s = 0;

  /// Adds counts and times; keeps the largest error. Windows with several samples per pixel also
  /// count rays beside them.
  RHORAY_API Statistics& operator+=(const Statistics& other);
};

/// The result of RenderContext::render and RenderContext::refine.
struct RenderResult {
  Statistics statistics;
  bool complete = false;  ///< false: stopped; the picture has old pixels or copies of neighbours
};

/// How a picture is refined while someone watches.
struct Passes {
  /// The first pass traces one pixel of each first_spacing x first_spacing block; each later pass
  /// halves the spacing. 1, 2, 4, 8 or 16.
  int first_spacing = 8;
  /// Called on the calling thread after each pass; nothing is traced meanwhile. The picture holds
  /// every traced pixel and copies of it. Returning false ends the call.
  std::function<bool(int spacing)> pass_done{};
};

/// Threads and memory to render with. Contexts are independent: several may render at a time, also
/// the same data. One context serves one call at a time; a second call meanwhile, also from a
/// callback of the first, is refused (ErrorCode::usage). It starts no thread before its first call.
///
/// Results do not depend on threads, on earlier calls, or on what the context keeps.
///
/// Calls restore the floating-point environment that they find. They refuse to run in a process
/// that was forked after the context was made (ErrorCode::usage).
class RHORAY_API RenderContext {
 public:
  explicit RenderContext(const ContextOptions& options = {});
  ~RenderContext();
  RenderContext(const RenderContext&) = delete;
  RenderContext& operator=(const RenderContext&) = delete;

  /// Traces a picture, or a window of it. `stop` ends it between tiles of 32 x 32 pixels: that is
  /// not an error, and the result says that it is not complete. Preparing an isovalue is not
  /// interrupted.
  ///
  /// Throws ErrorCode::usage for a scene or options out of range, with the layer, what was found
  /// and what was expected; ErrorCode::invalid for certified and exact pictures of data whose
  /// stored ranges do not hold.
  RenderResult render(const Scene& scene, const RenderOptions& options, Picture& picture, std::stop_token stop = {});

  /// As above, in passes. The finished picture is the same, bit for bit, but for `cost`. `stop` is
  /// heeded after the first pass, so that something of every request is shown; it ends a later pass
  /// at once.
  RenderResult refine(const Scene& scene, const RenderOptions& options, const Passes& passes, Picture& picture,
                      std::stop_token stop = {});

  class RHORAY_INSIDE Implementation;
  Implementation& implementation() { return *implementation_; }  ///< for the library's own sources

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Returns windows that cover a picture, in an order in which neighbours are adjacent.
/// Throws ErrorCode::usage for a size or an edge below 1.
/// @param edge  of a window, in pixels; rounded up to a multiple of 32
RHORAY_API std::vector<Rect> windows(const Size& size, int edge = 64);

}  // namespace rhoray::RHORAY_ABI
