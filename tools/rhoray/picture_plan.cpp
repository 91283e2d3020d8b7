#include "tools/rhoray/picture_plan.h"

#include <algorithm>
#include <utility>

#include "formats/base/nearest_name.h"
#include "formats/base/trouble.h"
#include "formats/shape_field.h"
#include "preprocess/import_mesh.h"
#include "preprocess/open_vdb.h"
#include "render/color_map.h"
#include "tools/rhoray/common_options.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/method_words.h"

namespace rhoray::tools {

namespace {

/// A channel's word and its place in the set.
constexpr std::pair<const char*, bool render::ChannelSet::*> channel_words[] = {
    {"depth", &render::ChannelSet::depth},
    {"normal", &render::ChannelSet::normal},
    {"cell", &render::ChannelSet::cell},
    {"value", &render::ChannelSet::value},
    {"error", &render::ChannelSet::error},
    {"roots", &render::ChannelSet::roots},
    {"iterations", &render::ChannelSet::iterations},
    {"cost", &render::ChannelSet::cost}};

constexpr std::pair<const char*, render::DiaryPage> diary_words[] = {{"error", render::DiaryPage::error},
                                                                     {"roots", render::DiaryPage::roots},
                                                                     {"iterations", render::DiaryPage::iterations},
                                                                     {"cost", render::DiaryPage::cost}};

std::vector<std::string> words_of_show() {
  std::vector<std::string> words{"color"};
  for (const auto& [word, page] : diary_words) words.emplace_back(word);
  return words;
}

/// What a surface may be lit by, and in what it is.
constexpr struct {
  const char* word;
  render::Normals normals;
  bool of_meshes;
} normals_words[] = {{"flat", render::Normals::exact, true},
                     {"smooth", render::Normals::smooth, true},
                     {"exact", render::Normals::exact, false}};

std::vector<std::string> words_of_colormaps() {
  std::vector<std::string> words;
  for (const render::NamedColorMap& named : render::color_maps()) words.emplace_back(named.name);
  return words;
}

std::string text_of(const Vec3& v) {
  return concat(v.x, ",", v.y, ",", v.z);
}

render::Camera plan_camera(const PictureOptions& options, const Box3& box) {
  render::View view = render::named_view(options.view);
  view.azimuth_deg = options.azimuth_deg.value_or(view.azimuth_deg);
  view.elevation_deg = options.elevation_deg.value_or(view.elevation_deg);
  view.zoom = options.zoom.value_or(view.zoom);
  view.vertical_fov_deg = options.fov_deg.value_or(view.vertical_fov_deg);
  view.orthographic = options.orthographic || options.orthographic_height.has_value();
  require_within("--elevation", view.elevation_deg, -90, 90);
  require_within("--zoom", view.zoom, 1e-6, 1e6);
  require_within("--fov", view.vertical_fov_deg, 0.001, 179);

  render::Camera camera = render::fit_camera(box, view, static_cast<double>(options.size.width) / options.size.height);
  camera.position = options.camera_position.value_or(camera.position);
  camera.target = options.camera_target.value_or(camera.target);
  camera.up = options.camera_up.value_or(camera.up);
  camera.orthographic_height = options.orthographic_height.value_or(camera.orthographic_height);
  if (!(camera.orthographic_height > 0)) throw Error(Trouble::usage, "--ortho-height: expected a height above 0");
  const Vec3 forward = camera.target - camera.position;
  if (!(forward.cross(camera.up).length() > 0))
    throw Error(Trouble::usage, "the camera has no direction: position, target and up lie on one line",
                "give another --camera-up or --camera-target");
  return camera;
}

/// "0 to 255 HU of field 'density'".
std::string range_text(const formats::FieldSummary& field) {
  return concat(field.range.lo, " to ", field.range.hi, field.unit.empty() ? "" : " ", field.unit, " of field '",
                field.name, "'");
}

}  // namespace

std::vector<std::string> words_of_normals() {
  std::vector<std::string> words;
  for (const auto& row : normals_words) words.emplace_back(row.word);
  return words;
}

std::vector<Option> picture_options(PictureOptions& options) {
  return {
      choice_option("--mode", {"iso", "mip"},
                    "Isosurface, or maximum intensity projection; a surface is shown as it is", options.mode),
      value_option(
          "--iso", "V",
          "Isovalue: a number, p95 (percentile), or auto (Otsu's threshold; of boundary_distance a ten-thousandth of "
          "the largest); default auto",
          options.isovalue),
      value_option("--field", "NAME", "Field to show; default the first", options.field),
      value_option("--size", "WxH", "Pixels, or 720p, 1080p, 4k; default 1280x720", options.size),
      value_option("--view", "WORD", "Side to look from: iso (three-quarter), +x, -x, +y, -y, +z, -z; default iso",
                   options.view),
      value_option("--azimuth", "DEG", "Angle around the world's z axis; 0 looks along +y", options.azimuth_deg),
      value_option("--elevation", "DEG", "Angle above the horizon; 90 looks straight down", options.elevation_deg),
      value_option("--zoom", "FACTOR", "1: the data just fits; 2: twice as large", options.zoom),
      value_option("--fov", "DEG", "Vertical opening angle; default 30", options.fov_deg),
      flag_option("--ortho", "Orthographic projection", options.orthographic),
      value_option("--ortho-height", "H", "World units that the picture's height shows; implies --ortho",
                   options.orthographic_height),
      value_option("--camera-position", "X,Y,Z", "Eye, in world units; default fitted to the data",
                   options.camera_position),
      value_option("--camera-target", "X,Y,Z", "Point looked at", options.camera_target),
      value_option("--camera-up", "X,Y,Z", "Direction that is up in the picture", options.camera_up),
      value_option("--surface-color", "COLOR", "#rrggbb (sRGB), or r,g,b (linear, 0 to 1)", options.surface_color),
      choice_option("--normals", words_of_normals(),
                    "What the surface of a mesh, or a surface by itself, is lit by: flat, the exact gradient of each "
                    "cell or normal of each triangle, or smooth, linear between means at the points; of a grid exact, "
                    "the gradient of its trilinear field",
                    options.normals),
      value_option("--color-by", "NAME", "Colour the surface by a field of the same file, where rays hit it",
                   options.color_by),
      choice_option("--colormap", words_of_colormaps(), "Colours of --color-by; default viridis", options.colormap),
      value_option("--background", "COLOR", "As above; default white for isosurfaces, black for MIP",
                   options.background),
      value_option("--specular", "S", "Strength of the highlight, 0 to 1; 0 computes none", options.specular),
      value_option("--range", "A,B",
                   "Values shown from black to white in MIP, or from the first colour to the last by --color-by; "
                   "default the field's range",
                   options.range),
      choice_option(
          "--accuracy", accuracy_words(),
          "preview: a first look; float: single precision inside cells; double: double precision; certified: every hit "
          "and miss proven, with a bound of its error; exact: every decision in exact arithmetic, slow. Default float "
          "for isosurfaces of meshes and of uniform, dense grids, which many rays cross at once, else double",
          options.accuracy),
      value_option("--method", "NAME", method_help(), options.method),
      value_option("--channels", "A,B",
                   "Also keep depth, normal, cell, value; error (certified, exact), roots, iterations, cost (EXR only)",
                   options.channels),
      choice_option("--show", words_of_show(),
                    "A heat map instead of colours: error (certified, exact), roots in the hit cell, iterations of the "
                    "root, cost (cells visited); default color",
                    options.show),
      flag_option("--no-hierarchy", "Walk every leaf cell, for comparison; the same picture at double",
                  options.no_hierarchy)};
}

render::ChannelSet channel_set(const std::vector<std::string>& names) {
  render::ChannelSet set;
  std::vector<std::string> known;
  std::string known_text;
  for (const auto& [word, member] : channel_words) {
    known.emplace_back(word);
    known_text += concat(known_text.empty() ? "" : ", ", word);
  }
  for (const std::string& name : names) {
    bool found = false;
    for (const auto& [word, member] : channel_words)
      if (name == word) found = set.*member = true;
    if (!found)
      throw Error(Trouble::usage, concat("--channels: found '", name, "'; expected ", known_text),
                  did_you_mean(name, known));
  }
  return set;
}

Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field) {
  if (field.range.is_empty()) throw Error(Trouble::invalid, concat("field '", field.name, "' holds no finite value"));
  if (text == "auto" && field.name == formats::boundary_distance && field.range.hi > 0)
    return {formats::shape_share_of_distance * field.range.hi, "a ten-thousandth of the largest distance"};
  if (text == "auto") {
    const std::optional<double> threshold = formats::otsu_threshold(field);
    if (!threshold)
      throw Error(Trouble::usage, concat("field '", field.name, "' has the value ", field.range.lo,
                                         " everywhere: no isovalue parts it"));
    return {*threshold, "Otsu's threshold"};
  }
  const bool is_percentile = text.starts_with("p");
  double value = 0;
  try {
    read_value(is_percentile ? text.substr(1) : text, value);
  } catch (const Error&) {
    throw Error(Trouble::usage,
                concat("--iso: found '", text, "'; expected a number, a percentile such as p95, or auto"));
  }
  if (is_percentile) {
    require_within("--iso p", value, 0, 100);
    return {formats::percentile(field, value / 100), concat("percentile ", value)};
  }
  if (!field.range.contains(value))
    throw Error(Trouble::usage, concat("isovalue ", value, " is outside the range ", range_text(field)),
                "--iso auto takes one from the histogram");
  return {value, "given"};
}

