#include "render/document/several_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "formats/base/interval.h"

namespace rhoray::render {

namespace {

/// Colours of several isosurfaces, in order: Paul Tol's scheme "light" (technical note
/// SRON/EPS/TN/09-002), made to be told apart with any colour vision; they are light enough that
/// shading still shows.
constexpr std::array palette{"#77aadd", "#ee8866", "#eedd88", "#44bb99", "#ffaabb", "#bbcc33", "#99ddff", "#aaaa00"};

bool contains(const Box3& outer, const Box3& inner) {
  return outer.intersects(inner.min) && outer.intersects(inner.max);
}

/// Whether isovalues below 0 and above 0 enclose different regions, as those of a dipole do and
/// those of skin and bone do not.
bool are_two_sided(const Dataset& dataset, const Interval<double>& isovalues) {
  if (!(isovalues.lo < 0 && isovalues.hi > 0)) return false;
  const Box3 lowest = dataset.isosurface_bounds(isovalues.lo), highest = dataset.isosurface_bounds(isovalues.hi);
  return !contains(lowest, highest) && !contains(highest, lowest);
}

Interval<double> range_of(const std::vector<Layer*>& surfaces) {
  Interval<double> range;
  for (const Layer* surface : surfaces) range.include(surface->isovalue);
  return range;
}

/// Bounds of a grid's isosurfaces may be equal although one is inside another: they are those of
/// whole cells. Then the larger value is inside.
void fade_outer(const Dataset& dataset, const std::vector<Layer*>& surfaces) {
  std::vector<std::pair<double, Layer*>> by_size;
  for (Layer* surface : surfaces)
    by_size.emplace_back(dataset.isosurface_bounds(surface->isovalue).size().length(), surface);
  std::sort(by_size.begin(), by_size.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second->isovalue > b.second->isovalue;
  });
  for (std::size_t i = 1; i < by_size.size(); ++i)
    by_size[i].second->material.opacity = std::round(100.0 / static_cast<double>(i + 2)) / 100;
}

}  // namespace

Vec3 color_of_surface(std::size_t index, std::size_t count) {
  if (count <= palette.size()) {
    Color color;
    read_value(palette[index], color);
    return color.linear;
  }
  struct Tone {
    double saturation, brightness;
  };
  constexpr std::array<Tone, 3> tones{{{0.5, 0.9}, {0.75, 0.75}, {0.35, 1}}};
  const Tone tone = tones[index % tones.size()];
  const std::size_t rounds = (count + tones.size() - 1) / tones.size();
  const double hue = 6 * static_cast<double>(index) / static_cast<double>(rounds * tones.size());
  const auto part = [&](double from) {
    const double k = std::fmod(from + hue, 6);
    return tone.brightness * (1 - tone.saturation * std::max(0.0, std::min({k, 4 - k, 1.0})));
  };
  return linear_from_srgb({part(5), part(3), part(1)});
}

bool are_colored_by_isovalue(const LayerSpec& spec, std::size_t count) {
  const bool may_be_isosurface = spec.type == LayerType::isosurface || spec.type == LayerType::automatic;
  return may_be_isosurface && count > 1 && !spec.color && spec.color_by.empty() && spec.texture.empty();
}

void show_several(const LayerSpec& spec, const Dataset& dataset, const std::vector<Layer*>& surfaces) {
  const bool is_colored = are_colored_by_isovalue(spec, surfaces.size());
  if (surfaces.size() < 2 || (!is_colored && spec.opacity)) return;
  Interval<double> range = range_of(surfaces);
  const bool is_two_sided = are_two_sided(dataset, range);
  if (is_two_sided) range = {-std::max(-range.lo, range.hi), std::max(-range.lo, range.hi)};
  if (is_colored)
    for (Layer* surface : surfaces)
      surface->material.color = color_of(is_two_sided ? ColorMap::coolwarm : ColorMap::viridis,
                                         range.lo < range.hi ? position_of({}, range, surface->isovalue) : 0);
  if (spec.opacity) return;
  std::vector<Layer*> below, others;
  for (Layer* surface : surfaces) (is_two_sided && surface->isovalue < 0 ? below : others).push_back(surface);
  fade_outer(dataset, below);
  fade_outer(dataset, others);
}

}  // namespace rhoray::render
