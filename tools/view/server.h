#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tools/view/admission.h"
#include "tools/view/viewed_scene.h"

namespace rhoray::tools {

struct ServerOptions {
  std::uint16_t port = 0;                 ///< on the loopback interface; 0: a free one
  std::filesystem::path socket{};         ///< a Unix socket instead, mode 0600; empty: none. Then
                                          ///< `port` is that of the tunnel; 0: 8123
  std::vector<HostName> allowed_hosts{};  ///< names under which a proxy reaches the server
  unsigned threads = 0;                   ///< that trace; 0 = all cores
  /// Takes messages to the program that started the server, JSON (PROTOCOL.md). The server's thread
  /// calls it; it must not wait. Empty: nobody is told, and clients share nothing.
  std::function<void(std::string)> tell_program{};
};

/// Serves one scene to browsers: a page that is compiled in, and pictures over a WebSocket. It
/// reads no file that a client names and writes none.
///
/// A request must name this server in Host, a WebSocket's also in Origin, and bring the token of
/// the URL. At most 8 clients, 64 connections, 8 KiB of headers, 64 KiB a message. A connection that
/// says nothing for 10 s is closed, and so is a client that does not answer pings, or for which
/// 1024 messages or 64 MiB wait.
class Server {
 public:
  /// Listens. Refuses an address that is taken (ErrorCode::resource).
  Server(ViewedScene viewed, const ServerOptions& options);
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server();

  /// "http://127.0.0.1:40123/#token=...": the token stands in the fragment, which browsers send to
  /// nobody. With a socket the address is that of a tunnel to it.
  std::string url() const;
  std::uint16_t port() const;
  std::string hello() const;  ///< the first message to a client and to the program

  /// Changes what the first view of each page shows. Any thread may call it.
  void set(const ViewState& state);

  /// Serves until the token is told to stop. Another thread may tell it.
  void run(const std::stop_token& stop);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace rhoray::tools
