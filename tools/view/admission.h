#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::tools {

/// The name of a host in lower case, perhaps with a port.
struct HostName {
  std::string text;
};

/// Reads NAME or NAME:PORT, or several of them with commas between, and adds them
/// (ErrorCode::usage).
void read_value(const std::string& text, std::vector<HostName>& out);

/// Decides which requests the server answers. Pages of other sites in the user's browser can send
/// requests to the loopback interface, and their own host names can be made to mean this machine
/// (DNS rebinding).
struct Admission {
  std::uint16_t port = 0;
  std::vector<HostName> proxies{};  ///< in front of the server
  std::string token;                ///< in the fragment of the printed URL, which browsers do not send

  /// For a request's Host: 127.0.0.1 or localhost with the port, or a proxy, with any port or none
  /// unless it is named with one. Capitals do not matter.
  bool is_own_host(std::string_view host) const;
  /// For the Origin of a WebSocket's request: it must name the same host as Host, or a proxy, also
  /// with https. Some proxies replace Host by the address of this server.
  bool is_own_origin(std::string_view origin, std::string_view host) const;
  /// For a list of WebSocket subprotocols, in which the page sends the token.
  bool has_token(std::string_view subprotocols) const;
};

/// The subprotocol that both sides speak, which the page names beside the token.
inline constexpr std::string_view view_protocol = "rhoray.1";

/// 128 random bits from the kernel, in hexadecimal digits.
std::string random_token();

/// True for equal texts. The time depends on their lengths alone.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace rhoray::tools
