#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "render/scene.h"

namespace rhoray::render {

// The requested scene, as options or a scene document (document.h) say it. What is not given is
// chosen from the data.

struct PictureSize {
  int width = 960;
  int height = 720;
};
/// Reads WxH, 720p, 1080p or 4k; sides from 1 to 65,536. Refuses other texts (ErrorCode::usage).
void read_value(const std::string& text, PictureSize& out);

/// Linear RGB.
struct Color {
  Vec3 linear;
};
/// Reads #rrggbb (sRGB) or three linear numbers r,g,b in [0, 1]. Refuses other texts
/// (ErrorCode::usage).
void read_value(const std::string& text, Color& out);

/// The background of a picture.
struct Background {
  std::optional<Color> color{};  ///< nothing: there is none, and the picture keeps its alpha
};
/// Reads none, or a colour as above. Refuses other texts (ErrorCode::usage).
void read_value(const std::string& text, Background& out);

/// How a file that is not packed is read. What is not given is as the file says.
struct ReadSpec {
  std::string raw{};  ///< samples without a header: 256x256x128:uint16:le, as for `rhoray pack --raw`
  std::optional<Vec3> spacing{}, origin{};
  std::string time{};  ///< a time step, as for `rhoray pack --time`
};

/// A file, opened for one of its fields.
struct DataSpec {
  std::string name{};  ///< by which layers ask for it
  std::filesystem::path file{};
  std::string field{};  ///< empty = the first that is not the same everywhere
  /// A label of a segmentation. The data are then 1 at the samples with this label and 0 at others.
  std::optional<int> label{};
  ReadSpec read{};
};

enum class LayerType {
  isosurface,
  mip,
  triangles,
  slice,
  boundary,  ///< of a mesh
  automatic  ///< by the kind of data: a mesh's boundary if nothing asks for an isosurface, else that
};

struct LayerSpec {
  LayerType type = LayerType::isosurface;
  std::string data{};                          ///< a DataSpec's name; empty = the only one
  std::vector<std::string> isovalues{"auto"};  ///< numbers, p95 (percentile), or auto; one surface each
  std::optional<Interval<double>> range{};     ///< of MIP, or of color_by
  std::optional<Color> color{};
  std::string normals{};  ///< a word; empty = flat in meshes, else the style's
  /// A field of the data. Empty: color; on a boundary without color, the field that the data show.
  std::string color_by{};
  std::string colormap{};  ///< a word; empty = viridis
  std::string scale{};     ///< a word, of the colours; empty = linear
  std::optional<int> levels{};
  std::string texture{};  ///< name of the data whose colours cover the surface; empty = none
  std::optional<double> ambient{}, specular{}, shininess{}, opacity{};
  std::string accuracy{};  ///< a level; empty = the scene's
  std::string method{};    ///< instead of a level
  bool visible = true;
  std::optional<bool> clip{};  ///< false: shown whole
  std::string axis{};          ///< of slices: a word; empty = point and normal
  std::optional<double> position{};
  std::optional<Vec3> point{}, normal{};
  std::optional<Interval<double>> threshold{};
  std::optional<bool> lit{};
  std::optional<double> feature_edges{};  ///< of triangles: degrees, as for Dataset::feature_edges
  /// Opacity of the mesh's boundary around the layer's isosurfaces. Without a value, only automatic
  /// layers show the boundary.
  std::optional<double> context{};
};

/// The camera, or the isovalue of a scene's only isosurface, at a time.
struct KeyframeSpec {
  double time = 0;
  std::optional<double> azimuth_deg{}, elevation_deg{}, zoom{}, fov_deg{};
  std::optional<double> orthographic_height{};
  std::optional<Vec3> position{}, target{}, up{};
  std::optional<double> isovalue{};
};

struct CameraSpec {
  std::optional<std::string> view{};
  std::optional<double> azimuth_deg{}, elevation_deg{}, zoom{}, fov_deg{};
  std::optional<bool> orthographic{};
  std::optional<double> orthographic_height{};  ///< implies orthographic
  std::optional<Vec3> position{}, target{}, up{};
  std::optional<std::string> up_axis{};  ///< a word: the axis of the world that is up in the data
  std::optional<std::vector<KeyframeSpec>> keyframes{};
};

struct PictureSpec {
  /// Nothing: as many pixels as PictureSize has by default. Where the camera is fitted, the picture
  /// is as wide as what is shown and its scales, from 2/3 to 2 times its height.
  std::optional<PictureSize> size{};
  std::optional<Background> background{};
  std::optional<std::vector<std::string>> channels{};
  std::optional<std::string> show{};  ///< color, or a heat map
  std::optional<bool> hierarchy{};    ///< false: every leaf cell is walked
  std::optional<int> antialias{};     ///< most samples of a pixel
  std::optional<int> frames{};        ///< from the camera's first key frame to its last
};

struct LightSpec {
  Light::Kind type = Light::Kind::head;
  std::optional<Vec3> direction{};  ///< towards it
  std::optional<double> azimuth_deg{}, elevation_deg{};
  std::string from{};  ///< a word: what the angles count from; empty = the world
  std::optional<Vec3> position{};
  std::optional<Color> color{};
  std::optional<double> intensity{};
  std::optional<bool> shadows{};
  std::optional<double> angular_diameter_deg{};  ///< of a directional light
  std::optional<double> radius{};                ///< of a point light
  std::optional<int> samples{};                  ///< of one that has a size
};

struct OcclusionSpec {
  std::optional<int> samples{};
  std::optional<double> radius{};  ///< default a share of what is shown
};

struct FogSpec {
  std::optional<Color> color{};  ///< default the background
  std::optional<Interval<double>> range{};
};

/// Of the whole picture.
struct EffectsSpec {
  std::optional<OcclusionSpec> occlusion{};
  std::optional<FogSpec> fog{};
};

/// Words of ClipSpec::keep.
inline constexpr const char* keep_inside = "inside";
inline constexpr const char* keep_outside = "outside";

struct ClipSpec {
  std::optional<Box3> box{};
  std::vector<HalfSpace> planes{};
  std::string keep{};  ///< a word; empty = inside
};

/// Arrows along the world's axes.
struct AxesSpec {
  std::string corner{};  ///< a word; empty = left
};

struct ColorBarSpec {
  std::string title{};     ///< empty = the field's name and unit
  std::string position{};  ///< a word; empty = right
};

/// Annotations over the finished picture.
struct AnnotationsSpec {
  std::optional<AxesSpec> axes{};
  std::optional<bool> box{};  ///< around what is shown, with numbers
  std::optional<ColorBarSpec> color_bar{};
  std::optional<bool> legend{};  ///< of isosurfaces; default where their colours stand for isovalues
  std::string caption{};
};

struct SceneSpec {
  std::vector<DataSpec> data{};
  std::vector<LayerSpec> layers{};
  std::string style{};                             ///< a word; empty = default
  std::optional<std::vector<LightSpec>> lights{};  ///< default the style's
  EffectsSpec effects{};
  std::optional<ClipSpec> clip{};
  CameraSpec camera{};
  PictureSpec image{};
  AnnotationsSpec annotations{};
  std::string accuracy{};  ///< of layers that name none; empty = default_method
  std::string space{};     ///< a word: of the picture's world, where files say which is theirs; empty = ras
  std::string document{};  ///< what the scene was read from; empty: the command line
};

inline constexpr std::size_t most_layers = 254;  ///< that a frame takes
inline constexpr std::size_t most_lights = 64;

/// Limits of numbers.
namespace limits {
inline constexpr Interval<double> elevation_deg{-90, 90};
inline constexpr Interval<double> zoom{1e-6, 1e6};
inline constexpr Interval<double> fov_deg{0.001, 179};
inline constexpr Interval<double> share{0, 1};  ///< ambient, specular, opacity
inline constexpr Interval<double> shininess{1, 1e4};
inline constexpr Interval<double> feature_edges{0, 180};
inline constexpr Interval<int> levels{2, 256};  ///< of colours
inline constexpr Interval<double> percentile{0, 100};
inline constexpr Interval<double> intensity{0, 1e4};
inline constexpr Interval<int> occlusion_samples{1, 4096};
inline constexpr Interval<int> pixel_samples{1, 64};
inline constexpr Interval<int> frames{1, 100000};
inline constexpr Interval<double> angular_diameter_deg{0, 180};
inline constexpr Interval<int> light_samples{1, 4096};
inline constexpr Interval<std::size_t> drawn_text{1, 2000};  ///< characters of a text in the picture
}  // namespace limits

}  // namespace rhoray::render
