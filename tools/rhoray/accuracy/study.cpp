#include "tools/rhoray/accuracy/study.h"

#include <algorithm>
#include <numeric>

#include "formats/base/trouble.h"
#include "tools/rhoray/cpu_meter.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/method_words.h"

namespace rhoray::tools {

namespace {

bool is_exact(const Variant& variant) {
  return variant.method && variant.method->way == render::Method::Way::judged;
}

render::Layer layer_alone(const ScenePlan& plan, std::size_t layer) {
  render::Layer alone = plan.scene.layers[layer];
  alone.volume = 0;
  return alone;
}

std::string name_of_layer(const ScenePlan& plan, std::size_t index) {
  const render::Layer& layer = plan.scene.layers[index];
  const std::string field = plan.volumes[layer.volume].field().name;
  if (layer.mode == render::Mode::mip) return concat("largest values of '", field, "'");
  return concat("isosurface ", rounded(layer.isovalue, 6), " of '", field, "'");
}

double pixels_of(const PictureSize& size) {
  return static_cast<double>(size.width) * static_cast<double>(size.height);
}

}  // namespace

LayerStudy::LayerStudy(const ScenePlan& plan, std::size_t layer, LayerStudyOptions options)
    : options_(std::move(options)),
      name_(name_of_layer(plan, layer)),
      scene_(plan.scene),
      volume_(plan.volumes[plan.scene.layers[layer].volume]),
      use_hierarchy_(plan.frame.use_hierarchy),
      forms_(volume_),
      field_(volume_) {
  scene_.layers = {layer_alone(plan, layer)};
  variants_ = variants_of(scene_, volume_);
}

render::FrameStatistics LayerStudy::draw(const Variant& variant, const PictureSize& size,
                                         const render::ChannelSet& channels, render::Framebuffer& picture) {
  const FormedData& data = forms_.get(variant.data, options_.forms);
  render::Scene scene = scene_;
  render::Layer& layer = scene.layers[0];
  const bool is_copy = variant.data.kind != DataForm::Kind::original;
  layer.isovalue = data.own(layer.isovalue);
  layer.window = {data.own(layer.window.lo), data.own(layer.window.hi)};
  layer.method = variant.method.value_or(render::default_method(data.volume, layer.mode));
  if (variant.normals) layer.surface.normals = *variant.normals;
  if (is_copy) layer.surface.color_by.reset(), layer.surface.normals = render::Normals::exact;
  if (variant.occlusion_samples != 0) scene.occlusion.samples = variant.occlusion_samples;
  const render::FrameOptions frame{.width = std::max(1, size.width / variant.shrink),
                                   .height = std::max(1, size.height / variant.shrink),
                                   .channels = channels,
                                   .threads = options_.threads,
                                   .use_hierarchy = use_hierarchy_};
  const render::FrameStatistics statistics =
      render::refine(data.volume, scene, frame, {.first_spacing = 1, .stop = options_.stop}, picture, memory_);
  if (options_.stop.stop_requested()) throw Error(Trouble::interrupted, "interrupted");
  return statistics;
}

void LayerStudy::draw_truth(PassResult& result) {
  // A maximum in tetrahedra is certified by the judge, which has just been found too slow.
  const bool is_slow = volume_.is_mesh() && scene_.layers[0].mode == render::Mode::mip;
  const render::Accuracy level = result.truth.are_all() ? render::Accuracy::exact
                                 : is_slow              ? render::Accuracy::twofold
                                                        : render::Accuracy::certified;
  const Variant variant{.method = render::method_of(level)};
  result.picture_method = option_of(*variant.method, scene_.layers[0].mode, volume_.is_mesh()).word;
  render::Framebuffer picture;
  draw(variant, result.size, {.normal = true}, picture);
  result.true_picture = std::make_shared<TruePicture>(std::move(picture));
}

const TruePicture& LayerStudy::compared_with(const Variant& variant, const PassResult& result) {
  if (variant.occlusion_samples == 0) return *result.true_picture;
  if (!many_occlusion_rays_ || many_occlusion_rays_->picture().width != result.size.width) {
    Variant many = variant;
    many.occlusion_samples = most_occlusion_samples;
    render::Framebuffer picture;
    draw(many, result.size, {.normal = true}, picture);
    many_occlusion_rays_ = std::make_shared<TruePicture>(std::move(picture));
  }
  return *many_occlusion_rays_;
}

void LayerStudy::ask_rays(Measured& row, const FormedData& data, const PassResult& result) {
  const render::Layer& layer = scene_.layers[0];
  const std::vector<render::Ray> rays = rays_of(data.volume, scene_.camera, result.size, result.truth.pixels);
  std::vector<render::Hit> hits =
      answers({.volume = data.volume,
               .mode = layer.mode,
               .isovalue = data.own(layer.isovalue),
               .method = row.variant.method.value_or(render::default_method(data.volume, layer.mode)),
               .threads = options_.threads,
               .stop = options_.stop},
              rays);
  for (render::Hit& hit : hits) hit.value = data.original(hit.value);
  ErrorList list = errors_against(result.truth, field_, layer, hits);
  row.errors = count_errors(list);
  row.error_list = std::move(list.errors);
}

void LayerStudy::measure(Measured& row, const PassResult& result) {
  const Variant& variant = row.variant;
  const render::Layer& layer = scene_.layers[0];
  const FormedData& data = forms_.get(variant.data, options_.forms);
  row.preprocess_s = data.preprocess_s;
  row.data_bytes = data.file_bytes;
  row.method = option_of(variant.method.value_or(render::default_method(data.volume, layer.mode)), layer.mode,
                         data.volume.is_mesh())
                   .word;
  if (is_exact(variant)) return measure_exact(row, result);
  if (variant.asks_rays()) ask_rays(row, data, result);
  const bool is_recolored = layer.surface.color_by && variant.data.kind != DataForm::Kind::original;
  render::Framebuffer picture;
  const bool is_same_size = variant.shrink == 1;
  row.prepare_ms = 1e3 * draw(variant, result.size, {.normal = is_same_size}, picture).preparation_s;
  if (!is_same_size) picture = enlarged(picture, result.size.width, result.size.height);
  if (is_recolored)
    row.note = "the copy holds no field that colours it: pictures are not compared";
  else
    row.picture_errors = compared_with(variant, result).against(picture);
  if (variant.has_picture) {
    picture.keep({});
    row.picture = std::move(picture);
  }
  time(row, result.size);
}

/// Of what is true by definition: only what it takes.
void LayerStudy::measure_exact(Measured& row, const PassResult& result) {
  ErrorList list = errors_against(result.truth, field_, scene_.layers[0], result.truth.hits);
  row.errors = count_errors(list);
  row.error_list = std::move(list.errors);
  if (result.truth.are_all()) {
    row.picture_errors = result.true_picture->against(result.true_picture->picture());
    return time(row, result.size);
  }
  const double share = static_cast<double>(result.truth.pixels.size()) / pixels_of(result.size);
  row.cpu_ms = {1e3 * result.truth.cpu_s / share};
  row.note = "its time is that of the judged pixels, taken for all";
}

void LayerStudy::time(Measured& row, const PictureSize& size) {
  CpuMeter meter;
  double wall_s = 0;
  const Cost cost = meter.measure([&] { wall_s = draw(row.variant, size, {}, picture_).wall_s; });
  row.cpu_ms.push_back(1e3 * cost.cpu_s);
  row.wall_ms.push_back(1e3 * wall_s);
}

Measured LayerStudy::measured(const Variant& variant, const PassResult& result) {
  const Stopwatch watch;
  Measured row{.variant = variant};
  try {
    measure(row, result);
  } catch (const Error& error) {
    if (error.trouble() != Trouble::unsupported && error.trouble() != Trouble::resource) throw;
    row = {.variant = variant, .left_out = error.what()};
  }
  row.pass_s = std::max(0.0, watch.seconds() - row.preprocess_s);
  return row;
}

/// By what the last pass took for each, in the order from the cheapest.
std::vector<bool> LayerStudy::too_dear(const Pass& wish) const {
  std::vector<bool> left_out(variants_.size(), false);
  if (!result_) return left_out;
  std::vector<std::size_t> order(variants_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return result_->rows[a].pass_s < result_->rows[b].pass_s; });
  double spent = 0;
  for (const std::size_t variant : order) {
    const Measured& row = result_->rows[variant];
    const double growth = pixels_of(wish.size) / pixels_of(result_->size);
    if (!is_exact(row.variant)) spent += row.pass_s * growth;  // its time is the truth's
    left_out[variant] = spent > wish.seconds && variant != 0;
  }
  return left_out;
}

