#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/render.h"
#include "tools/view/motion_pixels.h"
#include "tools/view/picture_message.h"
#include "tools/view/sent_pictures.h"
#include "tools/view/viewed_scene.h"

namespace rhoray::tools {

inline constexpr auto rest_before_lossless = std::chrono::milliseconds(300);

/// Takes the messages to a client. The painter's threads call it, several at a time; it must not
/// wait.
struct ClientSink {
  std::function<void(std::vector<std::byte>)> send_picture;
  std::function<void(std::string)> send_text;
};

/// The painter's record of a client.
struct PainterClient {
  using Clock = std::chrono::steady_clock;

  std::uint64_t id = 0;
  ClientSink sink;

  // The painter's mutex guards these members.
  std::optional<PictureRequest> newest{};
  bool is_new = false;             ///< the newest request was not taken up, or is to be drawn again
  Clock::time_point not_before{};  ///< when it is taken up; later only if another client ended it
  bool wants_to_keep = false;
  std::optional<Probe> probe{};
  std::optional<std::string> patch{};  ///< the newest that was resolved or refused
  std::string why_refused{};           ///< empty: it was resolved to `scene`
  std::shared_ptr<const ChangedScene> scene{};
  bool has_left = false;
  SentPictures sent_pictures{};
  MotionPixels motion{};

  /// The newest request has a scene, or was refused: a probe of it can be answered.
  bool can_probe() const { return probe && newest && patch == newest->patch; }

  // Only the thread that paints uses these members. It alone writes the scene and its patch, and
  // therefore reads them without the mutex.
  bool was_resolved_sent = false;         ///< of this scene
  std::optional<PictureRequest> drawn{};  ///< whose finished picture `picture` holds
  bool was_sent = false, was_sent_lossless = false, was_checked = false, was_timed = false;
  std::optional<EffectTimes> effect_times{};  ///< being measured, of `plan`
  Clock::time_point finished{};
  double finished_ms = 0;
  double sent_spacing = 16;            ///< of the picture that was sent last
  Clock::time_point sent_moving_at{};  ///< when a picture in motion was sent, if none at rest followed
  std::uint32_t sent_request = 0;      ///< whose picture was sent last
  std::string machine{};               ///< that traced `picture`, for its file
  render::ResolvedScene plan{};        ///< of `picture`
  render::Framebuffer picture{}, moving_picture{};
  render::RenderContext memory{};

  /// Something is to be done for a picture at rest, once its time has come and the client has room.
  bool waits_at_rest() const { return drawn && (!was_sent_lossless || !was_checked || !was_timed); }
  bool is_rest_over() const { return waits_at_rest() && Clock::now() >= finished + rest_before_lossless; }
  bool is_request_due() const { return is_new && Clock::now() >= not_before; }
};

}  // namespace rhoray::tools
