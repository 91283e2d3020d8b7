#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/load.h"
#include "render/render.h"
#include "render/scene_spec.h"
#include "render/truth.h"
#include "tools/analysis/data_errors.h"
#include "tools/analysis/picture_errors.h"
#include "tools/rhoray/report.h"

namespace rhoray::study {

/// An isosurface, its view, and the time limit for exact arithmetic.
struct ViewSpec {
  double isovalue = 0;
  render::Camera camera{};
  render::PictureSize size{512, 512};
  double judge_seconds = 60;  ///< pixels are decided in random order until this time is over
  std::uint64_t seed = 1;
};

/// An alternative to draw: other data at the same position in the world, another method, or both.
struct Shown {
  const render::Dataset& dataset;
  double isovalue = 0;  ///< in this volume's own unit
  render::Method method{};
  const tools::ResampledBorder* border = nullptr;  ///< of a resampled mesh
};

/// An isosurface of some data. Exact arithmetic decides every pixel or a random sample. Measures
/// how far other data representations and methods deviate from the exact picture.
class ExactView {
 public:
  /// Refuses a view in which no decided pixel shows the surface (ErrorCode::usage).
  ExactView(const render::Dataset& dataset, const ViewSpec& setting);
  ~ExactView();

  const render::Truth& truth() const { return truth_; }
  /// The median length, in the world and along the rays, of the cells that contain the hits.
  double cell_length() const;

  /// Columns of a table:
  ///   - numbers of rays and hits;
  ///   - missed hits, false hits, and hits more than a cell away (behind a sheet that was missed),
  ///     all three per million rays;
  ///   - for a resampled mesh, how many of them come from its border and how many from the samples;
  ///   - errors of depth in cells and in the world's unit, without those at the border;
  ///   - in a grid, also errors of the value at the found position against the isovalue, as
  ///     fractions of the field's range.
  Json ray_errors(const Shown& shown) const;
  /// Columns: angles between normals, and differences of the pictures.
  Json picture_errors(const Shown& shown) const;

  /// Draws the picture on one thread, for timing.
  void draw(const Shown& shown);

 private:
  render::FrameStatistics draw(const Shown& shown, const render::ChannelSet& channels, unsigned threads,
                               render::Framebuffer& picture, render::RenderContext& memory) const;

  render::Dataset dataset_;
  ViewSpec setting_;
  tools::FieldValues field_;
  render::Scene scene_;  ///< with one layer
  render::Truth truth_;
  std::unique_ptr<const tools::TruePicture> picture_;
  render::Framebuffer timed_;
  render::RenderContext memory_;
};

}  // namespace rhoray::study
