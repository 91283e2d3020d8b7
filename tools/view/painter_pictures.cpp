// The pictures that the painter makes for a client, and what it says of them.
#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/text.h"
#include "render/accuracy.h"
#include "render/render.h"
#include "tools/analysis/format_statistics.h"
#include "tools/pictures/annotations.h"
#include "tools/view/painter.h"

namespace rhoray::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t checked_pixels = 500;  ///< anywhere, and as many at edges
constexpr double longest_timed_ms = 4000;      ///< effects of a picture that takes longer are not timed
constexpr JpegQuality moving_quality{.quality = 80, .has_full_color = false};
constexpr JpegQuality still_quality{.quality = 92, .has_full_color = true};

/// The scene of the client's picture without the channels that only its check needs.
render::ResolvedScene as_asked(const PainterClient& client) {
  render::ResolvedScene plan = client.plan;
  plan.frame.channels = client.scene->plan.frame.channels;
  return plan;
}

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

/// Sends the picture that was drawn, then the lossless one, then checks it, then times its effects.
void Painter::go_on(Client& client) {
  PictureHeader header{.request = client.drawn->number,
                       .width = client.drawn->width,
                       .height = client.drawn->height,
                       .trace_ms = static_cast<float>(client.finished_ms)};
  if (!client.was_sent) {
    client.was_sent = true;  // also if it fails: it is not tried for ever
    send(client, client.picture, header, still_quality);
  } else if (client.is_rest_over() && !client.was_sent_lossless) {
    header.codec = Codec::png;
    client.was_sent_lossless = true;
    send(client, client.picture, header, {});
  } else if (client.is_rest_over() && !client.was_checked) {
    check(client);
  } else if (client.is_rest_over()) {
    time_effects(client);
  }
}

/// Resolves the scene of a request, unless it was the last one's.
void Painter::show_changes(Client& client, const PictureRequest& request) {
  if (client.patch == request.patch && client.why_refused.empty()) return;
  const auto note = [&](const std::string& why_refused, const auto& take) {
    const std::lock_guard lock(mutex_);
    client.patch = request.patch, client.why_refused = why_refused;
    take();
    changed_.notify_all();  // a probe may wait for it
  };
  try {
    auto scene = std::make_shared<const ChangedScene>(changed_scene(viewed_, document_, request.patch));
    note("", [&] { client.scene = std::move(scene); });
  } catch (const std::exception& error) {
    note(error.what(), [] {});
    throw;
  }
  client.was_resolved_sent = false;
}

void Painter::paint(Client& client, const PictureRequest& request) {
  const Clock::time_point begin = Clock::now();
  client.drawn.reset();
  client.was_sent = client.was_sent_lossless = client.was_checked = client.was_timed = false;
  client.effect_times.reset();
  show_changes(client, request);
  if (request.is_moving)
    paint_moving(client, request, begin);
  else
    paint_at_rest(client, request, begin);
}

render::PictureSize Painter::moving_size(const Client& client, const PictureRequest& request) {
  const std::lock_guard lock(mutex_);
  return client.motion.size_for({request.width, request.height});
}

/// A picture with as many pixels as there is time for.
void Painter::paint_moving(Client& client, const PictureRequest& request, Clock::time_point begin) {
  PictureRequest smaller = request;
  const render::PictureSize size = moving_size(client, request);
  smaller.width = size.width, smaller.height = size.height;
  render::ResolvedScene plan = with_request(viewed_, *client.scene, smaller);
  render::Framebuffer& picture = client.moving_picture;
  const auto statistics = trace(client, plan, {.first_spacing = 1}, begin, picture);
  if (!statistics) return;
  const std::chrono::duration<double> preparation(statistics->preparation_s);
  if (plan.page) draw_heat_map(*plan.page, picture);
  const double traced_ms = ms_since(begin);
  send(client, picture,
       {.request = request.number,
        .width = request.width,
        .height = request.height,
        .trace_ms = static_cast<float>(traced_ms),
        .spacing = static_cast<float>(request.width) / static_cast<float>(size.width)},
       moving_quality, begin + std::chrono::duration_cast<Clock::duration>(preparation));
  const std::lock_guard lock(mutex_);
  client.motion.took(ms_since(begin), 1e3 * statistics->preparation_s, size);
}

