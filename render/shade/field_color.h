#pragma once

#include "render/scene.h"
#include "render/shade/color_scale.h"
#include "render/shade/color_table.h"
#include "render/shade/lanes.h"

namespace rhoray::render {

/// Colours a surface by a field's values at the hits. Where a value is NaN, the surface's own
/// colour is used.
RHORAY_INLINE void find_field_colors(const Material& surface, const double* values, Colors& colors) {
  const FieldColors& by = *surface.color_by;
  double positions[RayBatch::group_size];
  const EvenNumbers even = spread_evenly(by.scale, by.range, values, positions);
  ColorTable::of(by.map).look_up(even.numbers, even.range, colors);
  const Imath::V3f own(surface.color);
  for (std::size_t i = 0; i < colors.red.size(); ++i) {
    const bool has_value = values[i] == values[i];
    colors.red[i] = has_value ? colors.red[i] : own.x;
    colors.green[i] = has_value ? colors.green[i] : own.y;
    colors.blue[i] = has_value ? colors.blue[i] : own.z;
  }
}

}  // namespace rhoray::render
