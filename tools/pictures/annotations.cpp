#include "tools/pictures/annotations.h"

#include <algorithm>
#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "render/scene_words.h"
#include "tools/pictures/pictures.h"

namespace rhoray::tools {

namespace {

std::string title_of(const formats::FieldSummary& field) {
  return field.unit.empty() ? field.name : concat(field.name, " (", field.unit, ")");
}

/// The fields that the layers show by colours, each once.
std::vector<ColorBar> layer_bars(const render::ResolvedScene& plan) {
  std::vector<ColorBar> bars;
  const auto add = [&](const ColorBar& bar) {
    if (std::find(bars.begin(), bars.end(), bar) == bars.end()) bars.push_back(bar);
  };
  for (const render::Layer& layer : plan.scene.layers) {
    const render::Dataset& dataset = plan.datasets[layer.dataset];
    if (layer.mode == render::Mode::mip)
      add({title_of(dataset.field()), layer.map, layer.window, layer.scale});
    else if (const auto& colors = layer.material.color_by)
      add({title_of(dataset.field(colors->field).value()), colors->map, colors->range, colors->scale});
  }
  return bars;
}

/// The name of a layer's label, or its number where the file has no name.
std::string label_text(const render::Dataset& dataset, const render::DataSpec& data) {
  const bool is_of_cells = dataset.is_surface();
  const formats::LabelNames names = is_of_cells
                                        ? dataset.field(data.field).value_or(formats::FieldSummary{}).label_names
                                        : dataset.field().label_names;
  // Data of one label of a grid have the value 1 where the label is.
  const auto name = names.find(is_of_cells ? *data.label : 1);
  return name == names.end() ? concat(*data.label) : name->second;
}

/// The labels of each field that is shown by labels.
std::vector<Legend> legends_of_labels(const render::ResolvedScene& plan) {
  std::vector<Legend> legends;
  for (const render::Layer& layer : plan.scene.layers) {
    const render::DataSpec& data = plan.data[layer.dataset];
    if (!data.label || layer.material.color_by || layer.material.texture) continue;
    const std::string title = data.field.empty() ? "labels" : data.field;
    auto legend = std::find_if(legends.begin(), legends.end(), [&](const Legend& each) { return each.title == title; });
    if (legend == legends.end()) legend = legends.insert(legends.end(), {.title = title, .entries = {}});
    legend->entries.push_back({layer.material.color, label_text(plan.datasets[layer.dataset], data)});
  }
  return legends;
}

/// Returns the extent that sets the number of digits in a legend: the width of the field's range,
/// or 1,000 times the least distance of two isovalues if that is smaller. The isovalues decrease.
double extent_of(const std::vector<const render::Layer*>& surfaces, const Interval<double>& range) {
  double extent = range.hi - range.lo;
  for (std::size_t i = 1; i < surfaces.size(); ++i)
    if (const double gap = surfaces[i - 1]->isovalue - surfaces[i]->isovalue; gap > 0)
      extent = std::min(extent, 1000 * gap);
  return extent;
}

/// Isosurfaces that have colours of their own, by dataset; the largest value first.
std::vector<Legend> legends_of(const render::ResolvedScene& plan) {
  std::vector<Legend> legends = legends_of_labels(plan);
  for (std::size_t dataset = 0; dataset < plan.datasets.size(); ++dataset) {
    std::vector<const render::Layer*> surfaces;
    for (const render::Layer& layer : plan.scene.layers)
      if (layer.dataset == dataset && layer.mode == render::Mode::isosurface && !layer.material.color_by &&
          !layer.material.texture)
        surfaces.push_back(&layer);
    if (surfaces.empty() || plan.data[dataset].label) continue;
    std::stable_sort(surfaces.begin(), surfaces.end(),
                     [](const render::Layer* a, const render::Layer* b) { return a->isovalue > b->isovalue; });
    const auto& field = plan.datasets[dataset].field();
    Legend& legend = legends.emplace_back(Legend{.title = title_of(field), .entries = {}});
    const double extent = extent_of(surfaces, field.range);
    for (const render::Layer* surface : surfaces)
      legend.entries.push_back(
          {surface->material.color, with_minus_signs(rounded_within(extent, surface->isovalue, 5))});
  }
  return legends;
}

/// Errors are shown by their powers of ten.
ColorBar heat_bar(render::DebugChannel page, const Interval<double>& heat) {
  if (page != render::DebugChannel::error) return {word_of(page), render::ColorMap::viridis, heat};
  return {concat("log10 of ", word_of(page)), render::ColorMap::viridis, {std::log10(heat.lo), std::log10(heat.hi)}};
}

/// The parts of a line in a clip region, or outside it if the region is cut away.
void add_clipped(const std::array<Vec3, 2>& line, const std::vector<render::HalfSpace>& region, bool cuts_away,
                 std::vector<std::array<Vec3, 2>>& out) {
  Interval<double> inside{0, 1};  // shares of the way
  for (const render::HalfSpace& half : region) {
    const double from = half.normal.dot(line[0] - half.point), to = half.normal.dot(line[1] - half.point);
    if (from < 0 && to < 0) inside = {1, 0};
    if (from < 0 && to >= 0) inside.lo = std::max(inside.lo, from / (from - to));
    if (from >= 0 && to < 0) inside.hi = std::min(inside.hi, from / (from - to));
  }
  const auto add = [&](double first, double last) {
    const Vec3 way = line[1] - line[0];
    if (first < last) out.push_back({line[0] + first * way, line[0] + last * way});
  };
  if (!cuts_away) return add(inside.lo, inside.hi);
  if (!(inside.lo < inside.hi)) return add(0, 1);
  add(0, inside.lo);
  add(inside.hi, 1);
}

bool has_lines(const render::ResolvedScene& plan) {
  return std::any_of(plan.origins.begin(), plan.origins.end(),
                     [](const render::LayerOrigin& origin) { return origin.lines != nullptr; });
}

/// Dark lines; light ones on dark surfaces.
Vec3 line_color(const Vec3& surface) {
  return luminance(surface) < 0.08 ? Vec3(0.8, 0.8, 0.8) : Vec3(0.01, 0.01, 0.01);
}

std::vector<SurfaceLines> surface_lines(const render::ResolvedScene& plan) {
  std::vector<SurfaceLines> all;
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const render::Layer& layer = plan.scene.layers[i];
    if (!plan.origins[i].lines) continue;
    SurfaceLines& lines = all.emplace_back(SurfaceLines{.lines = {}, .color = line_color(layer.material.color)});
    const bool is_clipped = plan.scene.clip && layer.clipped;
    const std::vector<render::HalfSpace> region =
        is_clipped ? half_spaces_of(*plan.scene.clip) : std::vector<render::HalfSpace>{};
    for (const auto& line : plan.origins[i].lines->edges)
      add_clipped(line, region, is_clipped && plan.scene.clip->cuts_away, lines.lines);
  }
  return all;
}

Side side_of(const std::string& word, Side otherwise) {
  return word.empty() ? otherwise : word == "left" ? Side::left : Side::right;
}

}  // namespace

