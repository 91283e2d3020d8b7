#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/render.h"
#include "tools/analysis/data_forms.h"
#include "tools/analysis/errors.h"
#include "tools/analysis/picture_errors.h"
#include "tools/analysis/truth.h"
#include "tools/analysis/variant.h"
#include "tools/rhoray/scene/resolve.h"

namespace rhoray::tools {

/// What was found out about a variant.
struct Measured {
  Variant variant;
  std::string method{};    ///< its word
  std::string left_out{};  ///< why nothing was found out; else empty
  std::string note{};
  std::optional<ErrorCounts> errors{};  ///< of variants that ask rays
  bool judges_all = false;              ///< errors are those of all pixels, not of a random sample
  std::vector<float> error_list{};      ///< of the truth's pixels (errors.h); empty where only some of them were asked
  std::optional<PictureErrors> picture_errors{};
  std::optional<render::Framebuffer> picture{};  ///< of variants that the report shows
  std::vector<double> cpu_ms{}, wall_ms{};  ///< of each time that the picture was drawn; without wall_ms that of some
                                            ///< pixels, taken for all
  double prepare_ms = 0;                    ///< what the first picture of an isovalue takes beside that
  double preprocess_s = 0;                  ///< to make the copy of the data
  std::uint64_t data_bytes = 0;             ///< of the file
  std::uint64_t memory_bytes = 0;           ///< that is mapped or kept to draw from; 0: not known
  double pass_s = 0;                        ///< that all of this took
};

/// What measuring adds to what is measured.
struct InstrumentCost {
  double share = 0;  ///< of the CPU time of a picture: the least with against the least without, which took turns
  double noise = 0;  ///< how far, in the same way, two series without them lie apart
  int pictures = 0;  ///< of each kind
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
  LayerStudy(const ResolvedScene& plan, std::size_t layer, LayerStudyOptions options);

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
    /// No picture is drawn by samples at a step where those at the last one, twice as far apart, took half of this; 0:
    /// by all.
    double variant_seconds = 0;
    /// Such samples are taken for random pixels only, so long. 0: not at all.
    double part_seconds = 0;
    /// @param share  of the pass that is done: by the time that the pass before took for each variant, else by their
    /// count
    std::function<void(double share)> variant_done = nullptr;
  };
  /// Refuses a picture in which nothing is hit (ErrorCode::usage). While the first pass goes on its result is what has
  /// been measured; later ones replace the result at their end, so that an interrupt leaves that of the pass before.
  void pass(const Pass& spec);

  /// Draws the picture of a row of the result once more and notes the time.
  void time_again(std::size_t row);
  double foreseen_s(std::size_t row) const;  ///< that this takes

  /// Draws the picture of the data's default method with what times it and lets an interrupt end it, and without, in
  /// turn.
  InstrumentCost instrument_cost(double seconds);

 private:
  /// What a variant draws, and from what.
  struct Setup {
    const FormedData& data;
    render::Scene scene;
    render::FrameOptions frame;
  };
  Setup setup(const Variant& variant, const PictureSize& size, const render::ChannelSet& channels);
  render::FrameStatistics draw(const Variant& variant, const PictureSize& size, const render::ChannelSet& channels,
                               render::Framebuffer& picture);
  void draw_truth(PassResult& result);
  const TruePicture& compared_with(const Variant& variant, const PassResult& result);
  Measured measured(const Variant& variant, const PassResult& result);
  Measured measured_in_part(const Variant& variant, const PassResult& result, double seconds);
  void measure(Measured& row, const PassResult& result);
  void measure_exact(Measured& row, const PassResult& result);
  void ask_rays(Measured& row, const FormedData& data, const PassResult& result);
  void time(Measured& row, const PictureSize& size);
  void weigh(Measured& row);
  std::vector<bool> too_dear(const Pass& spec) const;
  std::vector<double> shares_of_pass(const std::vector<bool>& left_out) const;

  LayerStudyOptions options_;
  std::string name_;
  render::Scene scene_;
  render::Volume volume_;
  bool use_hierarchy_;
  int antialiasing_;
  DataForms forms_;
  FieldTruth field_;
  std::vector<Variant> variants_;
  std::optional<PassResult> result_;
  std::map<SampledEffect, std::shared_ptr<const TruePicture>> many_samples_;  ///< of the last pass's size
  render::RenderContext memory_;
  render::Framebuffer picture_;  ///< of pictures that are timed
};

}  // namespace rhoray::tools
