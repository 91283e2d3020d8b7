#pragma once

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/camera.h"
#include "render/method.h"

namespace rhoray::render {

enum class Mode { isosurface, mip };

/// How an isosurface looks: linear RGB in [0, 1]. The light stands at the eye.
struct Surface {
  Vec3 color{0.78, 0.74, 0.68};
  double ambient = 0.12;
  double specular = 0.25;  ///< 0: no highlight is computed
  double shininess = 40;   ///< Blinn-Phong exponent
};

/// One picture of one volume: what it shows, from where, and how it looks.
struct Scene {
  Mode mode = Mode::isosurface;
  double isovalue = 0;
  Method method{};
  Interval<double> window{};  ///< values shown from black to white in MIP; must not be empty there
  Camera camera{};
  Surface surface{};
  Vec3 background{1, 1, 1};  ///< linear RGB
};

}  // namespace rhoray::render
