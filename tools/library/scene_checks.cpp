#include "tools/library/scene_checks.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "formats/base/text.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1::inside {

namespace {

void check_color(std::string_view name, const Vec3& color) {
  for (const double component : {color.x, color.y, color.z})
    if (!(component >= 0 && component <= 1))
      refuse(name, ": found (", color.x, ", ", color.y, ", ", color.z, "); expected numbers from 0 to 1");
}

void check_colors(std::string_view name, const ColorScale& colors) {
  if (colors.range && !(colors.range->lo <= colors.range->hi && std::isfinite(colors.range->hi - colors.range->lo)))
    refuse(name, ".range: found ", colors.range->lo, " to ", colors.range->hi, "; expected a finite range");
  if (colors.range && colors.is_logarithmic && !(colors.range->lo > 0))
    refuse(name, ".range: found ", colors.range->lo, " to ", colors.range->hi,
           " by logarithm; expected numbers above 0");
  if (colors.levels != 0 && !(colors.levels >= 2 && colors.levels <= 65536))
    refuse(name, ".levels: found ", colors.levels, "; expected 2 to 65536, or 0");
}

void check_material(const Material& material) {
  check_color("Material::color", material.color);
  for (const auto& [name, value] :
       {std::pair{"ambient", material.ambient}, {"specular", material.specular}, {"opacity", material.opacity}})
    if (!(value >= 0 && value <= 1)) refuse("Material::", name, ": found ", value, "; expected 0 to 1");
  if (!(material.shininess >= 1 && material.shininess <= 1e4))
    refuse("Material::shininess: found ", material.shininess, "; expected 1 to 10000");
  if (material.color_by) check_colors("Material::color_by", material.color_by->colors);
  if (material.normals) require_enumerator("Material::normals", *material.normals, Normals::smooth);
}

void check_layer(const Layer& layer) {
  const std::string& file = layer.data.implementation().first().file().name();
  const bool shows_triangles = std::holds_alternative<Triangles>(layer.show);
  if (shows_triangles != (layer.data.kind() == DataKind::triangles))
    refuse(file, shows_triangles ? ": holds no triangles" : ": holds triangles; expected Triangles");
  if (const auto* const surface = std::get_if<Isosurface>(&layer.show); surface && !std::isfinite(surface->isovalue))
    refuse("Isosurface::isovalue: found ", surface->isovalue, "; expected a finite number");
  if (const auto* const projection = std::get_if<MaximumProjection>(&layer.show))
    check_colors("MaximumProjection::colors", projection->colors);
  if (const auto* const slice = std::get_if<Slice>(&layer.show)) {
    check_colors("Slice::colors", slice->colors);
    if (slice->threshold && !(slice->threshold->lo <= slice->threshold->hi))
      refuse("Slice::threshold: found ", slice->threshold->lo, " to ", slice->threshold->hi,
             "; expected a range that is not empty");
  }
  check_material(layer.material);
  if (shows_triangles && layer.method && *layer.method != Accuracy::float32 && *layer.method != Accuracy::float64)
    refuse(file, ": triangles are traced only at float32 and float64");
}

}  // namespace

void check(const Scene& scene) {
  for (std::size_t i = 0; i < scene.layers.size(); ++i) try {
      check_layer(scene.layers[i]);
    } catch (const v0_1::Error& error) {
      throw v0_1::Error(error.code(), concat("layer ", i, ": ", error.what()), error.hint());
    }
  for (const Light& light : scene.lights) {
    require_enumerator("Light::kind", light.kind, Light::Kind::point);
    if (!(light.samples >= 1 && light.samples <= 4096))
      refuse("Light::samples: found ", light.samples, "; expected 1 to 4096");
  }
  const Occlusion& occlusion = scene.occlusion;
  if (!(occlusion.radius >= 0 && std::isfinite(occlusion.radius)))
    refuse("Occlusion::radius: found ", occlusion.radius, "; expected a finite number from 0 up");
  if (!(occlusion.samples >= 1 && occlusion.samples <= 4096))
    refuse("Occlusion::samples: found ", occlusion.samples, "; expected 1 to 4096");
  if (scene.fog) {
    check_color("Fog::color", scene.fog->color);
    const Interval& range = scene.fog->range;
    if (!(range.lo < range.hi && std::isfinite(range.hi - range.lo)))
      refuse("Fog::range: found ", range.lo, " to ", range.hi, "; expected a finite range with lo < hi");
  }
  if (scene.clip && !scene.clip->box && scene.clip->planes.empty())
    refuse("Scene::clip: found neither a box nor planes; expected at least one of them");
  if (scene.background) check_color("Scene::background", *scene.background);
}

}  // namespace rhoray::v0_1::inside
