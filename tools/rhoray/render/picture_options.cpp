#include "tools/rhoray/render/picture_options.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "formats/base/word_list.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "render/scene_words.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tools {

namespace {

/// A row that also notes that it was given.
Option of_the_layer(PictureOptions& options, Option row) {
  row.take = [take = row.take, name = row.names, &given = options.of_the_layer](const std::string& text) {
    take(text);
    given.push_back(name);
  };
  return row;
}

Option angles_option(std::string names, std::string help, std::optional<Angles>& out) {
  return {Option::Kind::value, std::move(names), "AZ,EL", std::move(help), [&out](const std::string& text) {
            const std::string expected =
                concat("two angles azimuth,elevation in degrees, elevation from ", render::limits::elevation_deg.lo,
                       " to ", render::limits::elevation_deg.hi);
            const std::size_t comma = text.find(',');
            if (comma == std::string::npos) refuse_value(text, expected);
            Angles angles;
            read_value(text.substr(0, comma), angles.azimuth_deg);
            read_value(text.substr(comma + 1), angles.elevation_deg);
            if (!render::limits::elevation_deg.contains(angles.elevation_deg)) refuse_value(text, expected);
            out = angles;
          }};
}

/// Six numbers as two vectors, which must go together as `are_taken` says.
std::pair<Vec3, Vec3> two_vectors(const std::string& text, const std::string& expected,
                                  bool (*are_taken)(const Vec3&, const Vec3&)) {
  std::array<double, 6> numbers{};
  const std::vector<std::string> parts = split(text, ',');
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = parts.size() == numbers.size() ? finite_number(parts[i]) : std::nullopt;
    if (!number) refuse_value(text, expected);
    numbers[i] = *number;
  }
  const Vec3 first(numbers[0], numbers[1], numbers[2]), second(numbers[3], numbers[4], numbers[5]);
  if (!are_taken(first, second)) refuse_value(text, expected);
  return {first, second};
}

Box3 read_box(const std::string& text) {
  const auto [low, high] =
      two_vectors(text, "six finite numbers x0,y0,z0,x1,y1,z1 with x0 < x1, y0 < y1 and z0 < z1",
                  [](const Vec3& a, const Vec3& b) { return a.x < b.x && a.y < b.y && a.z < b.z; });
  return {low, high};
}

render::HalfSpace read_half_space(const std::string& text) {
  const auto [point, normal] =
      two_vectors(text, "six finite numbers px,py,pz,nx,ny,nz: a point, and a normal that is not 0",
                  [](const Vec3&, const Vec3& n) { return n != Vec3(0, 0, 0); });
  return {.point = point, .normal = normal};
}

/// z, z=40, or px,py,pz,nx,ny,nz.
render::LayerSpec read_slice(const std::string& text) {
  render::LayerSpec spec{.type = render::LayerType::slice};
  const std::size_t equals = text.find('=');
  try {
    if (const std::string axis = text.substr(0, equals); axis == "x" || axis == "y" || axis == "z") {
      spec.axis = axis;
      if (equals != std::string::npos) read_value(text.substr(equals + 1), spec.position);
      return spec;
    }
    const render::HalfSpace plane = read_half_space(text);
    spec.point = plane.point, spec.normal = plane.normal;
    return spec;
  } catch (const Error&) {
    refuse_value(
        text,
        "an axis and a position such as z=40, an axis alone for the middle of the data, or a point and a normal "
        "px,py,pz,nx,ny,nz");
  }
}

/// The rows of the options that set the clip region.
std::vector<Option> clip_options(std::optional<render::ClipSpec>& spec) {
  const auto said = [&spec]() -> render::ClipSpec& { return spec ? *spec : spec.emplace(); };
  return {with_details({Option::Kind::value, "--clip-box", "X0,Y0,Z0,X1,Y1,Z1",
                        "Show only the inside of this box, in world units",
                        [said](const std::string& text) { said().box = read_box(text); }},
                       "Surfaces are cut open, not capped"),
          with_details({Option::Kind::value, "--clip-plane", "PX,PY,PZ,NX,NY,NZ...",
                        "Show only the normal's side of a plane. 0,0,40,0,0,1 shows what lies above z = 40",
                        [said](const std::string& text) {
                          if (said().planes.size() == render::Clip::most_planes)
                            throw Error(ErrorCode::usage,
                                        concat("too many planes; expected at most ", render::Clip::most_planes));
                          said().planes.push_back(read_half_space(text));
                        }},
                       concat("May be given up to ", render::Clip::most_planes, " times")),
          {Option::Kind::flag, "--cut-away", "", "Hide the inside of the clip region, and show the rest",
           [said](const std::string&) { said().keep = render::keep_outside; }}};
}

