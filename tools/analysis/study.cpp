#include "tools/analysis/study.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <span>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/stopping.h"
#include "render/method_words.h"
#include "render/scene_spec.h"
#include "tools/analysis/cpu_meter.h"
#include "tools/analysis/measure.h"

namespace rhoray::tools {

namespace {

bool is_exact(const Variant& variant) {
  return variant.method && variant.method->algorithm == render::Method::Algorithm::exact;
}

render::Layer layer_alone(const render::ResolvedScene& plan, std::size_t layer) {
  render::Layer alone = plan.scene.layers[layer];
  alone.dataset = 0;
  return alone;
}

std::string name_of_layer(const render::ResolvedScene& plan, std::size_t index) {
  const render::Layer& layer = plan.scene.layers[index];
  const std::string field = plan.datasets[layer.dataset].field().name;
  if (layer.mode == render::Mode::mip) return concat("largest values of '", field, "'");
  return concat("isosurface ", rounded(layer.isovalue, 6), " of '", field, "'");
}

double pixels_of(const render::PictureSize& size) {
  return static_cast<double>(size.width) * static_cast<double>(size.height);
}

}  // namespace

LayerStudy::LayerStudy(const render::ResolvedScene& plan, std::size_t layer, LayerStudyOptions options)
    : options_(std::move(options)),
      name_(name_of_layer(plan, layer)),
      scene_(plan.scene),
      dataset_(plan.datasets[plan.scene.layers[layer].dataset]),
      use_hierarchy_(plan.frame.use_hierarchy),
      antialiasing_(plan.frame.antialiasing),
      forms_(dataset_),
      field_(dataset_) {
  scene_.layers = {layer_alone(plan, layer)};
  variants_ = variants_of(scene_, dataset_, antialiasing_);
}

LayerStudy::Setup LayerStudy::setup(const Variant& variant, const render::PictureSize& size,
                                    const render::ChannelSet& channels) {
  Setup made{.data = forms_.get(variant.data, options_.forms),
             .scene = scene_,
             .frame = {.width = std::max(1, size.width / variant.shrink),
                       .height = std::max(1, size.height / variant.shrink),
                       .channels = channels,
                       .threads = options_.threads,
                       .use_hierarchy = use_hierarchy_}};
  const FormedData& data = made.data;
  render::Layer& layer = made.scene.layers[0];
  layer.isovalue = data.own(layer.isovalue);
  layer.window = {data.own(layer.window.lo), data.own(layer.window.hi)};
  layer.method = variant.method.value_or(render::default_method(data.dataset, layer.mode));
  if (variant.normals) layer.material.normals = *variant.normals;
  if (variant.data.kind != DataForm::Kind::original) layer.material.color_by.reset();
  if (variant.effect == SampledEffect::occlusion) made.scene.occlusion.samples = variant.samples;
  if (variant.effect == SampledEffect::edges) made.frame.antialiasing = variant.samples;
  if (variant.effect == SampledEffect::soft_shadows)
    for (render::Light& light : made.scene.lights)
      if (is_soft(light)) light.samples = variant.samples;
  return made;
}

render::FrameStatistics LayerStudy::draw(const Variant& variant, const render::PictureSize& size,
                                         const render::ChannelSet& channels, render::Framebuffer& picture) {
  const Setup drawn = setup(variant, size, channels);
  const render::FrameStatistics statistics = render::refine(
      drawn.data.dataset, drawn.scene, drawn.frame, {.first_spacing = 1, .watch = options_.stop}, picture, memory_);
  end_if_stopped(options_.stop);
  return statistics;
}

void LayerStudy::draw_truth(PassResult& result) {
  // A maximum in tetrahedra is certified by exact arithmetic, which has just proved too slow.
  const bool is_slow = dataset_.is_mesh() && scene_.layers[0].mode == render::Mode::mip;
  const render::Accuracy level = result.truth.are_all() ? render::Accuracy::exact
                                 : is_slow              ? render::Accuracy::float64
                                                        : render::Accuracy::certified;
  const Variant variant{.method = render::method_of(level)};
  result.picture_method = option_of(*variant.method, scene_.layers[0].mode, dataset_.is_mesh()).word;
  render::Framebuffer picture;
  draw(variant, result.size, {.normal = true}, picture);
  result.true_picture = std::make_shared<TruePicture>(std::move(picture));
}

const TruePicture& LayerStudy::compared_with(const Variant& variant, const PassResult& result) {
  if (variant.effect == SampledEffect::none) return *result.true_picture;
  std::shared_ptr<const TruePicture>& many = many_samples_[variant.effect];
  if (!many || many->picture().width != result.size.width || many->picture().height != result.size.height) {
    Variant most = variant;
    most.samples = most_samples(variant.effect);
    render::Framebuffer picture;
    draw(most, result.size, {.normal = true}, picture);
    many = std::make_shared<TruePicture>(std::move(picture));
  }
  return *many;
}

void LayerStudy::ask_rays(Measured& row, const FormedData& data, const PassResult& result) {
  const render::Layer& layer = scene_.layers[0];
  const std::vector<render::Ray> rays =
      render::camera_rays(data.dataset, scene_.camera, result.size.width, result.size.height, result.truth.pixels);
  std::vector<render::Hit> hits =
      render::trace_rays({.dataset = data.dataset,
                          .mode = layer.mode,
                          .isovalue = data.own(layer.isovalue),
                          .method = row.variant.method.value_or(render::default_method(data.dataset, layer.mode)),
                          .clip = render::clip_of(scene_, layer),
                          .threads = options_.threads,
                          .watch = options_.stop},
                         rays);
  for (render::Hit& hit : hits) hit.value = data.original(hit.value);
  render::ErrorList list = errors_on_data(result.truth, field_, layer, hits, data.border.get());
  row.errors = render::count_errors(list);
  row.judges_all = result.truth.are_all();
  row.error_list = std::move(list.errors);
}

void LayerStudy::measure(Measured& row, const PassResult& result) {
  const Variant& variant = row.variant;
  const render::Layer& layer = scene_.layers[0];
  const FormedData& data = forms_.get(variant.data, options_.forms);
  row.preprocess_s = data.preprocess_s;
  row.data_bytes = data.file_bytes;
  row.method = option_of(variant.method.value_or(render::default_method(data.dataset, layer.mode)), layer.mode,
                         data.dataset.is_mesh())
                   .word;
  if (is_exact(variant)) return measure_exact(row, result);
  if (variant.asks_rays()) ask_rays(row, data, result);
  const bool is_recolored = layer.material.color_by && variant.data.kind != DataForm::Kind::original;
  render::Framebuffer picture;
  const bool is_same_size = variant.shrink == 1;
  draw(variant, result.size, {.normal = is_same_size}, picture);
  if (!is_same_size) picture = enlarged(picture, result.size.width, result.size.height);
  if (is_recolored)
    row.note = "the copy has no field to colour it; pictures are not compared";
  else
    row.picture_errors = compared_with(variant, result).against(picture);
  if (variant.has_picture) {
    picture.keep({});
    row.picture = std::move(picture);
  }
  if (row.picture_errors && (!variant.has_picture || row.errors)) row.picture_errors->flip_map.clear();
  time(row, result.size);
}

/// Loads the data anew and renders, as a new user would. Measures the preparation time and the
/// memory kept.
void LayerStudy::weigh(Measured& row) {
  Setup drawn = setup(row.variant, {32, 24}, {});
  ::malloc_trim(0);
  const std::uint64_t before = anonymous_bytes();
  const render::Dataset dataset =
      render::Dataset::load(drawn.data.dataset.file(), drawn.data.dataset.field().name, drawn.data.dataset.space());
  render::RenderContext memory;
  render::Framebuffer picture;
  row.prepare_ms = 1e3 * render::render(dataset, drawn.scene, drawn.frame, picture, memory).preparation_s;
  ::malloc_trim(0);
  const std::uint64_t after = anonymous_bytes();
  row.memory_bytes = dataset.file().file_bytes() + (after > before ? after - before : 0);
}

InstrumentCost LayerStudy::instrument_cost(double seconds) {
  const Variant plain{};
  const Setup drawn = setup(plain, result_->size, {});
  constexpr std::size_t least_rounds = 3, most_rounds = 200;
  const Stopwatch watch;
  CpuMeter meter, inner;
  const auto bare = [&] { render::render(drawn.data.dataset, drawn.scene, drawn.frame, picture_, memory_); };
  std::vector<double> without, with, again;
  while (with.size() < least_rounds || (with.size() < most_rounds && watch.seconds() < seconds)) {
    without.push_back(meter.measure(bare).cpu_s);
    with.push_back(meter.measure([&] { inner.measure([&] { draw(plain, result_->size, {}, picture_); }); }).cpu_s);
    again.push_back(meter.measure(bare).cpu_s);
  }
  const double least = spread_of(without).smallest;
  return {.share = spread_of(with).smallest / least - 1,
          .noise = std::abs(spread_of(again).smallest / least - 1),
          .pictures = static_cast<int>(with.size())};
}

/// For the variant that is true by definition: measures only its cost.
void LayerStudy::measure_exact(Measured& row, const PassResult& result) {
  render::ErrorList list = errors_on_data(result.truth, field_, scene_.layers[0], result.truth.hits);
  row.errors = render::count_errors(list);
  row.judges_all = result.truth.are_all();
  row.error_list = std::move(list.errors);
  if (result.truth.are_all()) {
    row.picture_errors = result.true_picture->against(result.true_picture->picture());
    return time(row, result.size);
  }
  const double share = static_cast<double>(result.truth.pixels.size()) / pixels_of(result.size);
  row.cpu_ms = {1e3 * result.truth.cpu_s / share};
  row.note = "time extrapolated from the judged pixels";
}

void LayerStudy::time(Measured& row, const render::PictureSize& size) {
  CpuMeter meter;
  double wall_s = 0;
  const Cost cost = meter.measure([&] { wall_s = draw(row.variant, size, {}, picture_).wall_s; });
  row.cpu_ms.push_back(1e3 * cost.cpu_s);
  row.wall_ms.push_back(1e3 * wall_s);
}

Measured LayerStudy::measured(const Variant& variant, const PassResult& result) {
  Stopwatch watch;
  Measured row{.variant = variant};
  try {
    forms_.get(variant.data, options_.forms);
    watch = {};  // a copy is made once and does not count for the variant
    measure(row, result);
    weigh(row);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::unsupported && error.code() != ErrorCode::resource) throw;
    row = {.variant = variant, .left_out = error.what()};
  }
  row.pass_s = watch.seconds();
  return row;
}

