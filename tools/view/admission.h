#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::tools {

/// Who may talk to the server. A page of another site that the user has open must not: it can send
/// requests to the loopback interface, and a name of its own may be made to mean this machine (DNS
/// rebinding).
struct Admission {
  std::uint16_t port = 0;
  std::vector<std::string> hosts{"127.0.0.1", "localhost"};  ///< names under which the server is reached
  std::string token;  ///< what the printed URL carries in its fragment, which browsers send to nobody

  /// For a request's Host: one of the names with the port. Behind a proxy, a further name may stand
  /// without a port.
  bool is_own_host(std::string_view host) const;
  /// For the Origin of a WebSocket's request: it must be there, and name the same host as Host.
  bool is_own_origin(std::string_view origin, std::string_view host) const;
  /// For a list of WebSocket subprotocols, in which the page sends the token.
  bool has_token(std::string_view subprotocols) const;
};

/// The subprotocol that both sides speak, which the page names beside the token.
inline constexpr std::string_view view_protocol = "rhoray.1";

/// 128 random bits from the kernel, in hexadecimal digits.
std::string random_token();

/// Whether two texts are equal; takes as long for any two of the same length.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace rhoray::tools
