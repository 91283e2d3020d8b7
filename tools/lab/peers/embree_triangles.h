#pragma once

#include "tools/lab/peers/embree.h"
#include "tools/lab/peers/triangles.h"

namespace rhoray::study {

std::shared_ptr<EmbreeScene> embree_triangles(std::shared_ptr<Triangles> triangles);

}  // namespace rhoray::study
