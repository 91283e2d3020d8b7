#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/camera.h"
#include "render/color_map.h"
#include "render/method.h"

namespace rhoray::render {

enum class Mode {
  isosurface,
  mip,
  triangles  ///< of a surface (Volume::is_surface), which is shown in no other way
};

/// What a surface is lit by.
enum class Normals {
  exact,  ///< the gradient of the field in the hit's cell: in meshes the surface is flat in every cell, as triangles
          ///< are
  smooth  ///< of meshes: linear in the cell between gradients at its points, each a mean over the cells around it;
          ///< of triangles: between normals at their corners, means by the angles of the triangles there
};

/// Colours by a field of the same file at each hit. Where it has no data the surface's own colour stays.
struct FieldColors {
  std::string field;
  ColorMap map = ColorMap::viridis;
  /// From the map's first colour to its last; not empty. Values beyond have the colours of its ends.
  Interval<double> range{};
};

/// How a surface looks: linear RGB in [0, 1]. The light stands at the eye.
struct Surface {
  Vec3 color{0.78, 0.74, 0.68};
  std::optional<FieldColors> color_by{};
  Normals normals = Normals::exact;
  double ambient = 0.12;
  double specular = 0.25;  ///< 0: no highlight is computed
  double shininess = 40;   ///< Blinn-Phong exponent
  double opacity = 1;      ///< share of the light behind that the surface holds back; 0: it is not traced
};

/// What is shown of one volume, and how it looks.
struct Layer {
  std::size_t volume = 0;  ///< index into the volumes that the scene is rendered with
  Mode mode = Mode::isosurface;
  double isovalue = 0;  ///< of isosurfaces
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
