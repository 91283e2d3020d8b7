#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace rhoray::tools {

/// The pictures that were sent to a client, and those that it has drawn. No more than two are under
/// way.
class SentPictures {
 public:
  using Clock = std::chrono::steady_clock;

  bool has_room() const { return count_ - drawn_ < most_under_way; }

  /// The number of the next picture, which counts as sent.
  std::uint32_t next_frame() { return ++count_; }

  /// A picture in motion is sent.
  /// @param begun  when its preparation was over
  void send_moving(std::uint32_t frame, Clock::time_point begun, Clock::time_point sent) {
    moving_.push_back({frame, begun, sent, drawn_ + 1 == count_});
  }

  /// How long a picture in motion took, ms.
  struct Delay {
    double whole_ms;         ///< since it was begun
    double client_ms;        ///< since it was sent
    bool was_alone = false;  ///< the client had drawn all pictures before it
  };

  /// The client has drawn a picture and needs none before it. A client that claims what was never
  /// sent gains nothing.
  /// @return  the delay of that picture, if it was one in motion
  std::optional<Delay> draw(std::uint32_t frame, Clock::time_point now) {
    drawn_ = std::clamp(frame, drawn_, count_);
    std::optional<Delay> delay;
    std::erase_if(moving_, [&](const Moving& picture) {
      const auto ms_since = [&](Clock::time_point then) {
        return std::chrono::duration<double, std::milli>(now - then).count();
      };
      if (picture.frame == frame) delay = {ms_since(picture.begun), ms_since(picture.sent), picture.is_alone};
      return picture.frame <= drawn_;
    });
    return delay;
  }

 private:
  struct Moving {
    std::uint32_t frame;
    Clock::time_point begun, sent;
    bool is_alone;
  };
  static constexpr std::uint32_t most_under_way = 2;

  std::uint32_t count_ = 0, drawn_ = 0;  ///< frames
  std::vector<Moving> moving_;           ///< under way, oldest first
};

}  // namespace rhoray::tools