namespace {

/// By the variant before, where both are samples at steps that are halved.
bool is_slow_group(const std::vector<Measured>& rows, const Variant& next, double seconds) {
  if (rows.empty() || seconds <= 0 || !next.method || next.method->way != render::Method::Way::sampled) return false;
  const Measured& last = rows.back();
  return last.variant.group == next.group && (!last.left_out.empty() || 2 * last.pass_s > seconds);
}

}  // namespace

void LayerStudy::pass(const Pass& wish) {
  const render::Layer& layer = scene_.layers[0];
  PassResult result{.size = wish.size,
                    .truth = find_truth({.volume = volume_,
                                         .layer = layer,
                                         .camera = scene_.camera,
                                         .field = field_,
                                         .size = wish.size,
                                         .seed = options_.seed,
                                         .seconds = wish.judge_seconds,
                                         .threads = options_.threads,
                                         .stop = options_.stop})};
  if (result.truth.hit_count() == 0)
    throw Error(Trouble::usage,
                concat(name_, ": none of ", grouped(result.truth.pixels.size()),
                       " rays meets anything: there is nothing to compare"),
                "give another --iso, --view or --camera-position");
  draw_truth(result);
  const std::vector<bool> left_out = too_dear(wish);
  const bool is_first = !result_;
  if (is_first) result_ = std::move(result);
  PassResult& now = is_first ? *result_ : result;
  for (std::size_t v = 0; v < variants_.size(); ++v) {
    if (left_out[v] || is_slow_group(now.rows, variants_[v], wish.variant_seconds))
      now.rows.push_back({.variant = variants_[v], .left_out = "too slow for the time limit"});
    else
      now.rows.push_back(measured(variants_[v], now));
    if (wish.variant_done) wish.variant_done(v + 1);
  }
  if (!is_first) result_ = std::move(result);
}

void LayerStudy::time_again(std::size_t row) {
  time(result_->rows[row], result_->size);
}

double LayerStudy::foreseen_s(std::size_t row) const {
  const Measured& measured = result_->rows[row];
  return measured.wall_ms.empty() ? 0 : 1e-3 * measured.wall_ms.back();
}

}  // namespace rhoray::tools
