#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "tools/view/client_message.h"

namespace rhoray::tools {

/// The state of a view that a browser shares with the program that started the server: both can
/// change its camera and its scene, and the newest change holds. It is used on one thread.
class ViewLink {
 public:
  using Send = std::function<void(std::string)>;

  /// @param tell  takes messages to the program (PROTOCOL.md); empty: there is none, and clients
  ///              share nothing
  explicit ViewLink(Send tell = {}) : tell_(std::move(tell)) {}

  /// Adds a client that shares its state, and sends it the present one, if there is one.
  void add(std::uint64_t client, Send send);
  void remove(std::uint64_t client) { followers_.erase(client); }
  bool has(std::uint64_t client) const { return followers_.contains(client); }

  /// The program has changed the state.
  void set(const ViewState& state);
  /// A client has: the program is told, unless it has made a newer change that the client does not
  /// know.
  void show(const PictureRequest& request);
  /// Tells the program a message to a client that says why a request is refused.
  void report(const std::string& error);

 private:
  Send tell_;
  std::map<std::uint64_t, Send> followers_;
  std::optional<ViewState> state_;
};

}  // namespace rhoray::tools
