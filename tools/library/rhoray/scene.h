#pragma once

#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rhoray/dataset.h"
#include "rhoray/export.h"
#include "rhoray/progress.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// The accuracy levels, from the fastest to the most accurate. Commands and documents call float32
/// `float` and float64 `double`.
enum class Accuracy {
  preview,    ///< misses surfaces that a ray enters and leaves within one cell
  float32,    ///< every crossing that single precision resolves
  float64,    ///< every crossing that double precision resolves
  certified,  ///< proven: a miss is a miss, and a hit is within its error bound
  exact       ///< exact arithmetic decides everything
};

/// How rays are intersected: an accuracy level, or another method with its parameter.
class RHORAY_API Method {
 public:
  Method(Accuracy accuracy) : accuracy_(accuracy) {}

  /// A hit is a change of side between samples along the ray. Misses what is between two samples.
  /// @param step_cells  distance between samples, in cells; 0.0001 to 10000
  /// @param bisects     refines a hit by bisection, not by one linear step
  static Method sampled(double step_cells, bool bisects = false);
  /// The method of Parker et al. (IEEE TVCG 1999, appendices A and B), with its gaps.
  static Method paper();

  /// Nothing for the other methods.
  std::optional<Accuracy> accuracy() const { return accuracy_; }
  /// True if every hit has an error bound.
  bool proves_errors() const { return accuracy_ == Accuracy::certified || accuracy_ == Accuracy::exact; }
  double step_cells() const { return step_cells_; }  ///< 0 unless sampled
  bool bisects() const { return bisects_; }

  friend bool operator==(const Method&, const Method&) = default;

 private:
  Method() = default;

  std::optional<Accuracy> accuracy_{};
  double step_cells_ = 0;
  bool bisects_ = false;
};

/// Where the surface at an isovalue is shown. There is no default isovalue.
struct Isosurface {
  double isovalue = std::numeric_limits<double>::quiet_NaN();
};

/// The triangles of a surface or of a mesh's boundary.
struct Triangles {};

/// How values become colours.
struct ColorScale {
  std::string colormap = "viridis";  ///< a name of `rhoray help render`; `_r` at its end reverses it
  std::optional<Interval> range{};   ///< values at the ends of the map; nothing: the field's range
  bool is_logarithmic = false;       ///< by the logarithm of the value; the range is above 0
  int levels = 0;                    ///< bands of one colour, 2 to 65,536; 0: continuous

  friend bool operator==(const ColorScale&, const ColorScale&) = default;
};

/// The largest value along each ray (MIP).
struct MaximumProjection {
  ColorScale colors{.colormap = "gray"};
};

/// The field on a plane. Nothing is shown where there is no data. Only the opacity of the layer's
/// material counts.
struct Slice {
  HalfSpace plane;
  ColorScale colors{};
  std::optional<Interval> threshold{};  ///< only values within are shown; lo <= hi
  bool is_lit = false;                  ///< false: shows its own colours, without light
};

/// Colours a surface by a field of its data. The surface keeps its own colour where the field has
/// no data.
struct FieldColors {
  std::string field;
  ColorScale colors{};
};

/// Where normals for shading come from.
enum class Normals {
  exact,  ///< isosurfaces: the gradient of the field in the cell that is hit; triangles: their own
  smooth  ///< interpolated: gradients of the field at samples or points, or normals at corners
};

/// Appearance of a surface. Both sides look the same. Colours are linear RGB, 0 to 1.
struct Material {
  Vec3 color{0.78, 0.74, 0.68};
  std::optional<FieldColors> color_by{};
  std::optional<Texture> texture{};  ///< not together with color_by
  std::optional<Normals> normals{};  ///< nothing: smooth, but exact on isosurfaces of meshes
  double ambient = 0.12;             ///< share of ambient light, 0 to 1
  double specular = 0.25;            ///< strength of highlights, 0 to 1; 0: they are not computed
  double shininess = 40;             ///< Blinn-Phong exponent, 1 to 10,000
  double opacity = 1;                ///< 0 to 1
};

