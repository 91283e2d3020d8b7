#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/render.h"
#include "tools/view/painter_client.h"
#include "tools/view/picture_message.h"
#include "tools/view/viewed_scene.h"

namespace rhoray::tools {

/// Draws the pictures that clients request, on one thread that uses all cores. Clients take turns.
/// A second thread answers probes meanwhile.
///
/// The newest request of a client wins. It ends an older one that is being traced, but not before a
/// picture of the older one was sent. It ends a picture of another client in the same way, and that
/// picture is traced again later. In motion a picture has as many pixels as there is time for
/// (motion_pixels.h). No client has more than two pictures that it has not acknowledged. When it
/// stops moving, the picture is refined to that of `rhoray render`, and is sent a second time
/// without loss. In idle time random pixels of it are compared with exact arithmetic, and its
/// effects are timed. A newer request ends both.
class Painter {
 public:
  using ClientId = std::uint64_t;

  /// @param threads          0 = all cores
  /// @param longest_picture  a picture that takes longer is ended, and the client told so
  Painter(ViewedScene viewed, unsigned threads, std::chrono::milliseconds longest_picture = std::chrono::seconds(30));
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;
  ~Painter();
  void stop();  ///< ends the threads; nothing is sent afterwards

  std::string hello() const;  ///< the first message to a client

  // Any thread may call these.
  ClientId add(ClientSink sink);
  void remove(ClientId client);  ///< returns at once; a message that is being made may still be sent
  void take(ClientId client, const ClientMessage& message);

 private:
  using Client = PainterClient;
  using Clock = std::chrono::steady_clock;

  void run(const std::stop_token& stop);
  void watch(const std::stop_token& stop);
  void answer_probes(const std::stop_token& stop);
  std::shared_ptr<Client> next_client(std::size_t& turn, const std::function<bool(const Client&)>& has_work) const;
  std::shared_ptr<Client> next_with_work();
  void work_for(Client& client);
  void go_on(Client& client);
  void paint(Client& client, const PictureRequest& request);
  void paint_moving(Client& client, const PictureRequest& request, Clock::time_point begin);
  void paint_at_rest(Client& client, const PictureRequest& request, Clock::time_point begin);
  enum class Outcome { finished, ended, took_too_long };
  Outcome run_until_ended(Client& client, Clock::time_point begin, bool may_be_ended,
                          const std::function<void(std::stop_token)>& act);
  Clock::duration prove_ranges(const render::ResolvedScene& plan) const;
  std::optional<render::FrameStatistics> trace(Client& client, render::ResolvedScene& plan,
                                               render::Refinement refinement, Clock::time_point begin,
                                               render::Framebuffer& picture, bool may_be_ended = false);
  void show_changes(Client& client, const PictureRequest& request);
  render::PictureSize moving_size(const Client& client, const PictureRequest& request);
  bool may_send(const Client& client);
  bool has_room(const Client& client) const;    ///< with the mutex held
  bool is_awaited(const Client& client) const;  ///< with the mutex held: a request should end its work
  void send(Client& client, const render::Framebuffer& picture, PictureHeader header, const JpegQuality& quality,
            std::optional<Clock::time_point> moving_since = {});
  void send_finished(Client& client, const render::FrameStatistics& statistics);
  void check(Client& client);
  void time_effects(Client& client);
  void keep(Client& client, const PictureRequest& request);

  /// The work that is being done: a picture, or the check of one.
  struct Running {
    ClientId client = 0;
    Clock::time_point deadline;
    std::stop_source source;
    bool may_be_ended = false;  ///< by a newer request of any client
  };

  const ViewedScene viewed_;
  const std::string document_;
  const unsigned threads_;
  const std::chrono::milliseconds longest_picture_;
  std::mutex mutex_;  ///< of the clients, but for what only the painter's thread uses
  std::condition_variable_any changed_;
  std::vector<std::shared_ptr<Client>> clients_;
  std::optional<Running> running_;
  ClientId next_id_ = 1;
  std::size_t turn_ = 0;
  std::jthread thread_, watch_, probing_;
};

}  // namespace rhoray::tools
