#pragma once

#include "tools/study/peers/embree.h"
#include "tools/study/peers/triangles.h"

namespace rhoray::study {

std::shared_ptr<EmbreeScene> embree_triangles(std::shared_ptr<Triangles> triangles);

}  // namespace rhoray::study
