
#include <algorithm>
#include <cmath>
#include <random>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/number_text.h"
#include "render/accuracy.h"
#include "render/method_words.h"
#include "render/truth.h"

namespace rhoray::render {

namespace {

bool is_projection(const ResolvedScene& resolved) {
  return resolved.scene.layers[0].mode == Mode::mip;
}

bool is_proven(const ResolvedScene& resolved) {
  return std::all_of(resolved.scene.layers.begin(), resolved.scene.layers.end(),
                     [](const Layer& layer) { return proves(layer.method); });
}

/// What a level promises for a picture.
struct Promise {
  std::string said;        ///< empty: nothing
  double wrong_share = 1;  ///< allowed missed and false pixels, besides one pixel
  double kept = HUGE_VAL;  ///< error of 99 % of the pixels, in the unit of errors
};

Promise promise_of(const Layer& layer, const Dataset& dataset) {
  using Algorithm = Method::Algorithm;
  const Interval<double> range = dataset.field().range;
  const double unit = layer.mode == Mode::mip ? 1e-6 * (range.hi - range.lo) : 1;
  if (proves(layer.method)) return {"no false negatives or false positives, every error within its bound", 0, HUGE_VAL};
  if (layer.method.algorithm != Algorithm::direct) return {};
  if (layer.mode == Mode::mip)
    return {"no false negatives or false positives, 99 % of the values within a millionth of the field's range", 0,
            unit};
  if (layer.method.precision == Method::Precision::float64)
    return {"false negatives and false positives at most 0.1 % + 1 pixel, 99 % within 1e-6 cells", 1e-3, 1e-6};
  return {"false negatives and false positives at most 1 % + 1 pixel, 99 % within 1e-3 cells", 1e-2, 1e-3};
}

/// The loosest promise of all layers.
Promise promise_of(const ResolvedScene& resolved) {
  Promise loosest{.said = "", .wrong_share = -1, .kept = 0};
  for (const Layer& layer : resolved.scene.layers) {
    const Promise promise = promise_of(layer, resolved.datasets[layer.dataset]);
    if (promise.said.empty()) return promise;
    if (promise.wrong_share > loosest.wrong_share) loosest = promise;
  }
  return loosest;
}

std::vector<std::uint32_t> some_of(std::vector<std::uint32_t> pixels, std::uint64_t count, std::mt19937_64& random) {
  const std::size_t taken = std::min<std::size_t>(pixels.size(), count);
  for (std::size_t i = 0; i < taken; ++i) std::swap(pixels[i], pixels[i + random() % (pixels.size() - i)]);
  pixels.resize(taken);
  std::sort(pixels.begin(), pixels.end());
  return pixels;
}

std::vector<std::uint32_t> all_pixels(const Framebuffer& picture) {
  std::vector<std::uint32_t> pixels(picture.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint32_t>(i);
  return pixels;
}

/// Pixels with a neighbour whose depth differs by more than a hundredth. Pixels with a surface
/// differ from pixels without.
std::vector<std::uint32_t> edge_pixels(const Framebuffer& picture) {
  std::vector<std::uint32_t> edges;
  const auto width = static_cast<std::size_t>(picture.width);
  const auto differ = [&](std::size_t a, std::size_t b) {
    const float p = picture.depth[a], q = picture.depth[b];
    if (std::isinf(p) || std::isinf(q)) return std::isinf(p) != std::isinf(q);
    return std::abs(p - q) > 0.01F * std::min(p, q);
  };
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) {
    const bool has_right = pixel % width + 1 < width, has_below = pixel + width < picture.pixel_count();
    const bool has_left = pixel % width > 0, has_above = pixel >= width;
    if ((has_right && differ(pixel, pixel + 1)) || (has_below && differ(pixel, pixel + width)) ||
        (has_left && differ(pixel, pixel - 1)) || (has_above && differ(pixel, pixel - width)))
      edges.push_back(static_cast<std::uint32_t>(pixel));
  }
  return edges;
}

/// The true hit of a pixel: that of the nearest layer.
struct TrueHit {
  Hit hit;
  double cells_per_t = 0;
  double value_per_t = 0;  ///< slope of the field along the ray
};

std::vector<TrueHit> true_hits(const ResolvedScene& resolved, const Framebuffer& picture,
                               const std::vector<std::uint32_t>& pixels, unsigned threads, const Watch& watch) {
  std::vector<TrueHit> nearest(pixels.size());
  for (const Layer& layer : resolved.scene.layers) {
    const Dataset& dataset = resolved.datasets[layer.dataset];
    const CellLengths lengths(dataset);
    const std::vector<Ray> rays = camera_rays(dataset, resolved.scene.camera, picture.width, picture.height, pixels);
    const std::vector<Hit> hits = trace_rays({.dataset = dataset,
                                              .mode = layer.mode,
                                              .isovalue = layer.isovalue,
                                              .method = method_of(Accuracy::exact),
                                              .clip = clip_of(resolved.scene, layer),
                                              .threads = threads,
                                              .watch = watch},
                                             rays);
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (!hits[i].is_miss() && hits[i].t < nearest[i].hit.t)
        nearest[i] = {hits[i], layer.mode == Mode::mip ? 0 : lengths.cells_per_t(rays[i], hits[i]),
                      std::abs(hits[i].gradient.dot(rays[i].direction))};
  }
  return nearest;
}

CheckedPixels checked_pixels(const ResolvedScene& resolved, const Framebuffer& picture,
                             const std::vector<std::uint32_t>& pixels, double limit, unsigned threads,
                             const Watch& watch) {
  const bool is_value = is_projection(resolved);
  const std::vector<TrueHit> truth = true_hits(resolved, picture, pixels, threads, watch);
  CheckedPixels found{.pixels = pixels.size()};
  ErrorList list;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint32_t pixel = pixels[i];
    const TrueHit& is = truth[i];
    const bool is_shown = is_value ? !std::isnan(picture.value[pixel]) : std::isfinite(picture.depth[pixel]);
    if (!is_shown || is.hit.is_miss()) {
      list.errors.push_back(!is_shown && is.hit.is_miss() ? nothing_there : is_shown ? is_false : is_missed);
      continue;
    }
    const double depth = is_value ? 0 : static_cast<double>(picture.depth[pixel]);
    const double rounding = 0x1.01p-24 * depth;  // half a step of single precision
    const double off =
        is_value ? std::abs(picture.value[pixel] - is.hit.value) : std::max(0.0, std::abs(depth - is.hit.t) - rounding);
    const double bound = picture.error.empty() ? HUGE_VAL : 1.001 * static_cast<double>(picture.error[pixel]);
    found.beyond_bound += !(off <= bound + is.hit.error);
    found.largest_value_error = std::max(found.largest_value_error, is_value ? off : off * is.value_per_t);
    list.errors.push_back(static_cast<float>(is_value ? off : off * is.cells_per_t));
  }
  const ErrorCounts counts = count_errors(list);
  found.missed = counts.missed;
  found.false_hits = counts.false_hits;
  found.shown = counts.true_hits + counts.false_hits;
  found.beyond_limit = counts.beyond(limit);
  found.kept_by_99 = counts.kept_by(0.99);
  found.largest = counts.error ? counts.error->largest : 0;
  return found;
}

/// Empty unless the examined pixels show that fewer than 99 % of all pixels are within the limit.
std::string limit_broken_by(const CheckedPixels& found, double limit, const char* which) {
  if (!(share_of(found.beyond_limit, found.shown, false).low > 0.01)) return {};
  return concat(found.beyond_limit, " of ", found.shown, " ", which,
                " pixels that show or should show something are wrong or have an error above ", rounded(limit),
                ": more than 1 % at a confidence of 97.5 %");
}

std::string broken_by(const CheckedPixels& found, const Promise& promise, bool is_proven, const char* which) {
  const double wrong = static_cast<double>(found.missed + found.false_hits);
  const double allowed = promise.wrong_share > 0 ? 1 + promise.wrong_share * static_cast<double>(found.pixels) : 0;
  std::string text;
  const auto add = [&](const std::string& more) { text += concat(text.empty() || more.empty() ? "" : "; ", more); };
  if (wrong > allowed)
    add(concat(counted(found.missed, "false negative", "false negatives"), " and ",
               counted(found.false_hits, "false positive", "false positives"), " in ", found.pixels, " ", which,
               " pixels"));
  if (is_proven && found.beyond_bound > 0) add(concat(found.beyond_bound, " ", which, " pixels beyond their bound"));
  if (wrong <= allowed && std::isfinite(promise.kept)) add(limit_broken_by(found, promise.kept, which));
  return text;
}

/// The requested limit, in the unit of errors.
double limit_in_unit(const ResolvedScene& resolved, double limit) {
  const Interval<double> range = resolved.datasets[resolved.scene.layers[0].dataset].field().range;
  return is_projection(resolved) ? limit * (range.hi - range.lo) : limit;
}

}  // namespace

