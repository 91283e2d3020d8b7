#pragma once

#include "tools/study/peers/triangles.h"

namespace rhoray::study {

/// Embree over the triangles; the scene is shared by the two ways of tracing it.
class EmbreeScene;
std::shared_ptr<EmbreeScene> embree_scene(std::shared_ptr<Triangles> triangles);
PeerPointer embree_packets(std::shared_ptr<EmbreeScene> scene);  ///< coherent packets of 16 rays, 4 x 4 pixels
PeerPointer embree_single_rays(std::shared_ptr<EmbreeScene> scene);

}  // namespace rhoray::study
