#include "tools/view/painter.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/text.h"
#include "render/accuracy.h"
#include "render/render.h"
#include "tools/analysis/format_statistics.h"
#include "tools/pictures/annotations.h"
#include "tools/view/picture_message.h"

namespace rhoray::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t most_unacknowledged = 2;
constexpr auto rest_before_lossless = std::chrono::milliseconds(300);
constexpr auto longest_picture = std::chrono::seconds(30);
constexpr double first_pass_ms = 16;  ///< while moving: a wish waits for half of one pass and for its own
constexpr std::uint64_t checked_pixels = 500;
constexpr JpegQuality moving_quality{.quality = 80, .has_full_color = false};
constexpr JpegQuality still_quality{.quality = 92, .has_full_color = true};

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string error_text(const std::string& what) {
  return dump(Json{{"error", what}});
}

/// Chooses the spacing of the first pass so that it fits its time. A pass with half the spacing takes 4
/// times the rays, but less time for each: neighbours share their way. How much less, only trying says.
class FirstPass {
 public:
  /// 1, 2, 4, 8 or 16.
  int spacing_for(double megapixels) const {
    std::size_t step = 0;
    while (step + 1 < ms_.size() && expected_ms(step) * megapixels > first_pass_ms) ++step;
    return 1 << step;
  }

  void took(double ms, int spacing, double megapixels) {
    std::size_t step = 0;
    while (1 << step < spacing) ++step;
    ms_[step] = ms / megapixels;
    // What was too slow once is tried again some time.
    if (step > 0 && ms_[step - 1] > 0) ms_[step - 1] += 0.01 * (growth * ms_[step] - ms_[step - 1]);
  }

 private:
  static constexpr double growth = 1.8;  ///< usual, of the time when the spacing is halved

  double expected_ms(std::size_t step) const {
    if (ms_[step] > 0) return ms_[step];
    for (std::size_t coarser = step + 1; coarser < ms_.size(); ++coarser)
      if (ms_[coarser] > 0) return std::pow(growth, static_cast<double>(coarser - step)) * ms_[coarser];
    for (std::size_t finer = step; finer-- > 0;)
      if (ms_[finer] > 0) return ms_[finer] / std::pow(growth, static_cast<double>(step - finer));
    return 50 / std::pow(growth, static_cast<double>(step));
  }

  std::array<double, 5> ms_{};  ///< per megapixel of the whole picture, by the logarithm of the spacing; 0: not known
};

}  // namespace

struct Painter::Client {
  ClientId id = 0;
  ClientSink sink;

  // Guarded by the painter's mutex.
  std::optional<Wish> newest{};
  bool is_new = false;  ///< the newest wish was not taken up
  bool wants_to_keep = false;
  std::optional<Probe> probe{};
  bool has_left = false;
  std::uint32_t sent = 0, acknowledged = 0;  ///< frames

  // Of the painter's thread.
  std::optional<ChangedScene> scene{};  ///< with `patch`
  std::string patch{};
  bool was_resolved_sent = false;  ///< of this scene
  std::optional<Wish> drawn{};     ///< whose finished picture `picture` holds
  bool was_sent = false, was_sent_lossless = false, was_checked = false;
  Clock::time_point finished{};
  double finished_ms = 0;
  FirstPass first_pass{};
  render::ResolvedScene plan{};  ///< of `picture`
  render::Framebuffer picture{};
  render::RenderContext memory{};

  /// Something is to be done for a picture at rest, once its time has come and the client has room.
  bool waits_at_rest() const { return drawn && !drawn->is_moving && (!was_sent_lossless || !was_checked); }
  bool is_rest_over() const { return waits_at_rest() && Clock::now() >= finished + rest_before_lossless; }
};

Painter::Painter(ViewedScene viewed, unsigned threads)
    : viewed_(std::move(viewed)),
      document_(document_to_change(viewed_)),
      threads_(threads),
      thread_([this](const std::stop_token& stop) { run(stop); }),
      watch_([this](const std::stop_token& stop) { watch(stop); }) {}

Painter::~Painter() {
  stop();
}

void Painter::stop() {
  thread_.request_stop();
  watch_.request_stop();
  {
    const std::lock_guard lock(mutex_);
    if (running_) running_->source.request_stop();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (watch_.joinable()) watch_.join();
}

std::string Painter::hello() const {
  return hello_text(viewed_, document_);
}

/// Ends pictures that take too long.
void Painter::watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!running_) {
      changed_.wait(lock, stop, [&] { return running_.has_value(); });
    } else {
      const Clock::time_point deadline = running_->deadline;
      if (Clock::now() >= deadline) running_->source.request_stop();
      changed_.wait_until(lock, stop, std::max(deadline, Clock::now() + rest_before_lossless),
                          [&] { return !running_ || running_->deadline != deadline; });
    }
  }
}

Painter::ClientId Painter::add(ClientSink sink) {
  const std::lock_guard lock(mutex_);
  auto client = std::make_shared<Client>();
  client->id = next_id_++;
  client->sink = std::move(sink);
  clients_.push_back(client);
  return client->id;
}

