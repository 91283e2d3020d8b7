#include "tools/view/painter.h"

#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>
#include <utility>

#include "formats/base/json.h"

namespace rhoray::tools {

namespace {

std::string error_text(const std::string& what) {
  return dump(Json{{"error", what}});
}

}  // namespace

Painter::Painter(ViewedScene viewed, unsigned threads, std::chrono::milliseconds longest_picture)
    : viewed_(std::move(viewed)),
      document_(document_to_change(viewed_)),
      threads_(threads),
      longest_picture_(longest_picture),
      thread_([this](const std::stop_token& stop) { run(stop); }),
      watch_([this](const std::stop_token& stop) { watch(stop); }),
      probing_([this](const std::stop_token& stop) { answer_probes(stop); }) {}

Painter::~Painter() {
  stop();
}

void Painter::stop() {
  for (std::jthread* thread : {&thread_, &watch_, &probing_}) thread->request_stop();
  {
    const std::lock_guard lock(mutex_);
    if (running_) running_->source.request_stop();
  }
  changed_.notify_all();
  for (std::jthread* thread : {&thread_, &watch_, &probing_})
    if (thread->joinable()) thread->join();
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

/// Answers each probe as soon as the scene of its request is resolved, while a picture is traced.
void Painter::answer_probes(const std::stop_token& stop) {
  std::size_t turn = 0;
  std::unique_lock lock(mutex_);
  for (;;) {
    std::shared_ptr<Client> client;
    changed_.wait(lock, stop, [&] {
      return (client = next_client(turn, [](const Client& each) { return each.can_probe(); })) != nullptr;
    });
    if (!client || stop.stop_requested()) return;
    const Probe probe = *std::exchange(client->probe, std::nullopt);
    const PictureRequest request = *client->newest;
    const std::shared_ptr<const ChangedScene> scene = client->scene;
    const std::string why_refused = client->why_refused;
    lock.unlock();
    client->sink.send_text(why_refused.empty() ? probe_text(viewed_, *scene, request, probe, stop)
                                               : refused_probe_text(probe, why_refused));
    lock.lock();
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
  if (const auto* request = std::get_if<PictureRequest>(&message)) {
    client.newest = *request;
    client.is_new = true, client.not_before = {};
    if (running_ && running_->may_be_ended && (running_->client == id || has_room(client)))
      running_->source.request_stop();
  } else if (const auto* acknowledgement = std::get_if<Acknowledgement>(&message)) {
    if (const auto delay = client.sent_pictures.draw(acknowledgement->frame, Clock::now())) client.motion.drawn(*delay);
  } else if (const auto* probe = std::get_if<Probe>(&message)) {
    client.probe = *probe;
  } else {
    client.wants_to_keep = true;
  }
  changed_.notify_all();
}

bool Painter::may_send(const Client& client) {
  const std::lock_guard lock(mutex_);
  return has_room(client);
}

bool Painter::has_room(const Client& client) const {
  return client.sent_pictures.has_room();
}

bool Painter::is_awaited(const Client& client) const {
  return client.is_new || std::any_of(clients_.begin(), clients_.end(),
                                      [&](const auto& each) { return each->is_request_due() && has_room(*each); });
}

/// The next client, in turn, that has work. The caller holds the mutex.
std::shared_ptr<Painter::Client> Painter::next_client(std::size_t& turn,
                                                      const std::function<bool(const Client&)>& has_work) const {
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    const auto& client = clients_[(turn + i) % clients_.size()];
    if (!has_work(*client)) continue;
    turn = (turn + i + 1) % clients_.size();
    return client;
  }
  return nullptr;
}

/// The next client for which something is to be painted or said now.
std::shared_ptr<Painter::Client> Painter::next_with_work() {
  return next_client(turn_, [&](const Client& client) {
    if (client.wants_to_keep) return true;
    if (!has_room(client)) return false;
    if (client.is_request_due()) return true;
    return client.drawn && (!client.was_sent || client.is_rest_over());
  });
}

void Painter::run(const std::stop_token& stop) {
  bool has_worked = false;
  while (!stop.stop_requested()) {
    std::shared_ptr<Client> client;
    {
      std::unique_lock lock(mutex_);
      const auto waits_for_rest = [&] {
        return std::any_of(clients_.begin(), clients_.end(), [&](const auto& each) {
          return (each->is_new || each->waits_at_rest()) && has_room(*each);
        });
      };
      client = next_with_work();
      if (!client && waits_for_rest()) {
        changed_.wait_for(lock, stop, rest_before_lossless / 3, [] { return false; });
      } else if (!client && has_worked) {
        has_worked = false;
        lock.unlock();
        ::malloc_trim(0);  // pictures of other sizes and clients that left have freed memory
      } else if (!client) {
        changed_.wait(lock, stop, [&] { return (client = next_with_work()) != nullptr || waits_for_rest(); });
      }
    }
    if (!client) continue;
    has_worked = true;
    work_for(*client);
  }
}

void Painter::work_for(Client& client) {
  std::optional<PictureRequest> newest;
  bool wants_to_keep = false, may_send = false, is_new = false;
  {
    const std::lock_guard lock(mutex_);
    newest = client.newest;
    wants_to_keep = std::exchange(client.wants_to_keep, false);
    may_send = has_room(client);
    is_new = client.is_request_due() && may_send;
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
  if (is_new)
    attempt([&] { paint(client, *newest); });
  else if (may_send && client.drawn)
    attempt([&] { go_on(client); });
}

/// Does work that the client's leaving, the end of the program and its deadline end, and a newer
/// request of any client as soon as it may.
Painter::Outcome Painter::run_until_ended(Client& client, Clock::time_point begin, bool may_be_ended,
                                          const std::function<void(std::stop_token)>& act) {
  const Clock::time_point deadline = begin + longest_picture_;
  std::stop_source source;
  {
    const std::lock_guard lock(mutex_);
    if (client.has_left || thread_.get_stop_token().stop_requested()) return Outcome::ended;
    if (may_be_ended && is_awaited(client)) return Outcome::ended;
    running_ = Running{client.id, deadline, source, may_be_ended};
  }
  changed_.notify_all();
  std::exception_ptr failure;
  try {
    act(source.get_token());
  } catch (...) {
    failure = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    running_.reset();
  }
  if (!source.stop_requested()) {
    if (failure) std::rethrow_exception(failure);
    return Outcome::finished;
  }
  return Clock::now() >= deadline ? Outcome::took_too_long : Outcome::ended;
}

}  // namespace rhoray::tools
