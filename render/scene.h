#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/camera.h"
#include "render/clip.h"
#include "render/color_map.h"
#include "render/method.h"
#include "render/texture.h"

namespace rhoray::render {

enum class Mode {
  isosurface,
  mip,
  triangles,  ///< of a surface (Volume::is_surface), which is shown in no other way
  slice       ///< the field on a plane
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

/// How a surface looks: linear RGB in [0, 1]. Both of its sides look alike.
struct Surface {
  Vec3 color{0.78, 0.74, 0.68};
  std::optional<FieldColors> color_by{};
  std::optional<Texture> texture{};  ///< covers the surface's own colour where it has texels; not beside color_by
  Normals normals = Normals::exact;
  double ambient = 0.12;   ///< share of light that comes from everywhere, white; lights give the rest
  double specular = 0.25;  ///< 0: no highlight is computed
  double shininess = 40;   ///< Blinn-Phong exponent
  bool lit = true;         ///< slices may not be: they show their own colours, and neither ambient light nor others
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
  /// Of slices, which are coloured by the volume's own field (Surface::color_by), trilinear or linear in its cells, in
  /// double precision at every level. Nothing is shown where there is no data. A slice holds no light back. Of a slice
  /// and a surface at the same t the slice is shown; a slice in a face of the clip region is met at that face's t.
  HalfSpace plane{};  ///< its normal may point either way
  Interval<double> threshold{-std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::infinity()};  ///< only values within are shown
  bool clipped = true;  ///< false: it is shown whole, whatever Scene::clip takes away of others
};

/// What shines on surfaces. Light does not grow weaker with distance.
struct Light {
  enum class Kind {
    head,         ///< stands at the eye
    directional,  ///< comes from one direction
    point         ///< stands in a place
  };

  Kind kind = Kind::head;
  Vec3 place{0, 0, 0};  ///< directional: the direction towards it, of any length; point: where it stands; world axes
  Vec3 color{1, 1, 1};  ///< linear RGB, its intensity included; 0: it is dropped
  /// Opaque isosurfaces hold its light back from all surfaces, clear ones and themselves included; clear surfaces and
  /// largest values let all of it through. Hits lie where their method says: those of the methods `paper` and
  /// `sampled`, which may lie off the surface, may be in its shadow. A head light's shadows are never seen.
  bool casts_shadows = false;
  /// How large it is to shadows: of a directional light the angle under which it is seen, degrees up to 180; of one in
  /// a place the radius of a ball around it, world units. 0: a point, whose shadows have sharp edges, by one ray of
  /// each hit. What stands within the ball may hold its light back.
  double size = 0;
  int samples = 16;  ///< rays of each hit towards points spread over a light that has a size, at most 4096
};

/// How much of the ambient light reaches a surface: what opaque isosurfaces nearby hold back of it is found out by a
/// number of rays.
struct Occlusion {
  int samples = 16;   ///< rays of each hit, at most 4096
  double radius = 0;  ///< how far away surfaces hold light back, world units; 0: there is no occlusion
};

/// Surfaces fade into a colour with their distance from where rays start; the background does not.
struct Fog {
  Vec3 color{1, 1, 1};  ///< linear RGB
  Interval<double>
      range{};  ///< distances, world units: up to the first nothing fades, from the second on all; not empty
};

/// What a picture shows, and from where.
struct Scene {
  std::vector<Layer> layers = std::vector<Layer>(1);
  std::vector<Light> lights = std::vector<Light>(1);
  Occlusion occlusion{};
  std::optional<Fog> fog{};
  std::optional<Clip> clip{};
  Camera camera{};
  Vec3 background{1, 1, 1};  ///< linear RGB
};

}  // namespace rhoray::render
