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
  triangles,  ///< for surfaces (Dataset::is_surface), which have no other mode
  slice       ///< the field on a plane
};

/// Where the normals for shading come from.
enum class Normals {
  /// The gradient of the field in the hit's cell. In meshes the surface is then flat in every cell,
  /// as triangles are.
  exact,
  /// Of grids: interpolated trilinearly in the cell between gradients at its samples, each of
  /// central differences. They are continuous across cells, as the exact gradient is not. Of
  /// meshes: interpolated linearly in the cell between gradients at its points, each a mean over
  /// the cells around it. Of triangles: interpolated between normals at their corners, which are
  /// angle-weighted means of the triangles there, up to edges of 30 degrees and more.
  smooth
};

/// Colours hits by a field of the same file. Where that field has no data, the surface keeps its
/// own colour.
struct FieldColors {
  std::string field;
  ColorMap map = ColorMap::viridis;
  /// Values at the first and last colour of the map; not empty. Values outside get the colours of
  /// its ends.
  Interval<double> range{};
  ColorScale scale{};
};

/// Material of a surface; colours are linear RGB in [0, 1]. Both sides of the surface look the
/// same.
struct Material {
  Vec3 color{0.78, 0.74, 0.68};
  std::optional<FieldColors> color_by{};
  /// Replaces the surface's own colour where it has texels; not together with color_by.
  std::optional<Texture> texture{};
  Normals normals = Normals::exact;
  double ambient = 0.12;   ///< white ambient light, as a share of all light; lights give the rest
  double specular = 0.25;  ///< 0: no highlight is computed
  double shininess = 40;   ///< Blinn-Phong exponent
  /// May be false for slices: they then show their own colours, with no ambient or other light.
  bool lit = true;
  double opacity = 1;  ///< opacity, 0 to 1; 0: the surface is not traced
};

/// What is shown of one dataset, and how.
struct Layer {
  std::size_t dataset = 0;  ///< index into the datasets that the scene is rendered with
  Mode mode = Mode::isosurface;
  double isovalue = 0;  ///< of isosurfaces
  Method method{};
  Interval<double> window{};  ///< values at the ends of the map in MIP; must not be empty there
  /// Of MIP. Each channel brightens what is behind, so maps that begin dark suit it.
  ColorMap map = ColorMap::gray;
  ColorScale scale{};  ///< of MIP
  Material material{};
  /// The plane of a slice. Slices are coloured by the dataset's own field (Material::color_by),
  /// which is trilinear, or linear in the cells of a mesh, in double precision at every level.
  /// Nothing is shown where there is no data. A slice casts no shadow. Where a slice and a surface
  /// have the same t, the slice is shown. A slice in a face of the clip region is hit at that
  /// face's t.
  HalfSpace plane{};  ///< its normal may point either way
  /// Only values within are shown.
  Interval<double> threshold{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  bool clipped = true;  ///< false: shown whole, even where Scene::clip removes parts of others
};

/// A light source. Its intensity does not decrease with distance.
struct Light {
  enum class Kind {
    head,         ///< at the eye
    directional,  ///< from one direction
    point         ///< at a position
  };

  Kind kind = Kind::head;
  /// Directional: direction towards the light, of any length; point: its position; world axes.
  Vec3 place{0, 0, 0};
  Vec3 color{1, 1, 1};  ///< linear RGB, including intensity; 0: the light is ignored
  /// Opaque isosurfaces cast this light's shadows on all surfaces, including transparent ones and
  /// themselves. Transparent surfaces and MIP layers cast none. Hits are where their method puts
  /// them: those of the methods `paper` and `sampled` may be off the surface and therefore in its
  /// shadow. Shadows of a head light are never visible.
  bool casts_shadows = false;
  /// Size of the light for shadows. Directional: the angle under which it is seen, in degrees up to
  /// 180. Point: the radius of a ball around it, in world units. 0: a point light with sharp
  /// shadows, one shadow ray per hit. Objects within the ball may occlude the light.
  double size = 0;
  /// Shadow rays per hit, towards points spread over a light with a size; at most 4096.
  int samples = 16;

  friend bool operator==(const Light&, const Light&) = default;
};

/// Ambient occlusion: how much of the ambient light nearby opaque isosurfaces hold back, estimated
/// with a number of rays.
struct Occlusion {
  int samples = 16;   ///< rays per hit, at most 4096
  double radius = 0;  ///< distance within which surfaces occlude, world units; 0: no occlusion
};

/// Surfaces fade into a colour with the distance from the ray's origin; the background does not.
struct Fog {
  Vec3 color{1, 1, 1};  ///< linear RGB
  /// Distances, world units: no fog up to the first, full fog from the second; not empty.
  Interval<double> range{};
};

/// What a picture shows, and its camera.
struct Scene {
  std::vector<Layer> layers = std::vector<Layer>(1);
  std::vector<Light> lights = std::vector<Light>(1);
  Occlusion occlusion{};
  std::optional<Fog> fog{};
  std::optional<Clip> clip{};
  Camera camera{};
  Vec3 background{1, 1, 1};             ///< linear RGB
  bool transparent_background = false;  ///< nothing is behind instead; pictures keep their alpha
};

}  // namespace rhoray::render
