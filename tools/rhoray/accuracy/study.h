#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/render.h"
#include "tools/rhoray/accuracy/data_forms.h"
#include "tools/rhoray/accuracy/errors.h"
#include "tools/rhoray/accuracy/picture_errors.h"
#include "tools/rhoray/accuracy/truth.h"
#include "tools/rhoray/accuracy/variant.h"
#include "tools/rhoray/scene/plan.h"

namespace rhoray::tools {

/// What was found out about a variant.
struct Measured {
  Variant variant;
  std::string method{};    ///< its word
  std::string left_out{};  ///< why nothing was found out; else empty
  std::string note{};
  std::optional<ErrorCounts> errors{};  ///< of variants that ask rays
  std::vector<float> error_list{};      ///< of the truth's pixels (errors.h)
  std::optional<PictureErrors> picture_errors{};
  std::optional<render::Framebuffer> picture{};  ///< of variants that the report shows
  std::vector<double> cpu_ms{}, wall_ms{};       ///< of each time that the picture was drawn
  double prepare_ms = 0;                         ///< what the first picture of an isovalue takes beside that
  double preprocess_s = 0;                       ///< to make the copy of the data
  std::uint64_t data_bytes = 0;
  double pass_s = 0;  ///< that all of this took
};

/// What one pass over all variants found out, at one size of the picture.
struct PassResult {
  PictureSize size;
  Truth truth;
  std::string picture_method{};  ///< of the picture that is taken as true
  std::shared_ptr<const TruePicture> true_picture{};
  std::vector<Measured> rows{};
};

struct LayerStudyOptions {
  std::uint64_t seed = 1;
  unsigned threads = 0;
  FormOptions forms{};
  std::stop_token stop{};
};

/// One layer of a scene, alone: its variants, measured.
class LayerStudy {
 public:
  /// @param plan   whose other layers are left out
  LayerStudy(const ScenePlan& plan, std::size_t layer, LayerStudyOptions options);

  const std::string& name() const { return name_; }
  const render::Scene& scene() const { return scene_; }
  const render::Volume& volume() const { return volume_; }
  const std::vector<Variant>& variants() const { return variants_; }
  const PassResult* result() const { return result_ ? &*result_ : nullptr; }  ///< of the last pass; null before

  struct Pass {
    PictureSize size;
    double judge_seconds = 0;
    /// Variants that are foreseen, by the pass before, not to fit into this are left out, the dearest first.
    double seconds = 0;
    /// Samples at a step are left out where those at the last one, twice as far apart, took half of this; 0: none.
    double variant_seconds = 0;
    std::function<void(std::size_t done)> variant_done = nullptr;
  };
  /// Refuses a picture in which nothing is hit (Trouble::usage). While the first pass goes on its result is what has
  /// been measured; later ones replace the result at their end, so that an interrupt leaves that of the pass before.
  void pass(const Pass& wish);

  /// Draws the picture of a row of the result once more and notes the time.
  void time_again(std::size_t row);
  double foreseen_s(std::size_t row) const;  ///< that this takes

 private:
  /// Draws a variant's picture, enlarged where it is smaller.
  render::FrameStatistics draw(const Variant& variant, const PictureSize& size, const render::ChannelSet& channels,
                               render::Framebuffer& picture);
  void draw_truth(PassResult& result);
  const TruePicture& compared_with(const Variant& variant, const PassResult& result);
  Measured measured(const Variant& variant, const PassResult& result);
  void measure(Measured& row, const PassResult& result);
  void measure_exact(Measured& row, const PassResult& result);
  void ask_rays(Measured& row, const FormedData& data, const PassResult& result);
  void time(Measured& row, const PictureSize& size);
  std::vector<bool> too_dear(const Pass& wish) const;

  LayerStudyOptions options_;
  std::string name_;
  render::Scene scene_;
  render::Volume volume_;
  bool use_hierarchy_;
  DataForms forms_;
  FieldTruth field_;
  std::vector<Variant> variants_;
  std::optional<PassResult> result_;
  std::shared_ptr<const TruePicture> many_occlusion_rays_;
  render::FrameMemory memory_;
  render::Framebuffer picture_;  ///< of pictures that are timed
};

}  // namespace rhoray::tools