void Painter::remove(ClientId id) {
  const std::lock_guard lock(mutex_);
  for (const auto& client : clients_)
    if (client->id == id) {
      client->has_left = true;
      if (running_ && running_->client == id) running_->source.request_stop();
    }
  std::erase_if(clients_, [&](const auto& client) { return client->id == id; });
}

void Painter::take(ClientId id, const ClientMessage& message) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(clients_.begin(), clients_.end(), [&](const auto& each) { return each->id == id; });
  if (found == clients_.end()) return;
  Client& client = **found;
  if (const auto* wish = std::get_if<Wish>(&message)) {
    client.newest = *wish;
    client.is_new = true;
    if (running_ && running_->client == id && running_->was_first_sent) running_->source.request_stop();
  } else if (const auto* acknowledgement = std::get_if<Acknowledgement>(&message)) {
    // A client that claims what was never sent gains nothing.
    client.acknowledged = std::clamp(acknowledgement->frame, client.acknowledged, client.sent);
  } else if (const auto* probe = std::get_if<Probe>(&message)) {
    client.probe = *probe;
  } else {
    client.wants_to_keep = true;
  }
  changed_.notify_all();
}

bool Painter::has_room(const Client& client) const {
  return client.sent - client.acknowledged < most_unacknowledged;
}

/// The next client, in turn, for which something is to be done now; waits for the lock to be taken by
/// the caller.
std::shared_ptr<Painter::Client> Painter::next_with_work() {
  const auto has_work = [&](const Client& client) {
    if (client.wants_to_keep || client.probe) return true;
    if (!has_room(client)) return false;
    if (client.is_new) return true;
    return client.drawn && (!client.was_sent || client.is_rest_over());
  };
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    const auto& client = clients_[(turn_ + i) % clients_.size()];
    if (!has_work(*client)) continue;
    turn_ = (turn_ + i + 1) % clients_.size();
    return client;
  }
  return nullptr;
}

void Painter::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::shared_ptr<Client> client;
    {
      std::unique_lock lock(mutex_);
      const auto waits_for_rest = [&] {
        return std::any_of(clients_.begin(), clients_.end(),
                           [&](const auto& each) { return each->waits_at_rest() && has_room(*each); });
      };
      client = next_with_work();
      if (!client && waits_for_rest())
        changed_.wait_for(lock, stop, rest_before_lossless / 3, [] { return false; });
      else if (!client)
        changed_.wait(lock, stop, [&] { return (client = next_with_work()) != nullptr || waits_for_rest(); });
    }
    if (client) work_for(*client);
  }
}

void Painter::work_for(Client& client) {
  std::optional<Wish> newest;
  std::optional<Probe> probe;
  bool wants_to_keep = false, may_send = false, is_new = false;
  {
    const std::lock_guard lock(mutex_);
    newest = client.newest;
    wants_to_keep = std::exchange(client.wants_to_keep, false);
    probe = std::exchange(client.probe, std::nullopt);
    may_send = has_room(client);
    is_new = client.is_new && may_send;
    if (is_new) client.is_new = false;
  }
  const auto attempt = [&](const auto& act) {
    try {
      act();
    } catch (const std::exception& error) {
      client.sink.send_text(error_text(error.what()));
    }
  };
  if (newest && wants_to_keep) keep(client, *newest);
  if (newest && probe) attempt([&] { answer(client, *newest, *probe); });
  if (is_new)
    attempt([&] { paint(client, *newest); });
  else if (may_send && client.drawn)
    attempt([&] { go_on(client); });
}

/// Sends the picture that was drawn, then the lossless one, then checks it.
void Painter::go_on(Client& client) {
  if (!client.was_sent)
    send(client, *client.drawn, 1, false, client.finished_ms);
  else if (client.is_rest_over() && !client.was_sent_lossless)
    send(client, *client.drawn, 1, true, client.finished_ms);
  else if (client.is_rest_over())
    check(client);
}

/// Resolves the scene of a wish, unless it was the last one's.
void Painter::show_changes(Client& client, const Wish& wish) {
  if (client.scene && client.patch == wish.patch) return;
  client.scene = changed_scene(viewed_, document_, wish.patch);
  client.patch = wish.patch;
  client.was_resolved_sent = false;
}

