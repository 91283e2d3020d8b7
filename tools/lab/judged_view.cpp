#include "tools/lab/judged_view.h"

#include <algorithm>
#include <cmath>

#include "formats/base/error.h"

namespace rhoray::study {

namespace {

/// A hit farther away than this is on another part of the surface.
constexpr float elsewhere_cells = 1;

void put(Json& row, const std::string& name, const std::string& unit,
         const std::optional<render::Quantiles>& quantiles) {
  const auto put_one = [&](const char* which, double render::Quantiles::*member) {
    row[concat(name, "_", which, unit)] = quantiles ? Json((*quantiles).*member) : Json(nullptr);
  };
  put_one("median", &render::Quantiles::median);
  put_one("p99", &render::Quantiles::p99);
  put_one("max", &render::Quantiles::largest);
}

render::Scene scene_of(const ViewSpec& setting) {
  render::Scene scene;
  scene.layers[0].isovalue = setting.isovalue;
  scene.camera = setting.camera;
  return scene;
}

}  // namespace

ExactView::ExactView(const render::Dataset& dataset, const ViewSpec& setting)
    : dataset_(dataset), setting_(setting), field_(dataset_), scene_(scene_of(setting_)) {
  truth_ = render::find_truth({.dataset = dataset_,
                               .scene = scene_,
                               .size = setting_.size,
                               .seed = setting_.seed,
                               .seconds = setting_.judge_seconds});
  if (truth_.hit_count() == 0)
    throw Error(ErrorCode::usage,
                concat("no pixel shows the isosurface ", setting_.isovalue, "; expected some to judge"));
  // If exact arithmetic could not decide all pixels in time, their picture is the certified one.
  const render::Accuracy level = truth_.are_all() ? render::Accuracy::exact : render::Accuracy::certified;
  render::Framebuffer picture;
  draw({.dataset = dataset_, .isovalue = setting_.isovalue, .method = render::method_of(level)}, {.normal = true}, 0,
       picture, memory_);
  picture_ = std::make_unique<tools::TruePicture>(std::move(picture));
}

ExactView::~ExactView() = default;

double ExactView::cell_length() const {
  std::vector<double> lengths;
  for (const double cells_per_t : truth_.cells_per_t)
    if (cells_per_t > 0) lengths.push_back(1 / cells_per_t);
  return render::quantiles_of(std::move(lengths)).value().median;
}

Json ExactView::ray_errors(const Shown& shown) const {
  const std::vector<render::Ray> rays =
      render::camera_rays(shown.dataset, setting_.camera, setting_.size.width, setting_.size.height, truth_.pixels);
  const std::vector<render::Hit> hits =
      render::trace_rays({.dataset = shown.dataset, .isovalue = shown.isovalue, .method = shown.method}, rays);
  const render::ErrorList list = tools::errors_on_data(truth_, field_, scene_.layers[0], hits, shown.border);
  const render::ErrorCounts errors = render::count_errors(list);
  std::vector<double> world;
  std::uint64_t wrong_at_border = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const bool is_border = !list.is_border.empty() && list.is_border[i] != 0;
    const float error = list.errors[i];
    wrong_at_border += is_border && (std::isinf(error) || error > elsewhere_cells);
    if (!hits[i].is_miss() && !truth_.hits[i].is_miss() && !is_border)
      world.push_back(std::abs(hits[i].t - truth_.hits[i].t));
  }
  const auto elsewhere = static_cast<std::uint64_t>(
      errors.sorted.end() - std::upper_bound(errors.sorted.begin(), errors.sorted.end(), elsewhere_cells));
  const auto ppm = [&](std::uint64_t count) {
    return 1e6 * static_cast<double>(count) / static_cast<double>(errors.rays);
  };
  Json row{{"judged_rays", errors.rays},       {"true_hits", errors.true_hits},
           {"missed", errors.missed},          {"false_hits", errors.false_hits},
           {"missed_ppm", ppm(errors.missed)}, {"false_ppm", ppm(errors.false_hits)},
           {"elsewhere", elsewhere},           {"wrong_ppm", ppm(errors.missed + errors.false_hits + elsewhere)}};
  const std::uint64_t wrong = errors.missed + errors.false_hits + elsewhere;
  row["border_wrong_ppm"] = shown.border != nullptr ? Json(ppm(wrong_at_border)) : Json(nullptr);
  row["sampling_wrong_ppm"] = shown.border != nullptr ? Json(ppm(wrong - wrong_at_border)) : Json(nullptr);
  put(row, "depth", "_cells", errors.error);
  const double kept = errors.kept_by(0.99);
  row["depth_kept_by_99_cells"] = std::isfinite(kept) ? Json(kept) : Json(nullptr);
  put(row, "depth", "_world", render::quantiles_of(std::move(world)));
  if (dataset_.is_mesh()) return row;
  std::optional<render::Quantiles> value = errors.value_error;
  const double range = dataset_.field().range.hi - dataset_.field().range.lo;
  if (value && range > 0) value->median /= range, value->p99 /= range, value->largest /= range;
  put(row, "value", "_of_range", value);
  return row;
}

Json ExactView::picture_errors(const Shown& shown) const {
  render::Framebuffer picture;
  render::RenderContext memory;
  draw(shown, {.normal = true}, 0, picture, memory);
  const tools::PictureErrors errors = picture_->against(picture);
  Json row;
  put(row, "normal", "_deg", errors.normal_deg);
  row["rmse_of_255"] = errors.rmse;
  row["flip"] = errors.flip;
  return row;
}

void ExactView::draw(const Shown& shown) {
  draw(shown, {}, 1, timed_, memory_);
}

render::FrameStatistics ExactView::draw(const Shown& shown, const render::ChannelSet& channels, unsigned threads,
                                        render::Framebuffer& picture, render::RenderContext& memory) const {
  render::Scene scene = scene_;
  scene.layers[0].isovalue = shown.isovalue;
  scene.layers[0].method = shown.method;
  return render::render(
      shown.dataset, scene,
      {.width = setting_.size.width, .height = setting_.size.height, .channels = channels, .threads = threads}, picture,
      memory);
}

}  // namespace rhoray::study