/// Traces random rays of the truth until the time is over.
Measured LayerStudy::measured_in_part(const Variant& variant, const PassResult& result, double seconds) {
  const render::Layer& layer = scene_.layers[0];
  const render::Truth& truth = result.truth;
  std::vector<std::size_t> order(truth.rays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937_64 random(options_.seed);
  // Each later one is as large as all before, so that the overhead of tracing is shared.
  constexpr std::size_t first_piece = 512;
  render::Truth part{.size = truth.size};
  std::vector<render::Hit> said;
  double cpu_s = 0;
  CpuMeter meter;
  const Stopwatch watch;
  while (said.empty() || (said.size() < order.size() && watch.seconds() < seconds)) {
    const std::size_t first = said.size(), end = std::min(order.size(), first + std::max(first, first_piece));
    for (std::size_t i = first; i < end; ++i) {
      std::swap(order[i], order[i + random() % (order.size() - i)]);
      part.pixels.push_back(truth.pixels[order[i]]);
      part.rays.push_back(truth.rays[order[i]]);
      part.hits.push_back(truth.hits[order[i]]);
      part.cells_per_t.push_back(truth.cells_per_t[order[i]]);
    }
    const render::TraceSpec spec{.dataset = dataset_,
                                 .mode = layer.mode,
                                 .isovalue = layer.isovalue,
                                 .method = *variant.method,
                                 .clip = render::clip_of(scene_, layer),
                                 .threads = options_.threads,
                                 .watch = options_.stop};
    std::vector<render::Hit> found;
    cpu_s += meter.measure([&] { found = render::trace_rays(spec, std::span(part.rays).subspan(first)); }).cpu_s;
    said.insert(said.end(), found.begin(), found.end());
  }
  Measured row{.variant = variant, .method = option_of(*variant.method, layer.mode, dataset_.is_mesh()).word};
  row.errors = render::count_errors(errors_on_data(part, field_, layer, said));
  row.cpu_ms = {1e3 * cpu_s / static_cast<double>(said.size()) * pixels_of(result.size)};
  row.data_bytes = dataset_.file().file_bytes();
  row.note = concat("too slow for a picture; ", said.size(), " random pixels, with the time extrapolated");
  row.pass_s = 3e-3 * row.cpu_ms[0];  // that whole pictures would take
  return row;
}

/// Selects by the times of the last pass, from the cheapest variant on.
std::vector<bool> LayerStudy::too_dear(const Pass& spec) const {
  std::vector<bool> left_out(variants_.size(), false);
  if (!result_) return left_out;
  std::vector<std::size_t> order(variants_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return result_->rows[a].pass_s < result_->rows[b].pass_s; });
  double spent = 0;
  for (const std::size_t variant : order) {
    const Measured& row = result_->rows[variant];
    const double growth = pixels_of(spec.size) / pixels_of(result_->size);
    if (!is_exact(row.variant)) spent += row.pass_s * growth;  // its time is the truth's
    left_out[variant] = spent > spec.seconds && variant != 0 && !is_exact(row.variant);
  }
  return left_out;
}