void Painter::paint(Client& client, const Wish& wish) {
  const Clock::time_point begin = Clock::now();
  client.drawn.reset();
  client.was_sent = client.was_sent_lossless = client.was_checked = false;
  show_changes(client, wish);
  if (!wish.is_moving && !std::exchange(client.was_resolved_sent, true))
    client.sink.send_text(resolved_text(*client.scene, wish.number));
  client.plan = with_wish(viewed_, *client.scene, wish);
  render::ResolvedScene& plan = client.plan;
  plan.frame.threads = threads_;
  if (plan.page) plan.frame.channels |= channel_of(*plan.page);
  if (!wish.is_moving) {
    plan.frame.channels |= channels_of_annotations(plan);
    if (why_not_checkable(plan).empty()) plan.frame.channels |= channels_to_check(plan);
  }

  const double megapixels = 1e-6 * wish.width * wish.height;
  const int spacing = client.first_pass.spacing_for(megapixels);
  std::stop_source source;
  bool is_finished = false, is_first = true;
  Interval<double> heat;
  // With the time to encode it, which counts on small scenes.
  const auto note_first = [&](int traced_spacing) {
    if (std::exchange(is_first, false)) client.first_pass.took(ms_since(begin), traced_spacing, megapixels);
  };
  const auto pass_done = [&](int traced_spacing) {
    const double ms = ms_since(begin);
    is_finished = traced_spacing == 1;
    bool is_current = false, may_send = false;
    {
      const std::lock_guard lock(mutex_);
      if (running_) running_->was_first_sent = true;
      is_current = !client.is_new && !client.has_left && Clock::now() < begin + longest_picture;
      may_send = has_room(client);
    }
    if (plan.page) heat = draw_heat_map(*plan.page, client.picture);
    if (!is_finished && may_send) {
      send(client, wish, traced_spacing, false, ms);
      note_first(traced_spacing);
    }
    return is_current || is_finished;
  };
  {
    const std::lock_guard lock(mutex_);
    running_ = Running{client.id, begin + longest_picture, source};
  }
  changed_.notify_all();
  const auto end = [&] {
    const std::lock_guard lock(mutex_);
    running_.reset();
  };
  render::FrameStatistics statistics;
  try {
    statistics = render::refine(plan.datasets, plan.scene, plan.frame,
                                {.first_spacing = spacing, .pass_done = pass_done, .stop = source.get_token()},
                                client.picture, client.memory);
  } catch (...) {
    end();
    throw;
  }
  end();
  if (!is_finished) {
    if (Clock::now() >= begin + longest_picture)
      throw Error(ErrorCode::resource, concat("the picture takes more than ", longest_picture.count(),
                                              " s; choose fewer samples or a smaller window"));
    return;
  }
  if (!wish.is_moving) draw_annotations(plan, heat, client.picture);
  client.drawn = wish;
  client.finished = Clock::now();
  client.finished_ms = ms_since(begin);
  bool may_send = false;
  {
    const std::lock_guard lock(mutex_);
    may_send = has_room(client);
  }
  if (may_send) {
    send(client, wish, 1, false, client.finished_ms);
    if (wish.is_moving && spacing == 1) note_first(1);
  }
  send_finished(client, statistics);
}

void Painter::send(Client& client, const Wish& wish, int spacing, bool lossless, double trace_ms) {
  PictureHeader header{.codec = lossless ? Codec::png : Codec::jpeg,
                       .spacing = static_cast<std::uint16_t>(spacing),
                       .wish = wish.number,
                       .width = wish.width,
                       .height = wish.height,
                       .trace_ms = static_cast<float>(trace_ms)};
  {
    const std::lock_guard lock(mutex_);
    header.frame = ++client.sent;
  }
  client.sink.send_picture(
      lossless ? png_message(header, client.picture)
               : jpeg_message(header, client.picture, wish.is_moving || spacing > 1 ? moving_quality : still_quality));
  if (spacing == 1) client.was_sent = true;
  if (lossless) client.was_sent_lossless = true;
}

void Painter::send_finished(Client& client, const render::FrameStatistics& statistics) {
  client.sink.send_text(dump(Json{{"finished",
                                   {{"n", client.drawn->number},
                                    {"ms", client.finished_ms},
                                    {"threads", threads_ == 0 ? std::thread::hardware_concurrency() : threads_},
                                    {"statistics", statistics_json(statistics)}}}}));
}

/// Compares random pixels of the picture with exact arithmetic.
void Painter::check(Client& client) {
  client.was_checked = true;
  Json json{{"n", client.drawn->number}};
  if (const std::string why_not = why_not_checkable(client.plan); !why_not.empty()) {
    json["why_not"] = why_not;
  } else {
    const Clock::time_point begin = Clock::now();
    const render::SelfCheck found = check_picture(
        client.plan, client.picture, {.pixels = checked_pixels, .seed = client.drawn->number, .limit = {}}, threads_);
    const render::CheckedPixels& all = found.random;
    json.update(Json{{"pixels", all.pixels},
                     {"missed", all.missed},
                     {"false_hits", all.false_hits},
                     {"kept_by_99", all.kept_by_99},
                     {"unit", found.unit},
                     {"ms", ms_since(begin)}});
  }
  client.sink.send_text(dump(Json{{"check", json}}));
}

void Painter::answer(Client& client, const Wish& wish, const Probe& probe) {
  show_changes(client, wish);
  client.sink.send_text(probe_text(with_wish(viewed_, *client.scene, wish), probe));
}

void Painter::keep(Client& client, const Wish& wish) {
  Json json;
  try {
    show_changes(client, wish);
    Wish still = wish;
    still.is_moving = false;
    const render::ResolvedScene plan = with_wish(viewed_, *client.scene, still);
    json = {{"command", viewed_.command_of(plan)}, {"document", Json::parse(scene_text(to_spec(plan)))}};
  } catch (const std::exception& error) {
    json = {{"error", error.what()}};
  }
  client.sink.send_text(dump(Json{{"keep", json}}));
}

}  // namespace rhoray::tools
