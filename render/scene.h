#pragma once

#include <optional>
#include <string>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/camera.h"
#include "render/color_map.h"
#include "render/method.h"

namespace rhoray::render {

enum class Mode { isosurface, mip };

/// What a surface is lit by.
enum class Normals {
  exact,  ///< the gradient of the field in the hit's cell: in meshes the surface is flat in every cell
  smooth  ///< of meshes: linear in the cell between gradients at its points, each a mean over the cells around it
};

/// Colours by a field of the same file at each hit. Where it has no data the surface's own colour stays.
struct FieldColors {
  std::string field;
  ColorMap map = ColorMap::viridis;
  Interval<double>
      range{};  ///< from the map's first colour to its last; not empty. Values beyond have those of the ends
};

/// How an isosurface looks: linear RGB in [0, 1]. The light stands at the eye.
struct Surface {
  Vec3 color{0.78, 0.74, 0.68};
  std::optional<FieldColors> color_by{};
  Normals normals = Normals::exact;
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