/// The picture of `rhoray render`, refined in passes.
void Painter::paint_at_rest(Client& client, const PictureRequest& request, Clock::time_point begin) {
  if (!std::exchange(client.was_resolved_sent, true))
    client.sink.send_text(resolved_text(*client.scene, request.number));
  client.plan = with_request(viewed_, *client.scene, request);
  render::ResolvedScene& plan = client.plan;
  plan.frame.channels |= channels_of_annotations(plan);
  if (why_not_checkable(plan).empty()) plan.frame.channels |= channels_to_check(plan);
  // The page already shows this view with fewer pixels after a motion, or if another client's
  // request ended this picture.
  const bool was_begun = client.sent_request == request.number;
  const bool is_shown = was_begun || begin < client.sent_moving_at + rest_before_lossless;
  const double worst_spacing = is_shown ? client.sent_spacing : 16;
  const int across = moving_size(client, request).width;
  int first_spacing = 1;
  while (first_spacing < 16 && first_spacing * across < request.width) first_spacing *= 2;
  Interval<double> heat;
  bool is_sent = was_begun, has_all_passes = false;
  const auto send_pass = [&](int spacing) {
    send(client, client.picture,
         {.is_thinned = true,
          .request = request.number,
          .width = request.width,
          .height = request.height,
          .trace_ms = static_cast<float>(ms_since(begin)),
          .spacing = static_cast<float>(spacing)},
         moving_quality);
    is_sent = true;
  };
  const auto pass_done = [&](int spacing) {
    has_all_passes = spacing == 1;
    if (plan.page) heat = draw_heat_map(*plan.page, client.picture);
    if (spacing > 1 && spacing <= worst_spacing && may_send(client)) send_pass(spacing);
    const std::lock_guard lock(mutex_);
    if (running_) running_->may_be_ended = is_sent || has_all_passes;
    const bool goes_on = !is_awaited(client) && !client.has_left;
    return goes_on || !is_sent || has_all_passes;
  };
  const auto statistics =
      trace(client, plan, {.first_spacing = first_spacing, .pass_done = pass_done}, begin, client.picture, was_begun);
  if (!statistics) {  // ended; edges may not be smooth
    if (has_all_passes && !is_sent && may_send(client)) send_pass(1);
    const std::lock_guard lock(mutex_);
    if (!client.is_new) client.is_new = true, client.not_before = Clock::now() + rest_before_lossless;
    return;
  }
  client.machine = statistics->machine;
  draw_annotations(plan, heat, client.picture);
  client.drawn = request;
  client.finished = Clock::now();
  client.finished_ms = ms_since(begin);
  if (may_send(client)) go_on(client);
  send_finished(client, *statistics);
}

/// Proves what certified layers need. Only the end of the program ends a proof, which is made once
/// for a file: a file whose proof takes long would otherwise never be shown. Returns how long it
/// took.
Painter::Clock::duration Painter::prove_ranges(const render::ResolvedScene& plan) const {
  const Clock::time_point begin = Clock::now();
  for (const render::Layer& layer : plan.scene.layers)
    if (render::proves(layer.method)) plan.datasets[layer.dataset].prove_ranges(threads_, thread_.get_stop_token());
  return Clock::now() - begin;
}

/// Traces a picture, in passes; a newer request may end it as soon as pass_done or the caller says
/// so. Nothing if it was ended before it was finished. Refuses a picture that takes too long
/// (ErrorCode::resource).
std::optional<render::FrameStatistics> Painter::trace(Client& client, render::ResolvedScene& plan,
                                                      render::Refinement refinement, Clock::time_point begin,
                                                      render::Framebuffer& picture, bool may_be_ended) {
  plan.frame.threads = threads_;
  if (plan.page) plan.frame.channels |= channel_of(*plan.page);
  begin += prove_ranges(plan);
  bool is_whole = false;
  refinement.pass_done = [&is_whole, then = std::move(refinement.pass_done)](int spacing) {
    is_whole = spacing == 1;
    return then ? then(spacing) : true;
  };
  render::FrameStatistics statistics;
  const Outcome outcome = run_until_ended(client, begin, may_be_ended, [&](std::stop_token stop) {
    refinement.watch.stop = std::move(stop);
    statistics = render::refine(plan.datasets, plan.scene, plan.frame, refinement, picture, client.memory);
  });
  if (outcome == Outcome::took_too_long)
    throw Error(ErrorCode::resource,
                concat("the picture takes more than ", 1e-3 * static_cast<double>(longest_picture_.count()),
                       " s; choose fewer samples or a smaller window"));
  if (!is_whole || outcome == Outcome::ended) return std::nullopt;
  return statistics;
}