/// The row of the option that adds slices.
Option slice_option(std::vector<render::LayerSpec>& slices) {
  return with_details(
      {Option::Kind::value, "--slice", "AXIS[=POSITION]...",
       "Show the field on a plane, such as z=40. Without --mode and --iso, only slices are shown",
       [&slices](const std::string& text) { slices.push_back(read_slice(text)); }},
      "z=40 is perpendicular to z at 40 world units, z lies in the middle of the data, px,py,pz,nx,ny,nz is a point "
      "and a normal. May be given several times. --colormap and --range set the colours");
}

/// Replaces what is given anew.
template <class Spec, class... Members>
void replace(Spec& old, const Spec& said, Members Spec::*... members) {
  const auto replace_one = [&](auto member) {
    if (said.*member) old.*member = said.*member;
  };
  (replace_one(members), ...);
}

/// Beside the file that is shown; both have names then, by which the layer asks for them.
void add_texture(const std::filesystem::path& file, render::SceneSpec& scene) {
  scene.data[0].name = scene.layers[0].data = "data";
  scene.data.push_back({.name = "texture", .file = file});
  scene.layers[0].texture = "texture";
}

/// The lights that options ask for; nothing where they ask for none. The style's first light is its
/// key light; a style without one gets the default's lights.
std::optional<std::vector<render::LightSpec>> lights_of(const PictureOptions& options, const std::string& style) {
  if (!options.shadows && !options.key_light && !options.key_light_size) return std::nullopt;
  std::vector<render::LightSpec> lights = render::lights_of_style(style);
  if (lights[0].type != render::Light::Kind::directional) lights = render::lights_of_style({});
  render::LightSpec& key = lights[0];
  if (options.shadows || options.key_light_size) key.shadows = true;
  if (options.key_light_size) {
    key.angular_diameter_deg = options.key_light_size;
    key.samples = render::Light{}.samples;
  }
  if (options.key_light) {
    key.azimuth_deg = options.key_light->azimuth_deg, key.elevation_deg = options.key_light->elevation_deg;
    key.from.clear();
  }
  return lights;
}

/// A view by a word or angles replaces a place that was given; an angle of view, an orthographic
/// one.
render::CameraSpec camera_under(render::CameraSpec camera, const render::CameraSpec& said) {
  if (said.view) camera.azimuth_deg = camera.elevation_deg = std::nullopt;
  if (said.view || said.azimuth_deg || said.elevation_deg || said.up_axis)
    camera.position = camera.target = camera.up = std::nullopt;
  if (said.fov_deg) camera.orthographic = std::nullopt, camera.orthographic_height = std::nullopt;
  using Camera = render::CameraSpec;
  replace(camera, said, &Camera::view, &Camera::azimuth_deg, &Camera::elevation_deg, &Camera::zoom, &Camera::fov_deg,
          &Camera::orthographic, &Camera::orthographic_height, &Camera::position, &Camera::target, &Camera::up,
          &Camera::up_axis);
  return camera;
}

}  // namespace

