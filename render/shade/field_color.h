#pragma once

#include "render/scene.h"
#include "render/shade/color_table.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Colours a surface by a field's values at the hits. Where a value is NaN, the surface's own
/// colour is used.
RHORAY_INLINE void find_field_colors(const Material& surface, const double* values, Colors& colors) {
  ColorTable::of(surface.color_by->map).look_up(values, surface.color_by->range, colors);
  const Imath::V3f own(surface.color);
  for (std::size_t i = 0; i < colors.red.size(); ++i) {
    const bool has_value = values[i] == values[i];
    colors.red[i] = has_value ? colors.red[i] : own.x;
    colors.green[i] = has_value ? colors.green[i] : own.y;
    colors.blue[i] = has_value ? colors.blue[i] : own.z;
  }
}

}  // namespace rhoray::render
