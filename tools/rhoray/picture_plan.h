#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/diary.h"
#include "render/load.h"
#include "render/render.h"
#include "tools/rhoray/option_values.h"

namespace rhoray::tools {

/// What may be said about a picture on the command line; what is not said is chosen by the data.
struct PictureOptions {
  std::string mode = "iso";
  std::string isovalue = "auto";  ///< a number, p95 (percentile), or auto (Otsu)
  std::string field;              ///< empty = the first
  PictureSize size;
  std::string view = "iso";
  std::optional<double> azimuth_deg, elevation_deg, zoom, fov_deg;
  bool orthographic = false;
  std::optional<double> orthographic_height;
  std::optional<Vec3> camera_position, camera_target, camera_up;
  std::optional<Color> surface_color, background;
  std::optional<double> specular;
  std::optional<Interval<double>> range;
  std::string normals;   ///< empty = flat in meshes, exact in grids
  std::string color_by;  ///< a field; empty = surface_color
  std::string colormap;  ///< empty = viridis
  std::string accuracy;  ///< empty = render::default_method, unless a method is named
  std::string method;
  std::vector<std::string> channels;
  std::string show = "color";  ///< or error, roots, iterations, cost: a heat map
  bool no_hierarchy = false;
};

/// What surfaces may be lit by.
std::vector<std::string> words_of_normals();

/// The rows of these options, for `render`.
std::vector<Option> picture_options(PictureOptions& options);

/// Everything that was chosen.
struct PicturePlan {
  render::Scene scene;
  render::FrameOptions frame;
  std::optional<render::DiaryPage> page;  ///< drawn instead of colours
  std::string isovalue_from;              ///< "given", "percentile 95", "Otsu's threshold"; empty for MIP and triangles
  bool surface_is_empty = false;          ///< the isosurface passes through no cell
};

render::ChannelSet channel_set(const std::vector<std::string>& names);

/// The isovalue that `text` stands for, and where it came from. Refuses one outside the field's range and percentages
/// outside [0, 100] (Trouble::usage).
struct Isovalue {
  double value = 0;
  std::string from;
};
Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field);

/// Opens a packed file, or an OpenVDB file, for rendering: refuses other foreign files with the way to pack them, and
/// an unknown field with the nearest one. Without a name it takes the first field that is not the same everywhere, or
/// the first when all are.
render::Volume load_shown(const std::filesystem::path& path, const std::string& field);

/// As above; refuses a surface, which has no fields (Trouble::invalid).
render::Volume load_volume(const std::filesystem::path& path, const std::string& field);

PicturePlan plan_picture(const PictureOptions& options, const render::Volume& volume);

/// The command that makes this picture again, every choice spelled out.
std::vector<std::string> reproducing_command(const PicturePlan& plan, const render::Volume& volume,
                                             const std::filesystem::path& input, const std::filesystem::path& output);

}  // namespace rhoray::tools