std::vector<Option> picture_options(PictureOptions& options) {
  render::SceneSpec& scene = options.scene_spec;
  render::LayerSpec& layer = scene.layers[0];
  render::CameraSpec& camera = scene.camera;
  render::PictureSpec& image = scene.image;
  const auto layers = [&](Option row) { return of_the_layer(options, std::move(row)); };
  return all_options(
      {in_group("Input",
                {layers(value_option("--field", "NAME", "Field to show; default the first that is not constant",
                                     scene.data[0].field)),
                 with_details(choice_option("--space", render::space_words(),
                                            "Space of world coordinates, for files that say which is theirs; default "
                                            "ras",
                                            scene.space),
                              "ras: x to the patient's right, y to the front, z to the head. lps: x to the left, y to "
                              "the back, z to the head"),
                 layers(value_option("--landmark", "FILE[,FILE...]", "Triangle meshes to show too, such as landmarks",
                                     options.landmarks))}),
       in_group(
           "Surface",
           {with_details(
                layers(choice_option("--mode", {"iso", "mip", "boundary"},
                                     "Isosurface, maximum intensity projection (MIP) or the boundary of a mesh; "
                                     "default boundary for meshes, else iso",
                                     options.mode)),
                "Without --mode, --iso shows an isosurface of a mesh, and the boundary around it. A boundary is "
                "coloured by the field unless --surface-color is given; without --mode it also gets a colour bar and "
                "a box. Surfaces of triangles are shown as they are"),
            layers(number_option("--context", "O",
                                 "Opacity of a mesh's boundary around its isosurface; default 0.12, or 0 with --mode "
                                 "iso",
                                 render::limits::share, layer.context)),
            with_details(
                layers(value_option("--iso", "V[,V...]",
                                    concat("Isovalues: numbers, percentiles (p95) or auto (",
                                           render::auto_isovalue_words, "); default auto"),
                                    layer.isovalues)),
                "Several values give several surfaces: coloured by viridis over their values (by coolwarm if those "
                "below and above 0 enclose different regions), the innermost opaque, outer ones transparent. For "
                "the field boundary_distance, auto is 1/10000 of its maximum"),
            layers(slice_option(options.slices)),
            layers(number_option("--opacity", "O",
                                 "Opacity, 0 to 1; default 1 (several isovalues: less for outer ones)",
                                 render::limits::share, layer.opacity)),
            with_details(layers(choice_option(
                             "--normals", render::normals_words(),
                             "Surface normals: smooth, exact (grids) or flat; default flat for meshes, else smooth",
                             layer.normals)),
                         "smooth: interpolated between central differences of a grid, or averages at the points; "
                         "triangles keep edges of 30 degrees and more. exact: gradient of the trilinear field. flat: "
                         "exact gradient of each cell, or normal of each triangle"),
            with_details(layers(number_option("--feature-edges", "DEGREES",
                                              "Lines where triangles turn by more than this angle; 180: none",
                                              render::limits::feature_edges, layer.feature_edges)),
                         "For boundaries of meshes and surfaces of triangles. The default is 30 for a mesh's opaque "
                         "boundary of one colour, unless the lines would nearly cover it")}),
       in_group(
           "Colour",
           {with_details(layers(value_option("--surface-color", "COLOR",
                                             "Surface colour: #rrggbb (sRGB) or r,g,b (linear)", layer.color)),
                         "Linear r, g and b lie between 0 and 1. By default, several surfaces have different colours"),
            layers(
                value_option("--color-by", "NAME", "Colour the surface by a field of the same file", layer.color_by)),
            with_details(layers(choice_option("--colormap", render::colormap_words(),
                                              "Colour map of --color-by, --slice and MIP; NAME_r is its reverse",
                                              layer.colormap)),
                         "Default gray for MIP; else viridis, or coolwarm with 0 in its middle for floating-point "
                         "fields of both signs"),
            with_details(
                layers(value_option("--range", "A,B",
                                    "Values of the first and the last colour; default the field's range", layer.range)),
                "In MIP the default is from the 1st to the 99.9th percentile"),
            with_details(
                layers(choice_option("--color-scale", render::scale_words(),
                                     "log: colours follow the logarithm of the value; the range lies above 0; default "
                                     "linear",
                                     layer.scale)),
                "For --color-by, --slice and MIP. Values at 0 or below get the first colour. If the field reaches 0 or "
                "below, the default range starts at 1/10000 of its largest value; of whole numbers at 1 or above"),
            with_details(
                layers(number_option("--levels", "N", "Number of colours, 2 to 256; default continuous colours",
                                     render::limits::levels, layer.levels)),
                "For --color-by, --slice and MIP. The map is divided into equal bands; with --color-scale log "
                "each covers the same ratio of values"),
            with_details(layers(value_option("--texture", "FILE", "Colour the surface by the colours of a file",
                                             options.texture)),
                         "Any file that `rhoray pack --color` takes. The texture is placed in world axes"),
            with_details(
                value_option(
                    "--background", "COLOR",
                    "Background colour, written as for --surface-color, or none: a picture with alpha; default "
                    "the style's (MIP: black)",
                    image.background),
                "With none, PNG and TIFF store colours that are not multiplied by alpha, to be composited in linear "
                "light; JPEG has no alpha")}),
       in_group(
           "Light",
           {with_details(choice_option("--style", render::style_words(),
                                       "Lights, background, samples, highlight and normals, unless other options set "
                                       "them; default default",
                                       scene.style),
                         render::style_help()),
            with_details(flag_option("--shadows", "Cast shadows from the key light", options.shadows),
                         "The key light shines from 30 degrees left of the camera and 40 above it, or from --light. A "
                         "fill light from the other side, a third as strong, casts none"),
            with_details(angles_option("--light", "Direction of the key light: azimuth and elevation in degrees",
                                       options.key_light),
                         "The angles are those of a camera. The key light casts shadows only with --shadows, "
                         "--light-size or a style that has them"),
            with_details(
                number_option("--light-size", "DEG", "Angular diameter of the key light, for soft shadows; default 0",
                              render::limits::angular_diameter_deg, options.key_light_size),
                "The key light then casts shadows, with 16 rays per hit"),
            with_details(constant_option("--ao", "Ambient occlusion: less ambient light near opaque surfaces",
                                         render::OcclusionSpec{}, scene.effects.occlusion),
                         "Surfaces occlude up to a tenth of the diagonal of the shown data, with 16 rays per hit"),
            {Option::Kind::value, "--fog", "A,B",
             "Fade surfaces into the background between the distances A and B from the camera",
             [&effects = scene.effects](const std::string& text) { read_value(text, effects.fog.emplace().range); }},
            layers(number_option("--ambient", "A", "Ambient light, 0 to 1; default 0.12", render::limits::share,
                                 layer.ambient)),
            layers(number_option("--specular", "S", "Specular strength, 0 to 1; default 0.15", render::limits::share,
                                 layer.specular)),
            layers(number_option("--shininess", "N", "Specular exponent; default 40", render::limits::shininess,
                                 layer.shininess))}),
       in_group(
           "Camera",
           {choice_option("--view", render::view_words(),
                          "Side from which the camera looks; iso: three-quarter view; default iso", camera.view),
            with_details(choice_option("--up", render::up_axis_words(), "Axis of the data that is up; default z",
                                       camera.up_axis),
                         "For surfaces packed from .obj or .ply the default is y. With z, front looks along +y; "
                         "with y, along -z"),
            value_option("--azimuth", "DEG", "Camera azimuth around the axis that is up; 0 looks from the front",
                         camera.azimuth_deg),
            number_option("--elevation", "DEG", "Camera elevation; 90 looks straight down",
                          render::limits::elevation_deg, camera.elevation_deg),
            number_option("--zoom", "FACTOR", "Zoom factor; at 1 the data fill 90 % of the width or height; default 1",
                          render::limits::zoom, camera.zoom),
            number_option("--fov", "DEG", "Vertical field of view in degrees; default 30", render::limits::fov_deg,
                          camera.fov_deg),
            constant_option("--ortho", "Use an orthographic projection", true, camera.orthographic),
            for_experts(value_option_if<double>(
                "--ortho-height", "H", "Height of the image in world units; implies --ortho", "a number above 0",
                [](double height) { return height > 0; }, camera.orthographic_height)),
            for_experts(value_option("--camera-position", "X,Y,Z",
                                     "Camera position in world units; default fitted to the data", camera.position)),
            for_experts(value_option("--camera-target", "X,Y,Z", "Point at which the camera looks, in world units",
                                     camera.target)),
            for_experts(value_option("--camera-up", "X,Y,Z", "Up direction of the image", camera.up))}),
       in_group("Clipping", clip_options(scene.clip)),
       in_group(
           "Annotation",
           {with_details(constant_option("--axes", "Draw arrows along the world axes", render::AxesSpec{},
                                         scene.annotations.axes),
                         "In a patient's body they carry the letters of their directions, as the edges of --box do"),
            constant_option("--box", "Draw a box around the data, with ticks in world units", true,
                            scene.annotations.box),
            with_details(
                constant_option("--colorbar", "Draw a colour bar", render::ColorBarSpec{}, scene.annotations.color_bar),
                "For --color-by, a slice, a MIP or a heat map"),
            with_details(
                choice_option("--legend", {"on", "off"},
                              "List colours and values of isosurfaces; default on if several isovalues have "
                              "no --surface-color",
                              [&legend = scene.annotations.legend](const std::string& text) { legend = text == "on"; }),
                "Isosurfaces coloured by a field or a texture are left out"),
            value_option("--caption", "TEXT", "Write a caption below the picture", scene.annotations.caption)}),
       in_group(
           "Accuracy",
           {with_details(
                choice_option("--accuracy", render::accuracy_words(),
                              "Accuracy of hits, from fast to exact; default float for most isosurfaces, else double",
                              scene.accuracy),
                "preview: approximate. float: single precision inside cells. double: double precision. "
                "certified: every hit and miss is proven, with an error bound. exact: exact arithmetic for "
                "every decision. certified and exact first check the file's value ranges; exit code 4 if "
                "these are wrong. The default is float for isosurfaces of meshes and of uniform grids, dense "
                "or in bricks; else double"),
            for_experts(
                with_details(layers(value_option("--method", "NAME", "Use one method, for comparison", layer.method)),
                             render::method_forms())),
            for_experts(with_details(
                choice_option("--show", render::show_words(),
                              "Draw a heat map: error, roots in the hit cell, iterations of the root search, or cost "
                              "(cells visited); default color",
                              image.show),
                "error needs --accuracy certified or exact")),
            for_experts(with_details(
                constant_option("--no-hierarchy", "Visit every leaf cell, for comparison", false, image.hierarchy),
                "At --accuracy double the picture is the same"))})});
}

