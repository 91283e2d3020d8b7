#include "tools/analysis/self_check.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/number_text.h"
#include "render/method_words.h"
#include "tools/analysis/truth.h"

namespace rhoray::tools {

namespace {

using render::Hit;

bool is_projection(const render::ResolvedScene& plan) {
  return plan.scene.layers[0].mode == render::Mode::mip;
}

bool is_proven(const render::ResolvedScene& plan) {
  return std::all_of(plan.scene.layers.begin(), plan.scene.layers.end(),
                     [](const render::Layer& layer) { return render::proves(layer.method); });
}

/// What a level promises for a picture.
struct Promise {
  std::string said;        ///< empty: nothing
  double wrong_share = 1;  ///< allowed missed and false pixels, besides one pixel
  double kept = HUGE_VAL;  ///< error of 99 % of the pixels, in the unit of errors
};

Promise promise_of(const render::Layer& layer, const render::Dataset& dataset) {
  using Algorithm = render::Method::Algorithm;
  const Interval<double> range = dataset.field().range;
  const double unit = layer.mode == render::Mode::mip ? 1e-6 * (range.hi - range.lo) : 1;
  if (render::proves(layer.method))
    return {"no false negatives or false positives, every error within its bound", 0, HUGE_VAL};
  if (layer.method.algorithm != Algorithm::direct) return {};
  if (layer.mode == render::Mode::mip)
    return {"no false negatives or false positives, 99 % of the values within a millionth of the field's range", 0,
            unit};
  if (layer.method.precision == render::Method::Precision::float64)
    return {"false negatives and false positives at most 0.1 % + 1 pixel, 99 % within 1e-6 cells", 1e-3, 1e-6};
  return {"false negatives and false positives at most 1 % + 1 pixel, 99 % within 1e-3 cells", 1e-2, 1e-3};
}

/// The loosest promise of all layers.
Promise promise_of(const render::ResolvedScene& plan) {
  Promise loosest{.said = "", .wrong_share = -1, .kept = 0};
  for (const render::Layer& layer : plan.scene.layers) {
    const Promise promise = promise_of(layer, plan.datasets[layer.dataset]);
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

std::vector<std::uint32_t> all_pixels(const render::Framebuffer& picture) {
  std::vector<std::uint32_t> pixels(picture.pixel_count());
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint32_t>(i);
  return pixels;
}

/// Pixels with a neighbour whose depth differs by more than a hundredth. Pixels with a surface
/// differ from pixels without.
std::vector<std::uint32_t> edge_pixels(const render::Framebuffer& picture) {
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

std::vector<TrueHit> true_hits(const render::ResolvedScene& plan, const render::Framebuffer& picture,
                               const std::vector<std::uint32_t>& pixels, unsigned threads) {
  std::vector<TrueHit> nearest(pixels.size());
  for (const render::Layer& layer : plan.scene.layers) {
    const render::Dataset& dataset = plan.datasets[layer.dataset];
    const FieldTruth field(dataset);
    const std::vector<render::Ray> rays = rays_of(dataset, plan.scene.camera, {picture.width, picture.height}, pixels);
    const std::vector<Hit> hits = answers({.dataset = dataset,
                                           .mode = layer.mode,
                                           .isovalue = layer.isovalue,
                                           .method = render::method_of(render::Accuracy::exact),
                                           .clip = clip_of(plan.scene, layer),
                                           .threads = threads},
                                          rays);
    for (std::size_t i = 0; i < hits.size(); ++i)
      if (!hits[i].is_miss() && hits[i].t < nearest[i].hit.t)
        nearest[i] = {hits[i], layer.mode == render::Mode::mip ? 0 : field.cells_per_t(rays[i], hits[i]),
                      std::abs(hits[i].gradient.dot(rays[i].direction))};
  }
  return nearest;
}

CheckedPixels checked_pixels(const render::ResolvedScene& plan, const render::Framebuffer& picture,
                             const std::vector<std::uint32_t>& pixels, double limit, unsigned threads) {
  const bool is_value = is_projection(plan);
  const std::vector<TrueHit> truth = true_hits(plan, picture, pixels, threads);
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
    add(concat(found.missed, " false negatives and ", found.false_hits, " false positives in ", found.pixels, " ",
               which, " pixels"));
  if (is_proven && found.beyond_bound > 0) add(concat(found.beyond_bound, " ", which, " pixels beyond their bound"));
  if (wrong <= allowed && std::isfinite(promise.kept)) add(limit_broken_by(found, promise.kept, which));
  return text;
}

/// The requested limit, in the unit of errors.
double limit_in_unit(const render::ResolvedScene& plan, double limit) {
  const Interval<double> range = plan.datasets[plan.scene.layers[0].dataset].field().range;
  return is_projection(plan) ? limit * (range.hi - range.lo) : limit;
}

}  // namespace

void check(const SelfCheckOptions& options) {
  if (!options.limit) return;
  if (options.pixels == 0) throw Error(ErrorCode::usage, "--verify-limit: needs --verify", "--verify 1000");
  if (!(*options.limit > 0))
    throw Error(ErrorCode::usage, concat("--verify-limit: found ", *options.limit, "; expected a number above 0"));
}

render::ChannelSet channels_to_check(const render::ResolvedScene& plan) {
  return {.depth = true, .value = true, .error = is_proven(plan)};
}

void require_checkable(const render::ResolvedScene& plan) {
  const std::vector<render::Layer>& layers = plan.scene.layers;
  for (const render::Layer& layer : layers) {
    if (layer.mode == render::Mode::triangles)
      throw Error(ErrorCode::usage, "--verify: a layer holds triangles; expected isosurfaces or one projection");
    if (layer.mode == render::Mode::slice)
      throw Error(ErrorCode::usage, "--verify: a layer is a slice; expected isosurfaces or one projection");
    if (layer.mode == render::Mode::mip && layers.size() > 1)
      throw Error(ErrorCode::usage,
                  "--verify: a projection beside other layers; expected isosurfaces or one projection");
    if (layer.mode == render::Mode::isosurface && layers.size() > 1 && layer.material.opacity < 1)
      throw Error(ErrorCode::usage, "--verify: a transparent surface beside other layers; expected opaque isosurfaces");
  }
}

SelfCheck checked(const render::ResolvedScene& plan, const render::Framebuffer& picture,
                  const SelfCheckOptions& options, unsigned threads) {
  const DefaultFloatingPoint default_floating_point;
  std::mt19937_64 random(options.seed);
  SelfCheck check{.seed = options.seed, .unit = is_projection(plan) ? "" : "cells"};
  const Promise promise = promise_of(plan);
  const double limit = options.limit ? limit_in_unit(plan, *options.limit) : promise.kept;
  const auto look_at = [&](const std::vector<std::uint32_t>& pixels) {
    return checked_pixels(plan, picture, some_of(pixels, options.pixels, random), limit, threads);
  };
  check.random = look_at(all_pixels(picture));
  check.edges = look_at(edge_pixels(picture));
  const auto hold = [&](const std::string& broken) {
    check.broken += concat(check.broken.empty() || broken.empty() ? "" : "; ", broken);
  };
  const bool holds_promise = !options.limit || is_proven(plan);
  if (holds_promise && !promise.said.empty()) {
    check.limit = promise.said;
    hold(broken_by(check.random, promise, is_proven(plan), "random"));
    hold(broken_by(check.edges, {promise.said, promise.wrong_share * 10, HUGE_VAL}, is_proven(plan), "edge"));
  }
  if (options.limit) {
    check.limit += concat(check.limit.empty() ? "" : "; ", "99 % within ", *options.limit,
                          is_projection(plan) ? " of the field's range" : " cells");
    hold(limit_broken_by(check.random, limit, "random"));
  }
  return check;
}

std::string text_of(const SelfCheck& check) {
  const auto line = [&](const char* name, const CheckedPixels& found) {
    return concat("  ", name, " ", grouped(found.pixels), " pixels: ", found.missed, " false negatives, ",
                  found.false_hits, " false positives, largest error ", rounded(found.largest),
                  check.unit.empty() ? "" : " ", check.unit,
                  check.unit.empty() ? "" : concat(", largest value error ", rounded(found.largest_value_error)), "\n");
  };
  return concat(
      "checked with exact arithmetic, seed ", check.seed,
      " (false negative: a missed hit; false positive: a hit that does not exist):\n", line("random", check.random),
      line("edges ", check.edges), "  limit: ", check.limit.empty() ? "none; the method promises nothing" : check.limit,
      "\n  ",
      check.broken.empty() ? (check.limit.empty() ? "no limit to check" : "within the limit") : "OUTSIDE THE LIMIT",
      "\n");
}

Json json_of(const SelfCheck& check) {
  const auto found = [](const CheckedPixels& pixels) {
    return Json{{"pixels", pixels.pixels},
                {"missed", pixels.missed},
                {"false_hits", pixels.false_hits},
                {"shown", pixels.shown},
                {"beyond_bound", pixels.beyond_bound},
                {"kept_by_99", pixels.kept_by_99},
                {"largest_error", pixels.largest},
                {"largest_value_error", pixels.largest_value_error}};
  };
  return {{"seed", check.seed}, {"random", found(check.random)}, {"edges", found(check.edges)},
          {"unit", check.unit}, {"limit", check.limit},          {"holds", check.broken.empty()}};
}

}  // namespace rhoray::tools
