#include "tools/analysis/pick.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "render/probe.h"
#include "render/truth.h"

namespace rhoray::tools {

namespace {

bool is_projection(const render::Layer& layer) {
  return layer.mode == render::Mode::mip;
}

/// The bound of a picked position. The channels are floats: half a step of the depth is added.
double depth_error(double bound, double depth, const Vec3& eye, const Vec3& position) {
  return render::position_error(bound + 0x1p-24 * depth, depth, eye, position);
}

std::string pixel_text(const Json& pick) {
  return concat("pixel ", pick["pixel"][0].get<int>(), ",", pick["pixel"][1].get<int>());
}

/// A number of a pick with its unit.
std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : concat(number, " ", unit);
}

std::string position_text(const Json& pick) {
  // Where no error is proven, coordinates are told to within 1/1,000 of the distance from the eye.
  const double error = pick.value("error", 16e-3 * pick["depth"].get<double>());
  std::string text;
  for (const Json& number : pick["position"]) {
    const auto coordinate = number.get<double>();
    text += concat(text.empty() ? "" : " ", rounded(coordinate, digits_for(coordinate, error)));
  }
  return text;
}

}  // namespace

void read_value(const std::string& text, std::vector<PixelPlace>& out) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto refuse = [&] {
    throw Error(ErrorCode::usage, concat("found '", text, "'; expected a pixel X,Y, or several, X,Y:X,Y"));
  };
  const auto number = [&] {
    int value = 0;
    const auto [stop, error_code] = std::from_chars(at, end, value);
    if (error_code != std::errc() || value < 0) refuse();
    at = stop;
    return value;
  };
  for (;;) {
    const int x = number();
    if (at == end || *at++ != ',') refuse();
    out.push_back({x, number()});
    if (at == end) return;
    if (*at++ != ':') refuse();
  }
}

render::ChannelSet channels_of_picks(const render::Scene& scene) {
  render::ChannelSet channels{.depth = true, .cell = true, .value = true};
  const std::vector<render::Layer>& layers = scene.layers;
  const auto all = [&](const auto& holds) { return std::all_of(layers.begin(), layers.end(), holds); };
  // In a scene with a projection, a bound may belong to a depth or to a value.
  const bool bounds_one_quantity = all(is_projection) || std::none_of(layers.begin(), layers.end(), is_projection);
  channels.error = bounds_one_quantity && all([](const render::Layer& layer) { return render::proves(layer.method); });
  return channels;
}

/// The unit of what all layers show; empty where they differ.
std::string common_unit(const render::ResolvedScene& plan) {
  const auto unit_of = [&](const render::Layer& layer) {
    const render::Dataset& dataset = plan.datasets[layer.dataset];
    const auto& colors = layer.material.color_by;
    return layer.mode == render::Mode::triangles && colors ? dataset.field(colors->field).value().unit
                                                           : dataset.field().unit;
  };
  const std::vector<render::Layer>& layers = plan.scene.layers;
  const std::string unit = unit_of(layers.front());
  return std::all_of(layers.begin(), layers.end(), [&](const auto& layer) { return unit_of(layer) == unit; }) ? unit
                                                                                                              : "";
}

Json picked(const render::ResolvedScene& plan, const render::Framebuffer& framebuffer, const PixelPlace& pixel) {
  if (pixel.x >= framebuffer.width || pixel.y >= framebuffer.height)
    throw Error(ErrorCode::usage, concat("--pick: found pixel ", pixel.x, ",", pixel.y, "; expected one below ",
                                         framebuffer.width, ",", framebuffer.height));
  const auto at = static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(framebuffer.width) +
                  static_cast<std::size_t>(pixel.x);
  Json json{{"pixel", {pixel.x, pixel.y}}};
  if (framebuffer.cell[at] == render::Framebuffer::no_cell) {
    json["cell"] = nullptr;
    return json;
  }
  const double depth = framebuffer.depth[at];
  const render::Dataset& dataset = plan.datasets.front();  // every dataset's rays are the same in the world
  const std::vector<std::uint32_t> pixels{static_cast<std::uint32_t>(at)};
  const render::Ray ray =
      camera_rays(dataset, plan.scene.camera, framebuffer.width, framebuffer.height, pixels).front();
  const Affine& world_from_ray = world_from_ray_frame(dataset);
  const Vec3 position = world_from_ray.point(ray.origin + depth * ray.direction);
  json["position"] = rhoray::json_of(position);
  json["depth"] = depth;
  json["length_unit"] = dataset.length_unit();
  json["cell"] = framebuffer.cell[at];
  if (!std::isnan(framebuffer.value[at])) {
    json["value"] = framebuffer.value[at];
    json["unit"] = common_unit(plan);
  }
  if (channels_of_picks(plan.scene).error) {
    const double bound = framebuffer.error[at];
    if (!std::isfinite(bound)) return json;
    if (is_projection(plan.scene.layers.front()))
      json["value_error"] = 0x1.01p0 * bound;
    else
      json["error"] = depth_error(bound, depth, world_from_ray.point(ray.origin), position);
  }
  return json;
}

std::string picked_text(const Json& pick) {
  if (pick["cell"].is_null()) return pixel_text(pick) + ": no hit";
  const auto number_text = [&](const char* number, const char* error, const char* unit) {
    const auto value = pick[number].get<double>();
    const auto word = pick[unit].get<std::string>();
    if (!pick.contains(error)) return with_unit(rounded(value), word);
    return text_with_error(value, pick[error].get<double>(), word);
  };
  return concat(pixel_text(pick), ": position (", position_text(pick), "), cell ", pick["cell"].get<std::uint64_t>(),
                pick.contains("value") ? concat(", value ", number_text("value", "value_error", "unit")) : "",
                ", depth ", number_text("depth", "error", "length_unit"));
}

Json picked_distance(const Json& from, const Json& to) {
  Json json{{"from", from["pixel"]}, {"to", to["pixel"]}, {"distance", nullptr}, {"error", nullptr}};
  if (from["cell"].is_null() || to["cell"].is_null()) return json;
  Vec3 between;
  for (std::size_t axis = 0; axis < 3; ++axis)
    between[static_cast<int>(axis)] = to["position"][axis].get<double>() - from["position"][axis].get<double>();
  const double distance = between.length();
  json["distance"] = distance;
  json["length_unit"] = from["length_unit"];
  // Each end may move by its error; the sum's own rounding is far below the bounds of the ends.
  if (from.contains("error") && to.contains("error"))
    json["error"] = from["error"].get<double>() + to["error"].get<double>() + 0x1p-50 * distance;
  return json;
}

std::string picked_distance_text(const Json& from, const Json& to) {
  const Json json = picked_distance(from, to);
  const std::string start = concat("distance from ", pixel_text(from), " to ", pixel_text(to), ": ");
  const auto which = [&](const auto& lacks) {
    if (lacks(from) && lacks(to)) return std::string("both pixels");
    return pixel_text(lacks(from) ? from : to);
  };
  if (json["distance"].is_null())
    return concat(start, "none, no hit at ", which([](const Json& pick) { return pick["cell"].is_null(); }));
  const auto distance = json["distance"].get<double>();
  const auto unit = json["length_unit"].get<std::string>();
  if (!json["error"].is_null()) return start + text_with_error(distance, json["error"].get<double>(), unit);
  return concat(start, with_unit(rounded(distance), unit), ", no proven error at ",
                which([](const Json& pick) { return !pick.contains("error"); }));
}

}  // namespace rhoray::tools