std::vector<Option> image_options(PictureOptions& options) {
  render::PictureSpec& image = options.scene_spec.image;
  return {
      value_option("--size", "WxH",
                   "Image size in pixels, or 720p, 1080p, 4k; default about 960x720, as wide as what is shown",
                   image.size),
      with_details(number_option("--antialias", "N", "Maximum samples per pixel, 1 to 64; default 8 (MIP: 1)",
                                 render::limits::pixel_samples, image.antialias),
                   "Only pixels at edges get more than one"),
      with_details(
          value_option("--channels", "A,B", "Extra EXR channels, such as depth, normal, value", image.channels),
          concat("All: ", joined(render::channel_words()), ". error needs --accuracy certified or exact")),
      with_details(number_option("--frames", "N", "Number of pictures of a scene's camera path; needs -o out_%04d.png",
                                 render::limits::frames, image.frames),
                   "They go from the first key frame to the last")};
}

namespace {

/// Refuses options of surfaces if no surface is shown.
void refuse_words_of_surfaces(const PictureOptions& options) {
  constexpr std::array of_surfaces{"--iso",       "--context",       "--normals", "--color-by",
                                   "--texture",   "--surface-color", "--ambient", "--specular",
                                   "--shininess", "--feature-edges", "--opacity"};
  for (const std::string& name : options.of_the_layer)
    if (std::find(of_surfaces.begin(), of_surfaces.end(), name) != of_surfaces.end())
      throw Error(ErrorCode::usage, concat(name, ": needs an isosurface; a maximum intensity projection has none"),
                  "leave it out, or add --mode iso");
}

/// The slices, then the layer of the options; slices alone if no option asks for that layer.
void add_slices(const PictureOptions& options, render::SceneSpec& scene_spec) {
  if (options.slices.empty()) return;
  render::LayerSpec& layer = scene_spec.layers[0];
  std::vector<render::LayerSpec> slices = options.slices;
  const bool has_range = layer.color_by.empty() && layer.type != render::LayerType::mip;
  for (render::LayerSpec& slice : slices) {
    slice.colormap = layer.colormap, slice.scale = layer.scale, slice.levels = layer.levels;
    if (has_range) slice.range = layer.range;
  }
  if (layer.color_by.empty()) layer.colormap.clear(), layer.scale.clear(), layer.levels.reset();
  if (has_range) layer.range.reset();
  std::vector<std::string> given = options.of_the_layer;
  if (!scene_spec.accuracy.empty()) given.push_back("--accuracy");
  const auto is_given = [&](const char* name) { return std::find(given.begin(), given.end(), name) != given.end(); };
  if (is_given("--mode") || is_given("--iso")) {
    scene_spec.layers.insert(scene_spec.layers.begin(), slices.begin(), slices.end());
    return;
  }
  constexpr std::array of_slices{"--slice",  "--field", "--colormap", "--color-scale",
                                 "--levels", "--range", "--opacity"};
  for (const std::string& name : given)
    if (std::find(of_slices.begin(), of_slices.end(), name) == of_slices.end())
      throw Error(ErrorCode::usage, concat(name, " has no effect on slices"),
                  "add --mode iso or --iso to show an isosurface too");
  for (render::LayerSpec& slice : slices) slice.opacity = layer.opacity;
  scene_spec.layers = std::move(slices);
}

render::LayerType type_of(const std::string& mode) {
  if (mode == "mip") return render::LayerType::mip;
  if (mode == "boundary") return render::LayerType::boundary;
  return mode == "iso" ? render::LayerType::isosurface : render::LayerType::automatic;
}

/// A layer of its own for each further file.
/// @param first  of them; the files before have layers
void add_layers(const std::vector<std::filesystem::path>& files, std::size_t first, const std::string& kind,
                render::LayerType type, render::SceneSpec& scene_spec) {
  if (first >= files.size()) return;
  scene_spec.data[0].name = "data";
  for (render::LayerSpec& layer : scene_spec.layers)
    if (layer.data.empty()) layer.data = "data";
  for (std::size_t i = first; i < files.size(); ++i) {
    const std::string name = concat(kind, " ", i + 1);
    scene_spec.data.push_back({.name = name, .file = files[i]});
    scene_spec.layers.push_back({.type = type, .data = name});
  }
}

}  // namespace

