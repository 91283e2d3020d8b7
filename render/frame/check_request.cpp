#include "render/frame/check_request.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/frame/antialiasing.h"

namespace rhoray::render {

namespace {

/// Calls check(element) of each; a refusal says which one it is.
template <class List, class Check>
void check_each(const char* name, const List& list, const Check& check) {
  for (std::size_t i = 0; i < list.size(); ++i) try {
      check(list[i]);
    } catch (const Error& error) {
      throw Error(error.code(), concat(name, ' ', i, ": ", error.what()), error.hint());
    }
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string text_of(const Vec3& v) {
  return concat("(", v.x, ", ", v.y, ", ", v.z, ")");
}

void check_slice(const Layer& layer) {
  const HalfSpace& plane = layer.plane;
  if (!is_finite(plane.point) || !is_finite(plane.normal) || plane.normal == Vec3(0, 0, 0))
    throw Error(ErrorCode::usage, concat("a slice through ", text_of(plane.point), " with the normal ",
                                         text_of(plane.normal), "; expected finite numbers and a direction"));
  if (!layer.material.color_by) throw Error(ErrorCode::usage, "a slice without colours; expected those of its field");
  if (layer.threshold.is_empty())
    throw Error(ErrorCode::usage, concat("a slice of values from ", layer.threshold.lo, " to ", layer.threshold.hi,
                                         "; expected a range that is not empty"));
}

/// Refuses a range that colours cannot be spread over.
/// @param of  "colours of 'pressure'"
void check_colors(const std::string& of, const ColorScale& scale, const Interval<double>& range) {
  if (range.is_empty() || !std::isfinite(range.hi - range.lo))
    throw Error(ErrorCode::usage, concat(of, " from ", range.lo, " to ", range.hi, "; expected a finite range"));
  if (scale.is_logarithmic && !(range.lo > 0))
    throw Error(ErrorCode::usage,
                concat(of, " from ", range.lo, " to ", range.hi, " by logarithm; expected a range above 0"));
  if (scale.levels != 0 && !(scale.levels >= 2 && scale.levels <= 65536))
    throw Error(ErrorCode::usage, concat(of, " in ", scale.levels, " levels; expected 2 to 65536, or 0 for none"));
}

void check_layer(std::span<const Dataset> datasets, const Layer& layer) {
  if (layer.dataset >= datasets.size())
    throw Error(ErrorCode::usage, concat("a layer of dataset ", layer.dataset, " of ", datasets.size()));
  const Dataset& dataset = datasets[layer.dataset];
  if (dataset.is_surface() != (layer.mode == Mode::triangles))
    throw Error(ErrorCode::usage,
                dataset.is_surface() ? concat(dataset.file().name(), ": holds triangles; expected a layer of triangles")
                                     : concat(dataset.file().name(), ": holds no triangles"));
  if (layer.mode == Mode::triangles && layer.method.algorithm != Method::Algorithm::direct)
    throw Error(ErrorCode::usage, concat(dataset.file().name(), ": triangles are traced only at float and double"));
  if (layer.mode == Mode::triangles && layer.material.color_by && !dataset.has_fields())
    throw Error(ErrorCode::usage, concat(dataset.file().name(), ": a surface has no fields to be coloured by"));
  if (layer.mode == Mode::isosurface && !std::isfinite(layer.isovalue))
    throw Error(ErrorCode::usage, concat("isovalue ", layer.isovalue, "; expected a finite number"));
  if (layer.mode == Mode::mip) check_colors("a window", layer.scale, layer.window);
  if (!(layer.material.opacity >= 0 && layer.material.opacity <= 1))
    throw Error(ErrorCode::usage, concat("an opacity of ", layer.material.opacity, "; expected 0 to 1"));
  if (const auto& colors = layer.material.color_by)
    check_colors(concat("colours of '", colors->field, "'"), colors->scale, colors->range);
  if (layer.mode == Mode::slice) check_slice(layer);
  if (layer.material.texture && layer.material.color_by)
    throw Error(ErrorCode::usage, concat("a texture, ", layer.material.texture->file().name(), ", and colours by '",
                                         layer.material.color_by->field, "'; expected one of the two"));
  const Method& method = layer.method;
  if (method.algorithm == Method::Algorithm::sampled && !(method.step >= 1e-4 && method.step <= 1e4))
    throw Error(ErrorCode::usage, concat("steps of ", method.step, " cells; expected 0.0001 to 10000"));
  if (method.algorithm == Method::Algorithm::slack && !(method.slack >= 0 && method.slack <= 1))
    throw Error(ErrorCode::usage, concat("a slack of ", method.slack, "; expected 0 to 1"));
}

void check_light(const Light& light) {
  const Vec3& color = light.color;
  if (!is_finite(color) || color.x < 0 || color.y < 0 || color.z < 0)
    throw Error(ErrorCode::usage, concat("a light of colour ", text_of(color), "; expected finite numbers from 0 up"));
  if (light.kind == Light::Kind::point && !is_finite(light.place))
    throw Error(ErrorCode::usage, concat("a light at ", text_of(light.place), "; expected finite numbers"));
  if (light.kind == Light::Kind::directional && (!is_finite(light.place) || light.place == Vec3(0, 0, 0)))
    throw Error(ErrorCode::usage,
                concat("a light from the direction ", text_of(light.place), "; expected a finite one"));
  const double largest = light.kind == Light::Kind::directional ? 180 : std::numeric_limits<double>::max();
  if (!(light.size >= 0 && light.size <= largest) || light.samples < 1 || light.samples > 4096)
    throw Error(ErrorCode::usage,
                concat("a light of size ", light.size, " by ", light.samples,
                       " samples; expected finite sizes from 0 up, at most 180 degrees, and 1 to 4096 "
                       "samples"));
}

void check_clip(const Clip& clip) {
  if (clip.box)
    for (int axis = 0; axis < 3; ++axis)
      if (!(clip.box->min[axis] < clip.box->max[axis]))
        throw Error(ErrorCode::usage, concat("a clip box from ", text_of(clip.box->min), " to ", text_of(clip.box->max),
                                             "; expected one that is not empty"));
  if (clip.planes.size() > Clip::most_planes)
    throw Error(ErrorCode::usage, concat(clip.planes.size(), " clip planes; expected at most ", Clip::most_planes));
  check_each("clip plane", clip.planes, [](const HalfSpace& plane) {
    if (!is_finite(plane.point) || !is_finite(plane.normal) || plane.normal == Vec3(0, 0, 0))
      throw Error(ErrorCode::usage, concat("through ", text_of(plane.point), " with the normal ", text_of(plane.normal),
                                           "; expected finite numbers and a direction"));
  });
}

void check_effects(const Scene& scene) {
  check_each("light", scene.lights, check_light);
  const Occlusion& occlusion = scene.occlusion;
  if (occlusion.samples < 0 || occlusion.samples > 4096 || !(occlusion.radius >= 0))
    throw Error(ErrorCode::usage, concat("occlusion by ", occlusion.samples, " samples up to ", occlusion.radius,
                                         " away; expected 0 to 4096 samples, and a distance from 0 up"));
  if (scene.fog && (scene.fog->range.is_empty() || !std::isfinite(scene.fog->range.hi - scene.fog->range.lo)))
    throw Error(ErrorCode::usage,
                concat("fog from ", scene.fog->range.lo, " to ", scene.fog->range.hi, "; expected a finite range"));
}

void check_window(const PixelRect& window, const FrameOptions& options) {
  if (window.x < 0 || window.y < 0 || window.width < 1 || window.height < 1 ||
      window.width > options.width - window.x || window.height > options.height - window.y)
    throw Error(ErrorCode::usage,
                concat("a window of ", window.width, " x ", window.height, " pixels at (", window.x, ", ", window.y,
                       "); expected pixels of a picture of ", options.width, " x ", options.height));
}

}  // namespace

bool all_prove(const Scene& scene) {
  return std::all_of(scene.layers.begin(), scene.layers.end(), [](const Layer& layer) { return proves(layer.method); });
}

void check_request(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options) {
  if (options.width < 1 || options.height < 1)
    throw Error(ErrorCode::usage,
                concat("picture of ", options.width, " x ", options.height, " pixels; expected at least 1 x 1"));
  if (options.window) check_window(*options.window, options);
  if (scene.layers.empty() || scene.layers.size() >= LayerOfRays::none)
    throw Error(ErrorCode::usage,
                concat("a scene of ", scene.layers.size(), " layers; expected 1 to ", LayerOfRays::none - 1));
  if (options.antialiasing < 1 || options.antialiasing > most_samples)
    throw Error(ErrorCode::usage, concat(options.antialiasing, " samples of a pixel; expected 1 to ", most_samples));
  check_each("layer", scene.layers, [&](const Layer& layer) { check_layer(datasets, layer); });
  check_effects(scene);
  if (scene.clip) check_clip(*scene.clip);
  if (options.channels.error && !all_prove(scene))
    throw Error(ErrorCode::usage, "the channel 'error' needs a method that proves one: certified or exact");
}

void check_refinement(const Refinement& refinement) {
  if (refinement.first_spacing < 1 || refinement.first_spacing > 16 ||
      !std::has_single_bit(static_cast<unsigned>(refinement.first_spacing)))
    throw Error(ErrorCode::usage,
                concat("a first pass of every ", refinement.first_spacing, "th pixel; expected 1, 2, 4, 8 or 16"));
}

}  // namespace rhoray::render
