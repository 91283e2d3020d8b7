#pragma once

#include <sys/socket.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <thread>

#include "tests/tools/view/viewed.h"
#include "tools/view/server.h"

namespace rhoray::tests {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

/// A server on a thread of its own.
class Running {
 public:
  explicit Running(const tools::ServerOptions& options = {})
      : server_(viewed_box(folder_), options), thread_([this](const std::stop_token& stop) { server_.run(stop); }) {}

  tools::Server& server() { return server_; }
  std::string host() const { return concat("127.0.0.1:", server_.port()); }
  std::string token() const { return server_.url().substr(server_.url().find("token=") + 6); }

  Tcp::socket connected() {
    Tcp::socket socket(context_);
    socket.connect({asio::ip::address_v4::loopback(), server_.port()});
    const timeval minute{.tv_sec = 60, .tv_usec = 0};  // no test waits for ever
    ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &minute, sizeof minute);
    return socket;
  }

  /// The answer to a request whose headers are replaced where a value is given.
  http::response<http::string_body> answer(http::verb verb, const std::string& target,
                                           std::optional<std::string> other_host = {}, std::string body = {}) {
    Tcp::socket socket = connected();
    http::request<http::string_body> request{verb, target, 11, std::move(body)};
    request.set(http::field::host, other_host.value_or(host()));
    if (!request.body().empty()) request.prepare_payload();
    http::write(socket, request);
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    if (verb == http::verb::head) parser.skip(true);
    http::read(socket, buffer, parser);
    return parser.release();
  }

  /// The status of a WebSocket's handshake: 101 where it is let in.
  unsigned handshake(const std::string& own_host, const std::string& origin, const std::string& protocols,
                     const std::string& target = "/ws") {
    Tcp::socket socket = connected();
    http::request<http::empty_body> request{http::verb::get, target, 11};
    request.set(http::field::host, own_host);
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::connection, "Upgrade");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    request.set(http::field::sec_websocket_version, "13");
    if (!origin.empty()) request.set(http::field::origin, origin);
    if (!protocols.empty()) request.set(http::field::sec_websocket_protocol, protocols);
    http::write(socket, request);
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    http::read_header(socket, buffer, parser);
    return parser.get().result_int();
  }

 private:
  TemporaryFolder folder_;
  asio::io_context context_;
  tools::Server server_;
  std::jthread thread_;
};

/// A page that behaves well.
class Page {
 public:
  explicit Page(Running& running) : socket_(running.connected()) {
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(http::field::origin, concat("http://", running.host()));
      request.set(http::field::sec_websocket_protocol, concat("rhoray.1, ", running.token()));
    }));
    socket_.read_message_max(0);
    socket_.handshake(running.host(), "/ws");
  }

  void say(const std::string& text) { socket_.write(asio::buffer(text)); }
  void say_bytes(const std::string& bytes) {
    socket_.binary(true);
    socket_.write(asio::buffer(bytes));
    socket_.binary(false);
  }
  /// Sends a text in pieces of one byte, each a frame.
  void say_in_fragments(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i)
      socket_.write_some(i + 1 == text.size(), asio::buffer(text.data() + i, 1));
  }
  /// The connection below, for bytes that are no frames.
  Tcp::socket& connection() { return socket_.next_layer(); }
  void ask(std::uint32_t number, int side = 40) {
    say(concat(R"({"n": )", number, R"(, "size": [)", side, ", ", side, R"(], "moving": true})"));
  }

  /// The next text; pictures before it are acknowledged.
  std::string text() {
    for (;;)
      if (std::string message = next(); socket_.got_text()) return message;
  }
  /// The number of the request that the next picture shows; it is acknowledged.
  std::uint32_t picture() {
    for (;;)
      if (const std::string message = next(); !socket_.got_text()) {
        std::uint32_t request = 0;
        std::memcpy(&request, message.data() + 8, sizeof request);
        return request;
      }
  }

 private:
  std::string next() {
    beast::flat_buffer buffer;
    socket_.read(buffer);
    std::string message = beast::buffers_to_string(buffer.data());
    if (!socket_.got_text()) {
      std::uint32_t frame = 0;
      std::memcpy(&frame, message.data() + 4, sizeof frame);
      say(concat(R"({"ack": )", frame, "}"));
      socket_.got_binary();
    }
    return message;
  }

  websocket::stream<Tcp::socket> socket_;
};

}  // namespace rhoray::tests