render::SceneSpec spec_of(const PictureOptions& options, const std::vector<std::filesystem::path>& files) {
  render::SceneSpec scene_spec = options.scene_spec;
  scene_spec.data[0].file = files.front();
  if (!options.texture.empty()) add_texture(options.texture, scene_spec);
  scene_spec.lights = lights_of(options, scene_spec.style);
  scene_spec.layers[0].type = type_of(options.mode);
  if (!scene_spec.layers[0].method.empty() && !scene_spec.accuracy.empty())
    throw Error(ErrorCode::usage, "--method and --accuracy are mutually exclusive");
  if (scene_spec.layers[0].type == render::LayerType::mip) refuse_words_of_surfaces(options);
  add_slices(options, scene_spec);
  add_layers(files, 1, "file", render::LayerType::automatic, scene_spec);
  add_layers({options.landmarks.begin(), options.landmarks.end()}, 0, "mesh", render::LayerType::triangles, scene_spec);
  return scene_spec;
}

render::SceneSpec with_options(render::SceneSpec document, const PictureOptions& options) {
  const std::vector<std::string> read = preprocess::option_words(pack_options(options.scene_spec.data[0].read));
  if (!read.empty())
    throw Error(ErrorCode::usage,
                concat(read.front(), ": not allowed with the scene ", document.document,
                       "; its data define how files are read"),
                concat("set \"", read.front().substr(2), "\" in the document's data"));
  if (!options.of_the_layer.empty())
    throw Error(ErrorCode::usage,
                concat(options.of_the_layer.front(), ": not allowed with the scene ", document.document,
                       "; its layers define what is shown"),
                "set it in a layer of the document");
  const render::SceneSpec& said = options.scene_spec;
  document.camera = camera_under(document.camera, said.camera);
  if (!said.style.empty()) document.style = said.style;
  if (const auto lights = lights_of(options, document.style)) document.lights = lights;
  using Image = render::PictureSpec;
  using Annotations = render::AnnotationsSpec;
  replace(document.effects, said.effects, &render::EffectsSpec::occlusion, &render::EffectsSpec::fog);
  replace(document, said, &render::SceneSpec::clip);
  replace(document.image, said.image, &Image::size, &Image::background, &Image::channels, &Image::show,
          &Image::hierarchy, &Image::antialias, &Image::frames);
  replace(document.annotations, said.annotations, &Annotations::axes, &Annotations::box, &Annotations::color_bar,
          &Annotations::legend);
  if (!said.space.empty()) document.space = said.space;
  if (!said.annotations.caption.empty()) document.annotations.caption = said.annotations.caption;
  if (!said.accuracy.empty()) {
    document.accuracy = said.accuracy;
    for (render::LayerSpec& layer : document.layers) layer.accuracy.clear(), layer.method.clear();
  }
  return document;
}

}  // namespace rhoray::tools