formats::Space space_of(const render::ResolvedScene& plan) {
  for (const render::Layer& layer : plan.scene.layers)
    if (plan.datasets[layer.dataset].space() != plan.space) return formats::Space::unknown;
  return plan.space;
}

Annotations annotations_of(const render::ResolvedScene& plan, const Interval<double>& heat) {
  const render::AnnotationsSpec& spec = plan.annotations;
  const std::vector<render::Layer>& layers = plan.scene.layers;
  Annotations annotations{.camera = plan.scene.camera, .space = space_of(plan)};
  if (spec.axes) {
    annotations.axes = true;
    annotations.axes_side = side_of(spec.axes->corner, Side::left);
  }
  if (spec.box.value_or(false)) {
    annotations.box = plan.annotated_box;
    annotations.length_unit = plan.datasets[layers[0].dataset].length_unit();
    annotations.hides_box = std::any_of(layers.begin(), layers.end(),
                                        [](const render::Layer& layer) { return layer.mode != render::Mode::mip; });
  }
  if (spec.color_bar) {
    annotations.bars_side = side_of(spec.color_bar->position, Side::right);
    if (!plan.page)
      annotations.bars = layer_bars(plan);
    else if (!heat.is_empty())
      annotations.bars = {heat_bar(*plan.page, heat)};
    for (ColorBar& bar : annotations.bars)
      if (!spec.color_bar->title.empty()) bar.title = spec.color_bar->title;
  }
  if (spec.legend.value_or(false)) annotations.legends = legends_of(plan);
  annotations.surface_lines = surface_lines(plan);
  annotations.caption = spec.caption;
  return annotations;
}

bool has_texts(const render::ResolvedScene& plan) {
  const auto& [axes, box, bar, legend, caption] = plan.annotations;
  return axes || box.value_or(false) || bar || legend.value_or(false) || !caption.empty();
}

render::ChannelSet channels_of_annotations(const render::ResolvedScene& plan) {
  return {.depth = plan.annotations.box.value_or(false) || has_lines(plan)};
}

void draw_annotations(const render::ResolvedScene& plan, const Interval<double>& heat, render::Framebuffer& picture) {
  if (!has_texts(plan) && !has_lines(plan)) return;
  const std::filesystem::path font = has_texts(plan) ? find_font(known_fonts()) : std::filesystem::path();
  annotate(
      annotations_of(plan, heat),
      [&](const std::string& text, int pixels) { return make_text_image(text, pixels, font); }, picture);
}

}  // namespace rhoray::tools
