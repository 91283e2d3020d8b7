#pragma once

#include <cstddef>
#include <vector>

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
  double opacity = 1;      ///< share of the light behind that the surface holds back; 0: it is not traced
};

/// What is shown of one volume, and how it looks.
struct Layer {
  std::size_t volume = 0;  ///< index into the volumes that the scene is rendered with
  Mode mode = Mode::isosurface;
  double isovalue = 0;
  Method method{};
  Interval<double> window{};  ///< values shown from black to white in MIP; must not be empty there
  Surface surface{};
};

/// What a picture shows, and from where.
struct Scene {
  std::vector<Layer> layers = std::vector<Layer>(1);
  Camera camera{};
  Vec3 background{1, 1, 1};  ///< linear RGB
};

}  // namespace rhoray::render
