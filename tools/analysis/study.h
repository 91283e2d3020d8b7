#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/document.h"
#include "render/render.h"
#include "render/truth.h"
#include "tools/analysis/data_errors.h"
#include "tools/analysis/data_forms.h"
#include "tools/analysis/picture_errors.h"
#include "tools/analysis/variant.h"

namespace rhoray::tools {

/// Measurements of a variant.
struct Measured {
  Variant variant;
  std::string method{};    ///< its name
  std::string left_out{};  ///< why nothing was measured; else empty
  std::string note{};
  std::optional<render::ErrorCounts> errors{};  ///< for variants that trace rays
  bool judges_all = false;                      ///< errors are for all pixels, not for a random sample
  /// For the truth's pixels (errors.h); empty if only some of them were traced.
  std::vector<float> error_list{};
  std::optional<PictureErrors> picture_errors{};
  std::optional<render::Framebuffer> picture{};  ///< for variants that the report shows
  /// For each time that the picture was rendered; without wall_ms extrapolated from some pixels.
  std::vector<double> cpu_ms{}, wall_ms{};
  double prepare_ms = 0;           ///< additional time for the first picture of an isovalue
  double preprocess_s = 0;         ///< to make the copy of the data
  std::uint64_t data_bytes = 0;    ///< of the file
  std::uint64_t memory_bytes = 0;  ///< mapped or allocated for rendering; 0: not known
  double pass_s = 0;               ///< duration of all of this
};

/// Overhead of the measuring instruments.
struct InstrumentCost {
  /// Of a picture's CPU time: minimum with against minimum without, measured in turn.
  double share = 0;
  double noise = 0;  ///< the same ratio for two series without instruments
  int pictures = 0;  ///< of each kind
};

/// Result of one pass over all variants, at one size of the picture.
struct PassResult {
  render::PictureSize size;
  render::Truth truth;
  std::string picture_method{};  ///< method of the picture that is taken as true
  std::shared_ptr<const TruePicture> true_picture{};
  std::vector<Measured> rows{};
};

struct LayerStudyOptions {
  std::uint64_t seed = 1;
  unsigned threads = 0;
  FormOptions forms{};
  std::stop_token stop{};
};

/// One layer of a scene, alone: its variants and their measurements.
class LayerStudy {
 public:
  /// @param plan   its other layers are ignored
  LayerStudy(const render::ResolvedScene& plan, std::size_t layer, LayerStudyOptions options);

  const std::string& name() const { return name_; }
  const render::Scene& scene() const { return scene_; }
  const render::Dataset& dataset() const { return dataset_; }
  bool is_projection() const { return scene_.layers[0].mode == render::Mode::mip; }
  const std::vector<Variant>& variants() const { return variants_; }
  /// Of the last pass; null before.
  const PassResult* result() const { return result_ ? &*result_ : nullptr; }

  struct Pass {
    render::PictureSize size;
    double judge_seconds = 0;
    /// Variants that, by the times of the last pass, would not fit into this time are left out, the
    /// most expensive first.
    double seconds = 0;
    /// A sampled variant is not rendered if the last one, with steps twice as large, took half of
    /// this time; 0: all are rendered.
    double variant_seconds = 0;
    /// Such variants are measured on random pixels only, for this time. 0: not at all.
    double part_seconds = 0;
    /// @param share  completed share of the pass: by the time of each variant in the last pass,
    ///               else by their count
    std::function<void(double share)> variant_done = nullptr;
  };
  /// Refuses a picture in which nothing is hit (ErrorCode::usage). During the first pass, the
  /// result contains what has been measured so far. Later passes replace the result at their end,
  /// so that an interrupt keeps that of the pass before.
  void pass(const Pass& spec);

  /// Renders the picture of a row of the result once more and adds its time.
  void time_again(std::size_t row);
  double foreseen_s(std::size_t row) const;  ///< predicted time for this

  /// Renders the picture of the data's default method with and without the instruments for timing
  /// and interrupts, in turn.
  InstrumentCost instrument_cost(double seconds);

 private:
  /// What a variant renders, and from which data.
  struct Setup {
    const FormedData& data;
    render::Scene scene;
    render::FrameOptions frame;
  };
  Setup setup(const Variant& variant, const render::PictureSize& size, const render::ChannelSet& channels);
  render::FrameStatistics draw(const Variant& variant, const render::PictureSize& size,
                               const render::ChannelSet& channels, render::Framebuffer& picture);
  void draw_truth(PassResult& result);
  const TruePicture& compared_with(const Variant& variant, const PassResult& result);
  Measured measured(const Variant& variant, const PassResult& result);
  Measured measured_in_part(const Variant& variant, const PassResult& result, double seconds);
  void measure(Measured& row, const PassResult& result);
  void measure_exact(Measured& row, const PassResult& result);
  void ask_rays(Measured& row, const FormedData& data, const PassResult& result);
  void time(Measured& row, const render::PictureSize& size);
  void weigh(Measured& row);
  std::vector<bool> too_dear(const Pass& spec) const;
  std::vector<double> shares_of_pass(const std::vector<bool>& left_out) const;

  LayerStudyOptions options_;
  std::string name_;
  render::Scene scene_;
  render::Dataset dataset_;
  bool use_hierarchy_;
  int antialiasing_;
  DataForms forms_;
  FieldValues field_;
  std::vector<Variant> variants_;
  std::optional<PassResult> result_;
  /// Of the last pass's size.
  std::map<SampledEffect, std::shared_ptr<const TruePicture>> many_samples_;
  render::RenderContext memory_;
  render::Framebuffer picture_;  ///< for pictures that are timed
};

}  // namespace rhoray::tools
