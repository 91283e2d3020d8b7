#pragma once

#include <optional>
#include <span>

#include "render/truth.h"
#include "tools/analysis/border.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools {

/// Evaluates the original data on rays.
class FieldValues {
 public:
  explicit FieldValues(const render::Dataset& dataset);

  /// The field at t: trilinear between the samples of a grid. In a mesh and in OpenVDB it is
  /// extrapolated with the true hit's gradient; that equals the field as long as the position is in
  /// the same cell. Nothing outside the data.
  std::optional<double> at(const render::Ray& ray, const render::Hit& truth, double isovalue, double t) const;

 private:
  std::optional<validate::GridField> grid_;
};

/// Compares hits with the true ones, as errors_against, and evaluates the original data for
/// value_errors and is_border.
/// @param hits    values in the truth's unit
/// @param border  between a mesh and the grid that was traced instead; null: there is none
render::ErrorList errors_on_data(const render::Truth& truth, const FieldValues& field, const render::Layer& layer,
                                 std::span<const render::Hit> hits, const ResampledBorder* border = nullptr);

}  // namespace rhoray::tools