ChannelSet channels_to_check(const ResolvedScene& resolved) {
  return {.depth = true, .value = true, .error = is_proven(resolved)};
}

std::string why_not_checkable(const ResolvedScene& resolved) {
  const std::vector<Layer>& layers = resolved.scene.layers;
  constexpr const char* expected = "; expected isosurfaces or one projection";
  for (const Layer& layer : layers) {
    if (layer.mode == Mode::triangles) return concat("a layer holds triangles", expected);
    if (layer.mode == Mode::slice) return concat("a layer is a slice", expected);
    if (layer.mode == Mode::mip && layers.size() > 1) return concat("a projection beside other layers", expected);
    if (layer.mode == Mode::isosurface && layers.size() > 1 && layer.material.opacity < 1)
      return "a transparent surface beside other layers; expected opaque isosurfaces";
  }
  return {};
}

SelfCheck check_picture(const ResolvedScene& resolved, const Framebuffer& picture, const SelfCheckOptions& options,
                        unsigned threads) {
  const DefaultFloatingPoint default_floating_point;
  std::mt19937_64 random(options.seed);
  SelfCheck check{.seed = options.seed, .unit = is_projection(resolved) ? "" : "cells"};
  const Promise promise = promise_of(resolved);
  const double limit = options.limit ? limit_in_unit(resolved, *options.limit) : promise.kept;
  const auto look_at = [&](const std::vector<std::uint32_t>& pixels) {
    return checked_pixels(resolved, picture, some_of(pixels, options.pixels, random), limit, threads, options.watch);
  };
  check.random = look_at(all_pixels(picture));
  check.edges = look_at(edge_pixels(picture));
  const auto hold = [&](const std::string& broken) {
    check.broken += concat(check.broken.empty() || broken.empty() ? "" : "; ", broken);
  };
  const bool holds_promise = !options.limit || is_proven(resolved);
  if (holds_promise && !promise.said.empty()) {
    check.limit = promise.said;
    hold(broken_by(check.random, promise, is_proven(resolved), "random"));
    hold(broken_by(check.edges, {promise.said, promise.wrong_share * 10, HUGE_VAL}, is_proven(resolved), "edge"));
  }
  if (options.limit) {
    check.limit += concat(check.limit.empty() ? "" : "; ", "99 % within ", *options.limit,
                          is_projection(resolved) ? " of the field's range" : " cells");
    hold(limit_broken_by(check.random, limit, "random"));
  }
  return check;
}

}  // namespace rhoray::render
