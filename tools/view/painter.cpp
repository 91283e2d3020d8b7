#include "tools/view/painter.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "render/render.h"
#include "tools/pictures/annotations.h"
#include "tools/view/picture_message.h"

namespace rhoray::tools {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t most_unacknowledged = 2;
constexpr auto rest_before_lossless = std::chrono::milliseconds(300);
constexpr double first_pass_ms = 20;  ///< while moving
constexpr JpegQuality moving_quality{.quality = 80, .has_full_color = false};
constexpr JpegQuality still_quality{.quality = 92, .has_full_color = true};

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

std::string error_text(const std::string& what) {
  return dump(Json{{"error", what}});
}

}  // namespace

struct Painter::Client {
  ClientId id = 0;
  ClientSink sink;

  // Guarded by the painter's mutex.
  std::optional<Wish> newest{};
  bool is_new = false;  ///< the newest wish was not taken up
  bool wants_command = false;
  bool has_left = false;
  std::uint32_t sent = 0, acknowledged = 0;   ///< frames
  std::optional<std::stop_source> current{};  ///< of the picture being drawn, once its first pass was sent

  // Of the painter's thread.
  std::optional<Wish> drawn{};  ///< whose finished picture `picture` holds
  bool was_sent = false, was_sent_lossless = false;
  Clock::time_point finished{};
  double finished_ms = 0;
  double ms_per_megapixel = 50;  ///< of the last pass; a guess at first
  render::Framebuffer picture{};
  render::RenderContext memory{};
};

Painter::Painter(ViewedScene viewed, unsigned threads)
    : viewed_(std::move(viewed)), threads_(threads), thread_([this](const std::stop_token& stop) { run(stop); }) {}

Painter::~Painter() {
  stop();
}

void Painter::stop() {
  thread_.request_stop();
  {
    const std::lock_guard lock(mutex_);
    for (const auto& client : clients_)
      if (client->current) client->current->request_stop();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
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
      if (client->current) client->current->request_stop();
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
    if (client.current) client.current->request_stop();
  } else if (const auto* acknowledgement = std::get_if<Acknowledgement>(&message)) {
    // A client that claims what was never sent gains nothing.
    client.acknowledged = std::clamp(acknowledgement->frame, client.acknowledged, client.sent);
  } else {
    client.wants_command = true;
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
    if (client.wants_command) return true;
    if (!has_room(client)) return false;
    if (client.is_new) return true;
    if (!client.drawn) return false;
    if (!client.was_sent) return true;
    return !client.drawn->is_moving && !client.was_sent_lossless &&
           Clock::now() >= client.finished + rest_before_lossless;
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
      client = next_with_work();
      if (!client) {
        const bool waits = std::any_of(clients_.begin(), clients_.end(), [&](const auto& each) {
          return each->drawn && !each->drawn->is_moving && !each->was_sent_lossless && has_room(*each);
        });
        if (waits)
          changed_.wait_for(lock, stop, rest_before_lossless / 3, [] { return false; });
        else
          changed_.wait(lock, stop, [&] { return (client = next_with_work()) != nullptr; });
      }
    }
    if (client) work_for(*client);
  }
}

void Painter::work_for(Client& client) {
  std::optional<Wish> wish;
  bool wants_command = false;
  {
    const std::lock_guard lock(mutex_);
    wants_command = std::exchange(client.wants_command, false);
    if (client.is_new && has_room(client)) wish = client.newest;
    if (wish) client.is_new = false;
  }
  try {
    if (wants_command) send_command(client);
    if (wish)
      paint(client, *wish);
    else if (client.drawn && !client.was_sent)
      send(client, *client.drawn, 1, false, client.finished_ms);
    else if (client.drawn && !client.drawn->is_moving && !client.was_sent_lossless)
      send(client, *client.drawn, 1, true, client.finished_ms);
  } catch (const std::exception& error) {
    client.drawn.reset();
    client.sink.send_text(error_text(error.what()));
  }
}

void Painter::paint(Client& client, const Wish& wish) {
  const Clock::time_point begin = Clock::now();
  client.drawn.reset();
  client.was_sent = client.was_sent_lossless = false;
  render::ResolvedScene plan = with_wish(viewed_, wish);
  plan.frame.threads = threads_;
  if (!wish.is_moving) plan.frame.channels |= channels_of_annotations(plan);

  const double megapixels = 1e-6 * wish.width * wish.height;
  int spacing = 1;
  while (spacing < 16 && client.ms_per_megapixel * megapixels / (spacing * spacing) > first_pass_ms) spacing *= 2;
  std::stop_source source;
  bool is_finished = false, is_first = true;
  const auto pass_done = [&](int traced_spacing) {
    const double ms = ms_since(begin);
    if (std::exchange(is_first, false)) client.ms_per_megapixel = ms * traced_spacing * traced_spacing / megapixels;
    is_finished = traced_spacing == 1;
    bool is_current = false, may_send = false;
    {
      const std::lock_guard lock(mutex_);
      client.current = source;  // from now on a newer wish ends this one
      is_current = !client.is_new && !client.has_left;
      may_send = has_room(client);
    }
    if (!is_finished && may_send) send(client, wish, traced_spacing, false, ms);
    return is_current || is_finished;
  };
  render::refine(plan.datasets, plan.scene, plan.frame,
                 {.first_spacing = spacing, .pass_done = pass_done, .stop = source.get_token()}, client.picture,
                 client.memory);
  {
    const std::lock_guard lock(mutex_);
    client.current.reset();
  }
  if (!is_finished) return;
  if (!wish.is_moving) draw_annotations(plan, {}, client.picture);
  client.drawn = wish;
  client.finished = Clock::now();
  client.finished_ms = ms_since(begin);
  bool may_send = false;
  {
    const std::lock_guard lock(mutex_);
    may_send = has_room(client);
  }
  if (may_send) send(client, wish, 1, false, client.finished_ms);
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

void Painter::send_command(Client& client) {
  std::optional<Wish> wish;
  {
    const std::lock_guard lock(mutex_);
    wish = client.newest;
  }
  if (!wish) return;
  wish->is_moving = false;
  client.sink.send_text(dump(Json{{"command", viewed_.command_of(with_wish(viewed_, *wish))}}));
}

}  // namespace rhoray::tools
