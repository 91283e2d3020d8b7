#include "tools/view/view_link.h"

#include <utility>

#include "formats/base/json.h"
#include "tools/view/viewed_scene.h"

namespace rhoray::tools {

namespace {

Json json_of(const ViewState& state) {
  Json json{{"n", state.number}, {"scene", state.patch.empty() ? Json::object() : Json::parse(state.patch)}};
  if (state.camera) json["camera"] = json_of_camera(*state.camera);
  return json;
}

std::string set_text(const ViewState& state) {
  return dump(Json{{"set", json_of(state)}});
}

}  // namespace

void ViewLink::add(std::uint64_t client, Send send) {
  if (state_) send(set_text(*state_));
  followers_[client] = std::move(send);
}

void ViewLink::set(const ViewState& state) {
  state_ = state;
  for (const auto& [client, send] : followers_) send(set_text(state));
}

void ViewLink::show(const PictureRequest& request) {
  if (!tell_) return;  // each page then has its own state
  const std::uint32_t newest = state_ ? state_->number : 0;
  if (request.set_number < newest) return;
  state_ = ViewState{.number = newest, .camera = request.camera, .patch = request.patch};
  Json json = json_of(*state_);
  json["size"] = {request.width, request.height};
  json["moving"] = request.is_moving;
  tell_(dump(Json{{"state", json}}));
}

void ViewLink::report(const std::string& error) {
  if (tell_) tell_(error);
}

}  // namespace rhoray::tools
