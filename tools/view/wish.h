#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "render/camera.h"

namespace rhoray::tools {

/// Limits of what a client may ask for.
namespace view_limits {
inline constexpr std::size_t message_bytes = std::size_t{64} << 10;
inline constexpr int message_depth = 16;
inline constexpr int largest_side = 4096;  ///< of a picture, in pixels
}  // namespace view_limits

/// The isovalue of one layer of the scene.
struct IsovalueWish {
  std::size_t layer = 0;  ///< index into Scene::layers
  double isovalue = 0;
};

/// The picture that a client asks for. It states absolute values, not changes to an earlier wish, so
/// that the server can skip wishes.
struct Wish {
  std::uint32_t number = 0;  ///< counts up
  std::optional<render::Camera> camera{};
  std::vector<IsovalueWish> isovalues{};
  int width = 0, height = 0;  ///< pixels
  bool is_moving = false;     ///< a newer wish follows soon: no antialiasing, lossy, coarse first
};

/// The client has drawn a picture.
struct Acknowledgement {
  std::uint32_t frame = 0;
};

/// Asks for the command that draws the client's last wish.
struct CommandRequest {};

using ClientMessage = std::variant<Wish, Acknowledgement, CommandRequest>;

/// Reads a client's message, a JSON object:
///
///     {"n": 7, "size": [800, 600], "moving": true, "isovalues": [[0, 500]],
///      "camera": {"position": [..], "target": [..], "up": [..], "fov": 30}}   a wish
///     {"ack": 12}                                                           an acknowledgement
///     {"command": true}                                                     a request
///
/// A camera with "ortho_height" instead of "fov" is orthographic. Refuses everything else
/// (ErrorCode::invalid): unknown keys, values of another type, numbers that are not finite or out of
/// range, sizes beyond the limits.
/// @param layer_count  of the scene
ClientMessage parse_client_message(std::string_view text, std::size_t layer_count);

}  // namespace rhoray::tools
