#include "tools/analysis/data_errors.h"

#include <cmath>

namespace rhoray::tools {

FieldValues::FieldValues(const render::Dataset& dataset) {
  if (dataset.file().description().kind == "grid")
    grid_.emplace(formats::BrickGrid(dataset.file()), dataset.field().name);
}

std::optional<double> FieldValues::at(const render::Ray& ray, const render::Hit& truth, double isovalue,
                                      double t) const {
  if (grid_) return grid_->value(grid_->index_from_frame(ray.at(t)));
  return isovalue + truth.gradient.dot(ray.direction) * (t - truth.t);
}

render::ErrorList errors_on_data(const render::Truth& truth, const FieldValues& field, const render::Layer& layer,
                                 std::span<const render::Hit> hits, const ResampledBorder* border) {
  render::ErrorList list = render::errors_against(truth, layer.mode, hits);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (border != nullptr) list.is_border.push_back(border->separates(truth.rays[i], truth.hits[i], hits[i]));
    if (layer.mode == render::Mode::mip || !std::isfinite(list.errors[i])) continue;
    if (const auto value = field.at(truth.rays[i], truth.hits[i], layer.isovalue, hits[i].t))
      list.value_errors.push_back(std::abs(*value - layer.isovalue));
  }
  return list;
}

}  // namespace rhoray::tools