/// What is shown of one dataset, and how.
struct Layer {
  Dataset data;
  std::variant<Isosurface, MaximumProjection, Slice, Triangles> show;
  std::string field{};  ///< empty: the first that is not constant
  Material material{};
  std::optional<Method> method{};  ///< nothing: float32 where it has fast kernels, else float64
  bool is_clipped = true;          ///< false: shown whole, whatever Scene::clip removes of others
};

/// A light. Its intensity does not decrease with distance.
struct Light {
  enum class Kind {
    head,         ///< at the eye
    directional,  ///< from one direction
    point         ///< at a position
  };

  Kind kind = Kind::head;
  /// Directional: the direction towards the light. Point: its position. Both must set it.
  Vec3 place{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(),
             std::numeric_limits<double>::quiet_NaN()};
  Vec3 color{1, 1, 1};
  bool casts_shadows = false;
  /// The size of the light, which makes shadows soft; 0: sharp shadows. Directional: the angle under
  /// which the light is seen, in degrees, 0 to 180. Point: its radius in world units, from 0 up.
  double size = 0;
  int samples = 16;  ///< shadow rays per hit towards a light with a size, 1 to 4096
};

/// Ambient occlusion.
struct Occlusion {
  int samples = 16;   ///< rays per hit, 1 to 4096
  double radius = 0;  ///< distance within which surfaces occlude, world units; 0: no occlusion
};

/// Surfaces fade into a colour with the distance from the eye.
struct Fog {
  Vec3 color{1, 1, 1};
  Interval range{};  ///< world units: no fog up to `lo`, full fog from `hi`; must be set, lo < hi
};

/// Clipped layers are shown inside the box and all half spaces only. At least one of them is given.
struct Clip {
  std::optional<Box3> box{};
  std::vector<HalfSpace> planes{};  ///< at most 6
  bool is_inverted = false;         ///< they are shown outside only
};

/// The camera of a picture, in world axes.
struct Camera {
  Vec3 position{0, -1, 0};
  Vec3 target{};
  Vec3 up{0, 0, 1};              ///< not along the direction of view
  double vertical_fov_deg = 30;  ///< full angle, above 0 and below 180
  /// Height of the picture in world units. Nothing: a perspective camera.
  std::optional<double> orthographic_height{};
};

/// A scene. A value like any other; a call must not run while it changes.
struct Scene {
  std::vector<Layer> layers{};     ///< 1 to 254
  std::optional<Camera> camera{};  ///< must be set (fit_camera)
  std::vector<Light> lights = {Light{}};
  Occlusion occlusion{};
  std::optional<Fog> fog{};
  std::optional<Clip> clip{};
  /// Linear RGB. Nothing: pictures keep their alpha.
  std::optional<Vec3> background = Vec3{1, 1, 1};
};

/// A direction of view.
struct View {
  double azimuth_deg = 30;    ///< 0 looks along +y, with +x to the right and +z up; 90 looks from +x
  double elevation_deg = 20;  ///< 90 looks straight down
  double zoom = 1;            ///< above 0; 1: what is shown fills 90 % of the picture's width or height
  double vertical_fov_deg = 30;
  bool is_orthographic = false;
};

/// Returns a camera that sees everything that the layers show, after clipping. It reads every cell
/// of a mesh, and of a grid those that isosurfaces may cross.
/// Throws ErrorCode::usage for a scene without layers, and for numbers out of range;
/// ErrorCode::interrupted if stopped.
RHORAY_API Camera fit_camera(const Scene& scene, const Size& size, const View& view = {}, const Watch& watch = {});
/// Returns a camera that sees a box. Throws ErrorCode::usage for an empty box.
RHORAY_API Camera fit_camera(const Box3& box, const Size& size, const View& view = {});

}  // namespace rhoray::RHORAY_ABI
