#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "rhoray/array_view.h"
#include "rhoray/context.h"
#include "rhoray/dataset.h"
#include "rhoray/export.h"
#include "rhoray/progress.h"
#include "rhoray/scene.h"

namespace rhoray::RHORAY_ABI {

/// Rays of the caller: points origin + t * direction, in world axes and the length unit of the
/// data, with t_min <= t <= t_max. They must not overlap the arrays of the answers.
///
/// Rays out of range are refused. The coordinates of a start are at most 1e150. The largest
/// component of a direction is from 1e-110 to 1e110. Both are counted in cells of a grid, and in
/// length units of a mesh or a surface.
struct Rays {
  ArrayView origins;     ///< [rays, 3], F32 or F64, finite
  ArrayView directions;  ///< [rays, 3], F32 or F64, finite, not 0; t counts their lengths
  ArrayView t_min{};     ///< [rays], F32 or F64; not given: 0
  ArrayView t_max{};     ///< [rays], F32 or F64; not given: infinity
};

/// Where hits are written. Each span has one element per ray (gradient: three), or is empty: then
/// nothing is written.
struct Hits {
  std::span<double> t{};  ///< infinity: a miss
  /// Bound on the distance from the exact answer: of t, or of a largest value. Refused unless the
  /// method proves it. NaN for a miss.
  std::span<double> error{};
  std::span<double> value{};        ///< of the field at the hit; NaN for a miss
  std::span<double> gradient{};     ///< [rays, 3], world axes: of the field, or a triangle's normal; else 0
  std::span<std::uint64_t> cell{};  ///< id, as in Picture::cell; no_cell for a miss
};

/// All crossings of rays, in order. Ray r has those with index first[r] up to first[r + 1] - 1.
struct AllHits {
  std::vector<std::uint64_t> first{};  ///< rays + 1 numbers
  std::vector<double> t{};             ///< does not decrease along a ray
  std::vector<double> error{};         ///< bound on |t - exact t|
  std::vector<std::uint64_t> cell{};
  std::vector<std::uint8_t> enters{};     ///< 1: behind the crossing, values are at least the isovalue
  std::vector<std::uint8_t> truncated{};  ///< per ray; 1: there are more crossings than were asked for
};

/// Memory of one of the caller's threads for calls that run on that thread alone.
class RHORAY_API RayScratch {
 public:
  /// Throws as RenderContext for an instruction set that this processor does not have.
  /// @param machine  the instruction set of calls with it; nothing: best_machine()
  explicit RayScratch(std::optional<Machine> machine = {});
  ~RayScratch();
  RayScratch(RayScratch&&) noexcept;  ///< a moved-from one may only be assigned to or destroyed
  RayScratch& operator=(RayScratch&&) noexcept;

  class RHORAY_INSIDE Implementation;
  Implementation& implementation() { return *implementation_; }  ///< for the library's own sources

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Answers arbitrary rays through one dataset. It keeps the data alive. A copy is a handle. Any
/// number of threads may call at a time, each with a scratch or a context of its own.
///
/// With Accuracy::certified a miss is a miss and a hit is within its bound. With Accuracy::exact
/// the bound is also at most 1e-12 cells, or that of neighbouring doubles. Both hold for the ray in
/// the data's own frame: moving a ray from world axes there rounds. In a mesh that frame is
/// relative to the mesh's origin, in a grid it counts samples.
///
/// Answers do not depend on threads or on the grouping of rays. Calls throw ErrorCode::usage for
/// arrays of wrong shapes and for rays that are not finite or out of range, with the ray's index,
/// before anything is written. After a stop request they throw ErrorCode::interrupted; answers that
/// are there by then are valid, and the others are not written.
class RHORAY_API RayCaster {
 public:
  /// Proves the stored ranges of the data on the calling thread, once per dataset, if the method
  /// proves errors. Throws
  /// ErrorCode::usage for an isovalue that is not finite and an unknown field;
  /// ErrorCode::unsupported for a surface with a method other than float32 and float64;
  /// ErrorCode::invalid for data whose ranges do not hold. A proof that was stopped
  /// (ErrorCode::interrupted) is made again by the next call that needs it.
  /// @param field  empty: the first that is not constant
  /// @param watch  a stop request ends the loading of the field and the proof
  RayCaster(const Dataset& data, const std::variant<Isosurface, Triangles>& surface, const Method& method,
            std::string_view field = {}, const Watch& watch = {});
  ~RayCaster();
  RayCaster(const RayCaster&);
  RayCaster& operator=(const RayCaster&);

