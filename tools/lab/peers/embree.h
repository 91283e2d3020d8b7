#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <memory>
#include <optional>

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// The scene that Embree traces; shared by the two ways of tracing it.
class EmbreeScene {
 public:
  EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  virtual ~EmbreeScene();

  virtual std::string named(const std::string& way) const = 0;  ///< "Embree, packets"
  virtual std::string shows() const = 0;                        ///< "triangles of FlyingEdges"
  virtual Vec3 middle() const { return Vec3(0); }               ///< origin of its positions

  /// Does nothing if the scene is for this isovalue already.
  Preparation prepare(const PeerData& data, double isovalue);
  RTCScene scene() const { return scene_; }
  double memory_mb() const;  ///< as Embree counts it

 protected:
  virtual Preparation build(const PeerData& data, double isovalue) = 0;

  void start();  ///< replaces the last scene by an empty one
  /// Adds the scene's only geometry and takes ownership of it. Null: the scene stays empty.
  void finish(RTCGeometry geometry);

  RTCDevice device() const { return device_; }

 private:
  std::atomic<std::int64_t> bytes_{0};
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::optional<double> isovalue_;
  Preparation preparation_;
};

/// Coherent packets of 16 rays, 4 x 4 pixels.
PeerPointer embree_packets(std::shared_ptr<EmbreeScene> scene);
PeerPointer embree_single_rays(std::shared_ptr<EmbreeScene> scene);

}  // namespace rhoray::study
