#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rhoray/export.h"
#include "rhoray/picture.h"
#include "rhoray/progress.h"
#include "rhoray/scene.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// The instruction sets that kernels are compiled for, with the names that the program `rhoray`
/// takes in RHORAY_MACHINE. A later one includes those before it.
enum class Machine {
  scalar,    ///< one ray at a time: the reference
  baseline,  ///< the best below AVX2: on x86-64 SSE2 or SSE4
  avx2,
  avx512
};

/// True if this processor has an instruction set.
/// Throws ErrorCode::usage for a number that is none of the enumerators.
RHORAY_API bool has_machine(Machine machine);
/// Returns the last one that this processor has.
RHORAY_API Machine best_machine();

/// The threads of a RenderContext, and its instruction set.
struct ContextOptions {
  unsigned threads = 0;  ///< 0, or more than there are: the cores that this process may use
  /// Tiles are traced in the oneTBB arena of the thread that calls, with as many threads as it has.
  /// Preparing an isovalue still starts threads of its own, as many as `threads` says.
  bool uses_callers_arena = false;
  /// Everything that is called with this context uses it. Nothing: best_machine(). The library does
  /// not read the environment variable RHORAY_MACHINE; a program that wants to obey it sets this.
  ///
  /// Pictures at preview and float32 may differ between instruction sets. On different
  /// x86-64 processors, choose the least of their best_machine() to get the same bytes.
  std::optional<Machine> machine{};
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
  double range_proof_s = 0;      ///< comes on top of wall_s: the proof of stored ranges, once per dataset
  double wall_s = 0;

  /// Adds counts and times; keeps the largest error. Windows with several samples per pixel also
  /// count rays beside them.
  RHORAY_API Statistics& operator+=(const Statistics& other);
};

/// A point of a layer that a ray through a picture meets.
struct ProbeHit {
  std::size_t layer = 0;  ///< index into Scene::layers
  double depth = 0;       ///< distance from the eye along the ray, world units
  Vec3 position{};        ///< world axes
  /// Bound on the distance of `position` from the exact crossing of the ray, world units. Nothing
  /// for triangles, slices and largest values: none is proven.
  std::optional<double> error{};
  std::uint64_t cell = no_cell;  ///< id, as in Picture::cell
  /// Isosurface: the isovalue; projection: the largest value; slice: the field there; triangles:
  /// the field that colours them, NaN without one.
  double value = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> value_error{};  ///< bound on the error of a largest value
  std::string unit{};                   ///< of the value; empty if the source gives none
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
  /// Throws ErrorCode::unsupported for an instruction set that this processor does not have,
  /// ErrorCode::usage for a number that is none.
  explicit RenderContext(const ContextOptions& options = {});
  ~RenderContext();
  RenderContext(const RenderContext&) = delete;
  RenderContext& operator=(const RenderContext&) = delete;

  /// Traces a picture, or a window of it. A stop request ends it between tiles of 32 x 32 pixels:
  /// that is not an error, and the result says that it is not complete. It also ends the proof of
  /// stored ranges and, between its steps, the preparation; then nothing is traced. If it ends the
  /// loading of a field, the picture stays as it was.
  ///
  /// Throws ErrorCode::usage for a scene or options out of range, with the layer, what was found
  /// and what was expected; ErrorCode::invalid for certified and exact pictures of data whose
  /// stored ranges do not hold.
  RenderResult render(const Scene& scene, const RenderOptions& options, Picture& picture, const Watch& watch = {});

  /// As above, in passes. The finished picture is the same, bit for bit, but for `cost`. A stop
  /// request ends neither the first pass nor the loading, the preparation and the proof before it,
  /// so that something of every request is shown; it ends a later pass at once.
  RenderResult refine(const Scene& scene, const RenderOptions& options, const Passes& passes, Picture& picture,
                      const Watch& watch = {});

  /// Finds what the ray through a point of a picture meets, nearest first: all crossings of
  /// isosurfaces, all hits of triangles, a point on each slice, and the place of the largest value
  /// of each projection. Surfaces behind an opaque one are listed, too; a projection ends at the
  /// nearest opaque surface. The list is empty where the ray meets nothing. If it has max_hits
  /// elements, there may be more.
  ///
  /// Crossings and largest values are decided by exact arithmetic, whatever the layer's method. The
  /// first crossing of a layer, rounded to float, is its depth in a picture at Accuracy::exact.
  /// Errors hold for the pixel's ray in the frame of the data (RayCaster). Hits of triangles are
  /// those of Accuracy::float64. At equal depths slices come first, then the scene's order.
  ///
  /// Surfaces with opacity 0 and clipped parts are left out. Traces on the calling thread; proving
  /// stored ranges, once per dataset, uses the context's threads.
  ///
  /// Throws ErrorCode::usage for a point outside the picture or not a number, for max_hits below 1,
  /// and as `render`; ErrorCode::invalid for data whose stored ranges do not hold, whatever the
  /// methods.
  /// @param size  of the picture; sides from 1 to 65,536
  /// @param x, y  in pixels; the centre of pixel (i, j) is at (i, j), so that the picture extends
  ///              from (-0.5, -0.5) to (width - 0.5, height - 0.5)
  /// @param watch  a stop request ends the loading of fields and the proof (ErrorCode::interrupted)
  std::vector<ProbeHit> probe(const Scene& scene, const Size& size, double x, double y, int max_hits = 64,
                              const Watch& watch = {});

  Machine machine() const;  ///< the instruction set of all calls

  /// Frees the memory that the context keeps between calls. Changes no result. Throws
  /// ErrorCode::usage during another call.
  void trim();

  class RHORAY_INSIDE Implementation;
  Implementation& implementation() { return *implementation_; }  ///< for the library's own sources

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Returns windows that cover a picture, in an order in which neighbours are adjacent.
/// Throws ErrorCode::usage for a size or an edge below 1, and for sides above 65,536.
/// @param edge  of a window, in pixels; rounded up to a multiple of 32
RHORAY_API std::vector<Rect> windows(const Size& size, int edge = 64);

}  // namespace rhoray::RHORAY_ABI
