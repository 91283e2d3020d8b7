#include "render/shade/color_table.h"

#include <vector>

namespace rhoray::render {

ColorTable::ColorTable(ColorMap map) {
  for (std::size_t i = 0; i < colors_.size(); ++i) {
    const Vec3 color = color_of(map, static_cast<double>(i) / static_cast<double>(steps));
    colors_[i] = {static_cast<float>(color.x), static_cast<float>(color.y), static_cast<float>(color.z)};
  }
}

const ColorTable& ColorTable::of(ColorMap map) {
  static const std::vector<ColorTable> tables = [] {
    std::vector<ColorTable> all;
    for (const NamedColorMap& named : color_maps()) all.emplace_back(named.map);
    return all;
  }();
  return tables[2 * static_cast<std::size_t>(map.base) + map.is_reversed];
}

}  // namespace rhoray::render