namespace {

bool varies(const formats::FieldSummary& field) {
  return field.range.lo < field.range.hi;
}

/// The first field; where that is the same everywhere, the first one that is not.
render::Volume load_field_that_varies(const std::filesystem::path& path) {
  const render::Volume first = render::Volume::load(path);
  if (varies(first.field())) return first;
  for (const std::string& name : first.field_names()) {
    const render::Volume other = render::Volume::load(path, name);
    if (varies(other.field())) return other;
  }
  return first;
}

}  // namespace

render::Volume load_shown(const std::filesystem::path& path, const std::string& field) {
  require_input(path);
  if (preprocess::is_vdb(path)) return render::Volume::load(preprocess::open_vdb(path, field));
  if (!formats::PackedFile::looks_packed(path) && preprocess::foreign_kind(path) != preprocess::ForeignKind::unknown) {
    const std::filesystem::path packed = std::filesystem::path(path.filename()).replace_extension(".rho");
    throw Error(Trouble::invalid, concat(path.string(), ": is not a packed file"),
                concat("pack it first: ", shell_line({"rhoray", "pack", path.string(), "-o", packed.string()})));
  }
  if (field.empty()) return load_field_that_varies(path);
  try {
    return render::Volume::load(path, field);
  } catch (const Error& error) {
    if (error.trouble() != Trouble::usage) throw;
    const std::string hint = did_you_mean(field, render::Volume::load(path).field_names());
    throw Error(error.trouble(), error.what(), hint.empty() ? error.hint() : hint);
  }
}

