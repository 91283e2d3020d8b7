#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <memory>
#include <optional>

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// What Embree traces; shared by the two ways of tracing it.
class EmbreeScene {
 public:
  EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  virtual ~EmbreeScene();

  virtual std::string named(const std::string& way) const = 0;  ///< "Embree, packets"
  virtual std::string shows() const = 0;                        ///< "triangles of FlyingEdges"
  virtual Vec3 middle() const { return Vec3(0); }               ///< what its positions are relative to

  Preparation prepare(const PeerData& data, double isovalue);  ///< unless it is this isovalue's already
  RTCScene scene() const { return scene_; }
  double memory_mb() const;  ///< as Embree counts it

 protected:
  virtual Preparation build(const PeerData& data, double isovalue) = 0;

  void start();                       ///< an empty scene instead of the last one
  void finish(RTCGeometry geometry);  ///< the scene's only geometry, which is given away; null: it stays empty

  RTCDevice device() const { return device_; }

 private:
  std::atomic<std::int64_t> bytes_{0};
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::optional<double> isovalue_;
  Preparation preparation_;
};

PeerPointer embree_packets(std::shared_ptr<EmbreeScene> scene);  ///< coherent packets of 16 rays, 4 x 4 pixels
PeerPointer embree_single_rays(std::shared_ptr<EmbreeScene> scene);

}  // namespace rhoray::study