  /// Finds where each ray first passes from one side of the isovalue to the other. A ray starts on
  /// the side that the field has at its start; there is no surface at the border of data.
  void first_hits(const Rays& rays, const Hits& hits, RayScratch& scratch, const Watch& watch = {}) const;
  /// On the threads of a context.
  void first_hits(const Rays& rays, const Hits& hits, RenderContext& context, const Watch& watch = {}) const;

  /// Finds whether there is any hit: 1 or 0 for each ray.
  void any_hits(const Rays& rays, std::span<std::uint8_t> is_hit, RayScratch& scratch, const Watch& watch = {}) const;
  void any_hits(const Rays& rays, std::span<std::uint8_t> is_hit, RenderContext& context,
                const Watch& watch = {}) const;

  /// Finds all crossings, decided by exact arithmetic whatever the method. In an MRI of 168 x 206 x
  /// 128 samples, a ray with one crossing took 7 microseconds of CPU on average, twice as long as
  /// its exact first hit. A ray that touches the isovalue from below has two crossings with one t.
  /// Without gaps of data along the ray, `enters` alternates.
  /// Proves the stored ranges of the data, once per dataset. The call with a scratch proves them on
  /// the calling thread, the call with a context on the context's threads.
  /// Throws ErrorCode::unsupported for triangles, ErrorCode::invalid for data whose ranges do not
  /// hold.
  /// @param max_hits  per ray, at least 1
  void all_hits(const Rays& rays, AllHits& hits, RayScratch& scratch, std::size_t max_hits = 4096,
                const Watch& watch = {}) const;
  void all_hits(const Rays& rays, AllHits& hits, RenderContext& context, std::size_t max_hits = 4096,
                const Watch& watch = {}) const;

  class RHORAY_INSIDE Implementation;

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// Answers queries about the values of a field. Threads and errors are as for RayCaster.
class RHORAY_API FieldSampler {
 public:
  /// Throws ErrorCode::unsupported for a surface. Otherwise as RayCaster.
  /// @param method  for the largest values along rays
  explicit FieldSampler(const Dataset& data, std::string_view field = {}, const Method& method = Accuracy::float64,
                        const Watch& watch = {});
  ~FieldSampler();
  FieldSampler(const FieldSampler&);
  FieldSampler& operator=(const FieldSampler&);

  /// Finds the largest value along each ray, and the smallest t where it is reached. A ray that
  /// passes no data is a miss.
  void largest_values(const Rays& rays, const Hits& hits, RayScratch& scratch, const Watch& watch = {}) const;
  void largest_values(const Rays& rays, const Hits& hits, RenderContext& context, const Watch& watch = {}) const;

  /// Evaluates the field at points, in double precision. A point on a face between cells has a
  /// value if one of the cells has data.
  /// @param points  [points, 3], F32 or F64, finite, world axes
  /// @param values  one per point; NaN: no data there
  /// @param cells   empty, or one per point: the id of its cell, or no_cell
  void at(const ArrayView& points, std::span<double> values, std::span<std::uint64_t> cells = {},
          const Watch& watch = {}) const;

  class RHORAY_INSIDE Implementation;

 private:
  std::shared_ptr<const Implementation> implementation_;
};

}  // namespace rhoray::RHORAY_ABI
