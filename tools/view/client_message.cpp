#include "tools/view/client_message.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& expected) {
  throw Error(ErrorCode::invalid, concat("message: \"", key, "\": expected ", expected));
}

void require_keys(const Json& json, const std::string& name, std::initializer_list<std::string_view> known) {
  if (!json.is_object()) refuse(name, "an object");
  for (const auto& [key, value] : json.items())
    if (std::find(known.begin(), known.end(), key) == known.end()) refuse(key, "no such key");
}

std::uint32_t counter_of(const Json& json, const std::string& key) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > 0xffffffffU) refuse(key, "a number below 2^32");
  return json.get<std::uint32_t>();
}

double number_of(const Json& json, const std::string& key) {
  if (!json.is_number() || !std::isfinite(json.get<double>())) refuse(key, "a finite number");
  return json.get<double>();
}

Vec3 vector_of(const Json& json, const std::string& key) {
  if (!json.is_array() || json.size() != 3) refuse(key, "three numbers");
  return {number_of(json[0], key), number_of(json[1], key), number_of(json[2], key)};
}

render::Camera camera_of(const Json& json) {
  require_keys(json, "camera", {"position", "target", "up", "fov", "ortho_height"});
  for (const char* key : {"position", "target", "up"})
    if (!json.contains(key)) refuse(key, "three numbers");
  render::Camera camera;
  camera.position = vector_of(json["position"], "position");
  camera.target = vector_of(json["target"], "target");
  camera.up = vector_of(json["up"], "up");
  if (!((camera.target - camera.position).cross(camera.up).length() > 0))
    refuse("camera", "position, target and up that do not lie on one line");
  camera.orthographic = json.contains("ortho_height");
  const char* key = camera.orthographic ? "ortho_height" : "fov";
  double& extent = camera.orthographic ? camera.orthographic_height : camera.vertical_fov_deg;
  if (!json.contains(key)) refuse(key, "a number");
  extent = number_of(json[key], key);
  if (!(extent > 0) || (!camera.orthographic && !(extent < 180))) refuse(key, "a number in its range");
  return camera;
}

int side_of(const Json& json) {
  const std::uint32_t side = counter_of(json, "size");
  if (side == 0 || side > static_cast<std::uint32_t>(view_limits::largest_side))
    refuse("size", concat("sides from 1 to ", view_limits::largest_side));
  return static_cast<int>(side);
}

int place_of(const Json& json) {
  const std::uint32_t place = counter_of(json, "probe");
  if (place >= static_cast<std::uint32_t>(view_limits::largest_side)) refuse("probe", "a pixel of the picture");
  return static_cast<int>(place);
}

Probe probe_of(const Json& json) {
  require_keys(json, "message", {"probe", "id"});
  const Json& pixel = json["probe"];
  if (!pixel.is_array() || pixel.size() != 2) refuse("probe", "two numbers");
  if (!json.contains("id")) refuse("id", "a number");
  return {.id = counter_of(json["id"], "id"), .x = place_of(pixel[0]), .y = place_of(pixel[1])};
}

/// "{}" becomes an empty text.
std::string patch_of(const Json& json) {
  if (!json.is_object()) refuse("scene", "an object");
  return json.empty() ? "" : dump(json);
}

PictureRequest picture_request_of(const Json& json) {
  require_keys(json, "message", {"n", "size", "moving", "camera", "scene", "set"});
  PictureRequest request{.number = counter_of(json["n"], "n")};
  if (!json.contains("size") || !json["size"].is_array() || json["size"].size() != 2) refuse("size", "two numbers");
  request.width = side_of(json["size"][0]), request.height = side_of(json["size"][1]);
  if (json.contains("moving")) {
    if (!json["moving"].is_boolean()) refuse("moving", "true or false");
    request.is_moving = json["moving"].get<bool>();
  }
  if (json.contains("camera")) request.camera = camera_of(json["camera"]);
  if (json.contains("scene")) request.patch = patch_of(json["scene"]);
  if (json.contains("set")) request.set_number = counter_of(json["set"], "set");
  return request;
}

/// Parses an object of limited size and depth.
Json parsed(std::string_view text) {
  if (text.size() > view_limits::message_bytes)
    throw Error(ErrorCode::invalid, concat("message: more than ", view_limits::message_bytes, " bytes"));
  const auto is_shallow = [](int depth, Json::parse_event_t, Json&) {
    if (depth > view_limits::message_depth)
      throw Error(ErrorCode::invalid, concat("message: more than ", view_limits::message_depth, " levels"));
    return true;
  };
  Json json;
  try {
    json = Json::parse(text, is_shallow);
  } catch (const Json::exception&) {
    throw Error(ErrorCode::invalid, "message: expected JSON");
  }
  if (!json.is_object()) throw Error(ErrorCode::invalid, "message: expected an object");
  return json;
}

/// Refuses another value than true for the only key.
void require_true(const Json& json, const std::string& key) {
  require_keys(json, "message", {key});
  if (json[key] != true) refuse(key, "true");
}

}  // namespace

ClientMessage parse_client_message(std::string_view text) {
  const Json json = parsed(text);
  if (json.contains("ack")) {
    require_keys(json, "message", {"ack"});
    return Acknowledgement{counter_of(json["ack"], "ack")};
  }
  if (json.contains("probe")) return probe_of(json);
  if (json.contains("keep")) {
    require_true(json, "keep");
    return KeepRequest{};
  }
  if (json.contains("follow")) {
    require_true(json, "follow");
    return FollowRequest{};
  }
  if (!json.contains("n")) refuse("n", "a number");
  return picture_request_of(json);
}

ViewState parse_program_message(std::string_view text) {
  const Json message = parsed(text);
  require_keys(message, "message", {"set"});
  if (!message.contains("set")) refuse("set", "an object");
  const Json& json = message["set"];
  require_keys(json, "set", {"n", "camera", "scene"});
  if (!json.contains("n")) refuse("n", "a number");
  ViewState state{.number = counter_of(json["n"], "n")};
  if (json.contains("camera")) state.camera = camera_of(json["camera"]);
  if (json.contains("scene")) state.patch = patch_of(json["scene"]);
  return state;
}

}  // namespace rhoray::tools
