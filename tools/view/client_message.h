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
inline constexpr int samples = 64;         ///< of lights and of ambient occlusion, unless the scene itself has more
}  // namespace view_limits

/// The picture that a client asks for. It says everything, so that the server can skip requests.
struct PictureRequest {
  std::uint32_t number = 0;  ///< counts up
  std::optional<render::Camera> camera{};
  std::string patch{};           ///< of the scene, JSON (viewed_scene.h: changed_scene); empty: unchanged
  int width = 0, height = 0;     ///< pixels
  bool is_moving = false;        ///< a newer request follows soon: no antialiasing, lossy, coarse first
  std::uint32_t set_number = 0;  ///< of the newest ViewState that the client has taken over
};

/// The client has drawn a picture.
struct Acknowledgement {
  std::uint32_t frame = 0;
};

/// Asks what a pixel of the client's newest request shows.
struct Probe {
  std::uint32_t id = 0;
  int x = 0, y = 0;  ///< from the upper left corner
};

/// Asks for the command and the document of the client's newest request.
struct KeepRequest {};

/// Shares the client's state with the program that started the server (view_link.h).
struct FollowRequest {};

using ClientMessage = std::variant<PictureRequest, Acknowledgement, Probe, KeepRequest, FollowRequest>;

/// What a view shows. The program that started the server sets it.
struct ViewState {
  std::uint32_t number = 0;  ///< counts up
  std::optional<render::Camera> camera{};
  std::string patch{};  ///< as in PictureRequest
};

/// Reads a client's message (PROTOCOL.md). Refuses everything else (ErrorCode::invalid): unknown
/// keys, values of another type, numbers that are not finite or out of range, sizes beyond the
/// limits. The patch of the scene must be an object; changed_scene examines it.
ClientMessage parse_client_message(std::string_view text);

/// Reads a message of the program that started the server, with the same limits.
ViewState parse_program_message(std::string_view text);

}  // namespace rhoray::tools
