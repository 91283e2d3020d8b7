#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

#include "formats/base/stoppable_mutex.h"
#include "render/query/kernels.h"
#include "render/shadow/occluder_heights.h"

/// The parts of isosurfaces that may occlude rays to a light. Each kind of data finds its own; the
/// height fields of directional lights are common to all.
namespace rhoray::render::wide {

/// The target of rays to a light, in a data's frame: a direction, or a position. Each ray ends no
/// farther from it than `reach`.
struct LightPlace {
  bool is_place = false;
  Vec3 at{0, 0, 0};
  double reach = 0;

  bool is_one_direction() const { return !is_place && reach == 0; }
  bool operator==(const LightPlace&) const = default;
};

/// Whether the parts of a surface that are certainly in shadow are computed, for a directional
/// light.
enum class Shadows { unknown, known };

/// The parts of one isosurface that may occlude rays with one start side.
struct Occluders {
  std::optional<OccluderHeights> heights;  ///< for a directional light
  std::shared_ptr<const void> parts = {};  ///< what Intersectors::any_hit of the kind of data reads
};

/// The same for one light, computed at the first request for a side. Any thread may call.
class LightOccluders {
 public:
  using Find = std::function<Occluders(StartSide, const std::stop_token&)>;
  explicit LightOccluders(Find find) : find_(std::move(find)) {}

  /// @param side  not unknown
  /// @param stop  ends the computation, which the next request then repeats, and the waiting for
  ///   another thread (ErrorCode::interrupted)
  const Occluders& of(StartSide side, const std::stop_token& stop = {}) const {
    OfSide& asked = sides_[side == StartSide::inside];
    if (const Occluders* const known = asked.known.load(std::memory_order_acquire)) return *known;
    const StoppableLock lock(asked.mutex, stop);
    if (!asked.found) {
      asked.found = find_(side, stop);
      asked.known.store(&*asked.found, std::memory_order_release);
    }
    return *asked.found;
  }

 private:
  struct OfSide {
    StoppableMutex mutex;
    std::optional<Occluders> found;
    std::atomic<const Occluders*> known = nullptr;  ///< found, for readers without the mutex
  };
  Find find_;
  mutable std::array<OfSide, 2> sides_;
};

/// One isosurface that may occlude light.
class OccludingSurface {
 public:
  virtual ~OccludingSurface() = default;

  virtual std::shared_ptr<const LightOccluders> of_light(Machine machine, const LightPlace& light,
                                                         Shadows shadows) const = 0;
  /// The same with known shadows.
  /// @param before  for this light without them
  virtual std::shared_ptr<const LightOccluders> with_shadows(Machine machine,
                                                             std::shared_ptr<const LightOccluders> before,
                                                             const LightPlace& light) const = 0;
};

/// How a kind of data finds such surfaces, for queries that its wide kernels answer. A stop request
/// may end both functions (ErrorCode::interrupted).
struct OccluderSearch {
  /// The object that stands for the surface as long as it is in use. Null where the occluders of
  /// this light are not known to be less than the whole surface.
  std::shared_ptr<const void> (*source)(const LoadedDataset& dataset, const RayQuery& query, const LightPlace& light,
                                        unsigned threads, const std::stop_token& stop);
  std::shared_ptr<const OccludingSurface> (*surface)(const LoadedDataset& dataset, const RayQuery& query,
                                                     std::shared_ptr<const void> source, unsigned threads,
                                                     const std::stop_token& stop);
};

}  // namespace rhoray::render::wide