render::Volume load_volume(const std::filesystem::path& path, const std::string& field) {
  const render::Volume volume = load_shown(path, field);
  if (volume.is_surface())
    throw Error(Trouble::invalid, concat(path.string(), ": holds a surface; expected a grid or a mesh with fields"),
                concat("look at it: rhoray render ", path.string()));
  return volume;
}

namespace {

render::Method choose_method(const PictureOptions& options, render::Mode mode, const render::Volume& volume) {
  if (!options.method.empty() && !options.accuracy.empty())
    throw Error(Trouble::usage, "--method and --accuracy say the same thing twice: give one of them");
  if (!options.method.empty()) return method_named(options.method, mode, volume.is_mesh());
  if (options.accuracy.empty()) return render::default_method(volume, mode);
  return method_of(accuracy_named(options.accuracy));
}

}  // namespace

namespace {

render::Normals choose_normals(const PictureOptions& options, const render::Volume& volume) {
  for (const auto& row : normals_words) {
    if (options.normals != row.word) continue;
    if (row.of_meshes != (volume.is_mesh() || volume.is_surface()))
      throw Error(Trouble::usage,
                  concat("--normals: '", row.word, "' is of ", row.of_meshes ? "meshes" : "grids", ", and ",
                         volume.file().name(), " is ",
                         volume.is_mesh()      ? "a mesh"
                         : volume.is_surface() ? "a surface"
                                               : "a grid"),
                  !row.of_meshes ? "flat is the exact gradient of every cell"
                                 : "exact, the gradient of the trilinear field, is how grids are lit");
    return row.normals;
  }
  return render::Normals::exact;
}

render::FieldColors choose_field_colors(const PictureOptions& options, const render::Volume& volume) {
  const std::vector<std::string> names = volume.field_names();
  if (std::find(names.begin(), names.end(), options.color_by) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += concat(known.empty() ? "" : ", ", "'", name, "'");
    throw Error(Trouble::usage, concat("--color-by: no field '", options.color_by, "'; there is ", known),
                did_you_mean(options.color_by, names));
  }
  const auto field = volume.field(options.color_by);
  if (!field)
    throw Error(Trouble::unsupported,
                concat("--color-by: '", options.color_by, "' is another grid of ", volume.file().name(),
                       ", with voxels of its own; a surface is coloured "
                       "by its own field, '",
                       volume.field().name, "'"));
  if (field->range.is_empty())
    throw Error(Trouble::invalid, concat("--color-by: field '", field->name, "' holds no finite value"));
  render::FieldColors colors{.field = field->name, .range = options.range.value_or(field->range)};
  for (const render::NamedColorMap& named : render::color_maps())
    if (options.colormap == named.name) colors.map = named.map;
  return colors;
}

/// What is said of fields where there is none.
void refuse_field_options(const PictureOptions& options, const render::Volume& volume) {
  const PictureOptions defaults;
  for (const auto& [given, option] : {std::pair{options.isovalue != defaults.isovalue, "--iso"},
                                      {options.mode != defaults.mode, "--mode"},
                                      {!options.color_by.empty(), "--color-by"},
                                      {options.range.has_value(), "--range"},
                                      {!options.method.empty(), "--method"}})
    if (given)
      throw Error(Trouble::usage,
                  concat(option, ": is of fields, and ", volume.file().name(), " holds triangles, shown as they are"));
  if (!options.accuracy.empty() && options.accuracy != "float" && options.accuracy != "double")
    throw Error(Trouble::usage, concat("--accuracy: found '", options.accuracy, "'; expected float or double of ",
                                       volume.file().name(), ", which holds triangles"));
}

/// What is said of surfaces where none is shown.
void refuse_surface_options(const PictureOptions& options) {
  for (const auto& [option, text] : {std::pair{"--normals", &options.normals}, {"--color-by", &options.color_by}})
    if (!text->empty())
      throw Error(Trouble::usage, concat(option, " is of isosurfaces; a maximum intensity projection has no surface"));
}

}  // namespace

