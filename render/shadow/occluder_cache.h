#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "render/shadow/occluders.h"

namespace rhoray::render::wide {

/// Keeps occluders from frame to frame: they depend on the isovalue and on the light's position in
/// the data's frame, not on the camera. The certain shadows of a surface are computed from the
/// second request on, whatever the light. Their cost arises once per surface, and an isovalue that
/// is shown for one frame does not pay for it. Not thread-safe.
class OccluderCache {
 public:
  /// The occluders are the same on every machine.
  /// @param stop  ends the search (ErrorCode::interrupted); then nothing of it is kept
  /// @return      null where OccluderSearch::source is
  std::shared_ptr<const LightOccluders> of(const OccluderSearch& search, const LoadedDataset& dataset,
                                           const RayQuery& query, const LightPlace& light, Machine machine,
                                           unsigned threads, const std::stop_token& stop = {});

 private:
  struct OfLight {
    LightPlace light;
    std::shared_ptr<const LightOccluders> occluders;
    Shadows shadows;
  };
  struct OfSurface {
    std::shared_ptr<const void> source;
    std::shared_ptr<const OccludingSurface> surface;
    std::vector<OfLight> lights;  ///< newest first
  };

  static constexpr std::size_t most_kept = 4;
  std::vector<OfSurface> kept_;  ///< newest first
};

}  // namespace rhoray::render::wide
