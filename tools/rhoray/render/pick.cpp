#include "tools/rhoray/render/pick.h"

#include <charconv>
#include <cmath>

#include "formats/base/error.h"
#include "formats/base/number_text.h"

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

Json picked(const render::Framebuffer& framebuffer, const PixelPlace& pixel) {
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
  json["cell"] = framebuffer.cell[at];
  if (!std::isnan(framebuffer.value[at])) json["value"] = framebuffer.value[at];
  json["depth"] = framebuffer.depth[at];
  return json;
}

std::string picked_text(const Json& pick, const std::string& length_unit) {
  const std::string pixel = concat("pixel ", pick["pixel"][0].get<int>(), ",", pick["pixel"][1].get<int>(), ": ");
  if (pick["cell"].is_null()) return pixel + "no hit";
  const std::string value = pick.contains("value") ? concat(", value ", rounded(pick["value"].get<double>())) : "";
  return concat(pixel, "cell ", pick["cell"].get<std::uint64_t>(), value, ", depth ",
                rounded(pick["depth"].get<double>()), length_unit.empty() ? "" : " ", length_unit);
}

}  // namespace rhoray::tools