PicturePlan plan_picture(const PictureOptions& options, const render::Volume& volume) {
  PicturePlan plan;
  render::Scene& scene = plan.scene;
  if (!options.colormap.empty() && options.color_by.empty())
    throw Error(Trouble::usage, "--colormap is of the colours by a field: --color-by names it");
  if (volume.is_surface()) refuse_field_options(options, volume);
  scene.layers[0].mode = volume.is_surface()     ? render::Mode::triangles
                         : options.mode == "mip" ? render::Mode::mip
                                                 : render::Mode::isosurface;
  scene.layers[0].method = choose_method(options, scene.layers[0].mode, volume);
  Box3 shown = volume.bounds();
  if (scene.layers[0].mode == render::Mode::isosurface) {
    const Isovalue iso = options.isovalue == "auto" && volume.is_level_set()
                             ? Isovalue{0, "the surface of the level set"}
                             : choose_isovalue(options.isovalue, volume.field());
    scene.layers[0].isovalue = iso.value;
    plan.isovalue_from = iso.from;
    const Box3 surface = volume.isosurface_bounds(iso.value);
    plan.surface_is_empty = surface.isEmpty();
    if (!plan.surface_is_empty) shown = surface;
    scene.layers[0].surface.normals = choose_normals(options, volume);
    if (!options.color_by.empty()) scene.layers[0].surface.color_by = choose_field_colors(options, volume);
  } else if (scene.layers[0].mode == render::Mode::triangles) {
    scene.layers[0].surface.normals = choose_normals(options, volume);
  } else {
    refuse_surface_options(options);
    if (volume.field().range.is_empty())
      throw Error(Trouble::invalid, concat("field '", volume.field().name, "' holds no finite value"));
    scene.layers[0].window = options.range.value_or(volume.field().range);
  }
  scene.camera = plan_camera(options, shown);
  if (options.surface_color) scene.layers[0].surface.color = options.surface_color->linear;
  if (options.specular) {
    require_within("--specular", *options.specular, 0, 1);
    scene.layers[0].surface.specular = *options.specular;
  }
  const double grey = scene.layers[0].mode == render::Mode::mip ? 0 : 1;
  scene.background = options.background ? options.background->linear : Vec3(grey, grey, grey);

  plan.frame.width = options.size.width;
  plan.frame.height = options.size.height;
  plan.frame.channels = channel_set(options.channels);
  for (const auto& [word, page] : diary_words)
    if (options.show == word) plan.page = page;
  plan.frame.use_hierarchy = !options.no_hierarchy;
  return plan;
}

