#include "tools/rhoray/render/pick.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "render/truth.h"

namespace rhoray::tools {

void read_value(const std::string& text, std::vector<PixelPlace>& out) {
  out.clear();
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
  channels.error = std::all_of(scene.layers.begin(), scene.layers.end(),
                               [](const render::Layer& layer) { return render::proves(layer.method); });
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
      pixel_rays(dataset, plan.scene.camera, {framebuffer.width, framebuffer.height}, pixels).front();
  json["position"] = json_of(world_from_ray_frame(dataset).point(ray.origin + depth * ray.direction));
  json["depth"] = depth;
  json["length_unit"] = dataset.length_unit();
  json["cell"] = framebuffer.cell[at];
  if (!std::isnan(framebuffer.value[at])) {
    json["value"] = framebuffer.value[at];
    json["unit"] = common_unit(plan);
  }
  if (!framebuffer.error.empty()) json["error"] = framebuffer.error[at];
  return json;
}

std::string picked_text(const Json& pick) {
  const std::string pixel = concat("pixel ", pick["pixel"][0].get<int>(), ",", pick["pixel"][1].get<int>(), ": ");
  if (pick["cell"].is_null()) return pixel + "no hit";
  const auto with_unit = [&](const char* number, const char* unit) {
    const auto word = pick[unit].get<std::string>();
    return concat(rounded(pick[number].get<double>()), word.empty() ? "" : " ", word);
  };
  const Json& place = pick["position"];
  return concat(pixel, "position (", rounded(place[0].get<double>()), " ", rounded(place[1].get<double>()), " ",
                rounded(place[2].get<double>()), "), cell ", pick["cell"].get<std::uint64_t>(),
                pick.contains("value") ? concat(", value ", with_unit("value", "unit")) : "", ", depth ",
                with_unit("depth", "length_unit"),
                pick.contains("error") ? concat(", error at most ", with_unit("error", "length_unit")) : "");
}

}  // namespace rhoray::tools