/// @param header        all but the frame
/// @param moving_since  when a picture in motion was begun, and its preparation over
void Painter::send(Client& client, const render::Framebuffer& picture, PictureHeader header, const JpegQuality& quality,
                   std::optional<Clock::time_point> moving_since) {
  {
    const std::lock_guard lock(mutex_);
    header.frame = client.sent_pictures.next_frame();
  }
  client.sent_request = header.request;
  client.sent_spacing = static_cast<double>(header.spacing);
  client.sent_moving_at = moving_since ? Clock::now() : Clock::time_point();
  std::vector<std::byte> message =
      header.codec == Codec::png ? png_message(header, picture, viewed_.texts_of(as_asked(client), client.machine))
                                 : jpeg_message(header, picture, quality);
  if (moving_since) {
    const std::lock_guard lock(mutex_);
    client.sent_pictures.send_moving(header.frame, *moving_since, Clock::now());
  }
  client.sink.send_picture(std::move(message));
}

void Painter::send_finished(Client& client, const render::FrameStatistics& statistics) {
  client.sink.send_text(dump(Json{{"finished",
                                   {{"n", client.drawn->number},
                                    {"ms", client.finished_ms},
                                    {"threads", threads_ == 0 ? std::thread::hardware_concurrency() : threads_},
                                    {"statistics", statistics_json(statistics)}}}}));
}

/// Traces one more of the pictures that tell what effects cost. A newer request ends it; it is then
/// tried again.
void Painter::time_effects(Client& client) {
  client.was_timed = true;  // also if it fails
  Json json{{"n", client.drawn->number}};
  if (client.finished_ms > longest_timed_ms) {
    json["why_not"] = concat("Effects are timed only if a picture takes less than ", 1e-3 * longest_timed_ms, " s.");
  } else {
    if (!client.effect_times) client.effect_times.emplace(client.plan);
    const Clock::time_point begin = Clock::now();
    if (!trace(client, client.effect_times->next(), {.first_spacing = 1}, begin, client.moving_picture, true)) {
      client.was_timed = false, client.finished = Clock::now();
      return;
    }
    client.effect_times->took(ms_since(begin));
    client.was_timed = client.effect_times->is_done();
    if (!client.was_timed) return;
    json.update(json_of_effects(*client.effect_times));
    client.effect_times.reset();
  }
  client.sink.send_text(dump(Json{{"effects", json}}));
}

/// Compares random pixels of the picture, and pixels at edges, with exact arithmetic. A newer
/// request ends it; it is then tried again.
void Painter::check(Client& client) {
  client.was_checked = true;  // also if it fails
  Json json{{"n", client.drawn->number}};
  if (const std::string why_not = why_not_checkable(client.plan); !why_not.empty()) {
    json["why_not"] = concat("This picture cannot be compared with exact arithmetic: ", why_not, ".");
  } else {
    const Clock::time_point begin = Clock::now();
    render::SelfCheck found;
    const Outcome outcome = run_until_ended(client, begin, true, [&](std::stop_token stop) {
      const render::SelfCheckOptions options{
          .pixels = checked_pixels, .seed = client.drawn->number, .limit = {}, .watch = std::move(stop)};
      found = check_picture(client.plan, client.picture, options, threads_);
    });
    if (outcome == Outcome::ended) {
      client.was_checked = false, client.finished = Clock::now();
      return;
    }
    if (outcome == Outcome::took_too_long)
      json["why_not"] = "The comparison with exact arithmetic takes too long.";
    else
      json.update(json_of_check(found, ms_since(begin)));
  }
  client.sink.send_text(dump(Json{{"check", json}}));
}

void Painter::keep(Client& client, const PictureRequest& request) {
  Json json;
  try {
    show_changes(client, request);
    PictureRequest still = request;
    still.is_moving = false;
    const render::ResolvedScene plan = with_request(viewed_, *client.scene, still);
    json = {{"command", viewed_.command_of(plan)}, {"document", Json::parse(scene_text(to_spec(plan)))}};
  } catch (const std::exception& error) {
    json = {{"error", error.what()}};
  }
  client.sink.send_text(dump(Json{{"keep", json}}));
}

}  // namespace rhoray::tools