namespace {

/// Judged by the variant before, if both are sampled and the step is halved.
bool is_slow_group(const std::vector<Measured>& rows, const Variant& next, double seconds) {
  if (rows.empty() || seconds <= 0 || !next.method || next.method->algorithm != render::Method::Algorithm::sampled)
    return false;
  const Measured& last = rows.back();
  return last.variant.group == next.group && (!last.left_out.empty() || 2 * last.pass_s > seconds);
}

}  // namespace

/// The share of a pass that is completed after each variant.
std::vector<double> LayerStudy::shares_of_pass(const std::vector<bool>& left_out) const {
  const bool knows_times = result_ && result_->rows.size() == variants_.size();
  std::vector<double> shares;
  double done = 0;
  for (std::size_t v = 0; v < variants_.size(); ++v) {
    const bool is_drawn = !left_out[v] && !(knows_times && result_->rows[v].wall_ms.empty());
    shares.push_back(done += !is_drawn ? 0 : knows_times ? result_->rows[v].pass_s + 1e-6 : 1);
  }
  for (double& share : shares) share /= std::max(1e-6, done);
  return shares;
}

void LayerStudy::pass(const Pass& spec) {
  PassResult result{.size = spec.size,
                    .truth = render::find_truth({.dataset = dataset_,
                                                 .scene = scene_,
                                                 .size = spec.size,
                                                 .seed = options_.seed,
                                                 .seconds = spec.judge_seconds,
                                                 .threads = options_.threads,
                                                 .watch = options_.stop})};
  if (result.truth.hit_count() == 0)
    throw Error(ErrorCode::usage,
                concat(name_, ": none of ", grouped(result.truth.pixels.size()),
                       " rays hits anything; there is nothing to compare"),
                "choose another --iso, --view or --camera-position");
  draw_truth(result);
  const std::vector<bool> left_out = too_dear(spec);
  const bool is_first = !result_;
  if (is_first) result_ = std::move(result);
  PassResult& now = is_first ? *result_ : result;
  const std::vector<double> shares = shares_of_pass(left_out);
  for (std::size_t v = 0; v < variants_.size(); ++v) {
    const Variant& variant = variants_[v];
    const bool is_slow = left_out[v] || is_slow_group(now.rows, variant, spec.variant_seconds);
    const bool is_ray_method = variant.method && variant.asks_rays() && !is_exact(variant);
    if (!is_slow)
      now.rows.push_back(measured(variant, now));
    else if (is_ray_method && spec.part_seconds > 0)
      now.rows.push_back(measured_in_part(variant, now, spec.part_seconds));
    else
      now.rows.push_back({.variant = variant, .left_out = "too slow for the time limit"});
    if (spec.variant_done) spec.variant_done(shares[v]);
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
