#include "render/called_for.h"

#include <array>

#include "formats/base/text.h"
#include "render/effects/effects.h"
#include "render/kernels/kernels.h"
#include "render/volumes/volume.h"

namespace rhoray::render {

namespace {

bool is_projection(const Layer& layer) {
  return layer.mode == Mode::mip;
}

std::string why_diffuse(const Layer& layer) {
  return is_projection(layer) ? "a projection shows values, not a lit surface" : "a surface is lit, from the eye";
}
std::string why_smooth_normals(const Layer& layer) {
  if (is_projection(layer)) return why_diffuse(layer);
  return layer.surface.normals == Normals::smooth ? "normals are smooth"
                                                  : "normals are the exact gradient of the hit's cell";
}
std::string why_field_color(const Layer& layer) {
  if (is_projection(layer)) return why_diffuse(layer);
  return layer.surface.color_by ? concat("coloured by '", layer.surface.color_by->field, "'")
                                : "no field colours the surface";
}
std::string why_specular(const Layer& layer) {
  return is_projection(layer) ? why_diffuse(layer) : concat("specular is ", layer.surface.specular);
}
std::string why_intensity(const Layer& layer) {
  return is_projection(layer)
             ? concat("a projection shows values, ", layer.window.lo, " black to ", layer.window.hi, " white")
             : "it is of projections";
}

struct Row {
  std::string_view effect;
  bool EffectSet::*called_for;
  std::string (*why)(const Layer& layer);
};

/// A row for every effect: EffectSet holds a bool of each and nothing else.
constexpr std::array rows{Row{"diffuse", &EffectSet::diffuse, why_diffuse},
                          Row{"smooth normals", &EffectSet::smooth_normals, why_smooth_normals},
                          Row{"colour by field", &EffectSet::field_color, why_field_color},
                          Row{"specular", &EffectSet::specular, why_specular},
                          Row{"intensity", &EffectSet::intensity, why_intensity}};
static_assert(sizeof(EffectSet) == rows.size(), "an effect has no row here");

}  // namespace

std::vector<EffectReason> reasons_for_effects(const Layer& layer) {
  const EffectSet effects = effects_called_for(layer);
  const bool is_clear = !is_projection(layer) && layer.surface.opacity < 1;
  std::vector<EffectReason> reasons;
  reasons.push_back({"transparency", is_clear,
                     is_projection(layer) ? why_diffuse(layer) : concat("opacity is ", layer.surface.opacity)});
  for (const Row& row : rows) reasons.push_back({row.effect, effects.*row.called_for, row.why(layer)});
  return reasons;
}

std::string_view machine_for(const Volume& volume, const Layer& layer, const FrameOptions& options) {
  const auto kernel = [&](Machine machine) {
    const Kernels kernels = choose_kernels(volume.implementation(), layer.method, machine);
    return is_projection(layer) ? kernels.largest_value : kernels.first_crossing;
  };
  const Machine machine = chosen_machine();
  const bool is_wide = options.use_hierarchy && kernel(machine) != kernel(Machine::scalar);
  return name_of(is_wide ? machine : Machine::scalar);
}

}  // namespace rhoray::render
