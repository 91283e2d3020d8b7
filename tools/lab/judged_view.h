#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/load.h"
#include "render/render.h"
#include "tools/analysis/errors.h"
#include "tools/analysis/field_truth.h"
#include "tools/analysis/picture_errors.h"
#include "tools/analysis/truth.h"
#include "tools/rhoray/report.h"

namespace rhoray::study {

/// Which isosurface is seen from where, and how long the judge may work.
struct ViewSpec {
  double isovalue = 0;
  render::Camera camera{};
  tools::PictureSize size{512, 512};
  double judge_seconds = 60;  ///< pixels are judged in random order until this time is over
  std::uint64_t seed = 1;
};

/// What is drawn instead: other data in the same place of the world, another method, or both.
struct Shown {
  const render::Volume& volume;
  double isovalue = 0;  ///< in this volume's own unit
  render::Method method{};
  const tools::ResampledBorder* border = nullptr;  ///< of a mesh that was resampled
};

/// An isosurface of some data, of which the exact judge decides every pixel or a random sample, and how far other forms
/// of the data and other methods are from it.
class JudgedView {
 public:
  /// Refuses a view of which no judged pixel shows the surface (ErrorCode::usage).
  JudgedView(const render::Volume& volume, const ViewSpec& setting);
  ~JudgedView();

  const tools::Truth& truth() const { return truth_; }
  /// The median length in the world of the cells that the hits lie in, along the rays.
  double cell_length() const;

  /// Columns of a table: rays and hits, missed and false hits, hits that lie more than a cell elsewhere (behind a sheet
  /// that was not seen), all three of a million; of a resampled mesh how many of them its border makes and how many the
  /// samples; errors of depth in cells and in the world's unit, those at the border left out; in a
  /// grid also of the value at the place that was found, against the isovalue, in shares of the field's range.
  tools::Json ray_errors(const Shown& shown) const;
  /// Columns: angles between normals, and how the picture differs.
  tools::Json picture_errors(const Shown& shown) const;

  /// Draws the picture on one thread, as it is timed.
  void draw(const Shown& shown);

 private:
  render::FrameStatistics draw(const Shown& shown, const render::ChannelSet& channels, unsigned threads,
                               render::Framebuffer& picture, render::RenderContext& memory) const;

  render::Volume volume_;
  ViewSpec wish_;
  tools::FieldTruth field_;
  render::Scene scene_;  ///< of one layer
  tools::Truth truth_;
  std::unique_ptr<const tools::TruePicture> picture_;
  render::Framebuffer timed_;
  render::RenderContext memory_;
};

}  // namespace rhoray::study