std::vector<std::string> reproducing_command(const PicturePlan& plan, const render::Volume& volume,
                                             const std::filesystem::path& input, const std::filesystem::path& output) {
  const render::Scene& scene = plan.scene;
  const render::Camera& camera = scene.camera;
  std::vector<std::string> words{"rhoray", "render", input.string(), "-o", output.string()};
  const auto add = [&](const std::string& name, const std::string& value) { words.insert(words.end(), {name, value}); };
  if (!volume.is_surface()) add("--field", volume.field().name);
  if (scene.layers[0].mode == render::Mode::mip) {
    add("--mode", "mip");
    add("--range", concat(scene.layers[0].window.lo, ",", scene.layers[0].window.hi));
  } else {
    if (!volume.is_surface()) {
      add("--mode", "iso");
      add("--iso", concat(scene.layers[0].isovalue));
    }
    add("--surface-color", text_of(scene.layers[0].surface.color));
    for (const auto& row : normals_words)
      if (row.of_meshes == (volume.is_mesh() || volume.is_surface()) && row.normals == scene.layers[0].surface.normals)
        add("--normals", row.word);
    if (const auto& colors = scene.layers[0].surface.color_by) {
      add("--color-by", colors->field);
      for (const render::NamedColorMap& named : render::color_maps())
        if (named.map == colors->map) add("--colormap", std::string(named.name));
      if (colors->range.lo < colors->range.hi) add("--range", concat(colors->range.lo, ",", colors->range.hi));
    }
    add("--specular", concat(scene.layers[0].surface.specular));
  }
  const MethodOption method = option_of(scene.layers[0].method, scene.layers[0].mode, volume.is_mesh());
  add(method.option, method.word);
  add("--size", concat(plan.frame.width, "x", plan.frame.height));
  add("--camera-position", text_of(camera.position));
  add("--camera-target", text_of(camera.target));
  add("--camera-up", text_of(camera.up));
  if (camera.orthographic)
    add("--ortho-height", concat(camera.orthographic_height));
  else
    add("--fov", concat(camera.vertical_fov_deg));
  add("--background", text_of(scene.background));

  std::string channels;
  for (const auto& [word, member] : channel_words)
    if (plan.frame.channels.*member) channels += concat(channels.empty() ? "" : ",", word);
  if (!channels.empty()) add("--channels", channels);
  if (plan.page)
    for (const auto& [word, page] : diary_words)
      if (page == *plan.page) add("--show", word);
  if (!plan.frame.use_hierarchy) words.push_back("--no-hierarchy");
  return words;
}

}  // namespace rhoray::tools
