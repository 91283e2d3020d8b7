#include "tools/view/server.h"

#include <sys/stat.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <chrono>
#include <deque>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/text.h"
#include "tools/view/admission.h"
#include "tools/view/page.h"
#include "tools/view/painter.h"
#include "tools/view/view_link.h"

namespace rhoray::tools {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Code = beast::error_code;

namespace {

constexpr std::size_t most_clients = 8, most_connections = 64, most_header_bytes = 8192;
constexpr auto longest_silence = std::chrono::seconds(10);
constexpr auto longest_without_pong = std::chrono::seconds(30);
constexpr std::size_t most_bytes_waiting = std::size_t{64} << 20;  ///< for a client that does not read
constexpr std::size_t most_messages_waiting = 1024;
constexpr std::uint16_t usual_tunnel_port = 8123;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

Response plain(http::status status, const std::string& text) {
  Response response{status, 11};
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = text + "\n";
  return response;
}

/// Only the page itself, its style, its program and the pictures that it made may be loaded or
/// shown.
void add_safety(Response& response) {
  response.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
               "base-uri 'none'; form-action 'none'; "
               "frame-ancestors 'self' http://127.0.0.1:* http://localhost:*");  // notebooks show the page in a frame
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(false);
  response.prepare_payload();
}

std::string text_of(boost::string_view view) {
  return {view.data(), view.size()};
}

Response answer(const Request& request, const Admission& admission) {
  if (!admission.is_own_host(text_of(request[http::field::host])))
    return plain(http::status::forbidden, "this server answers to other host names");
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return plain(http::status::method_not_allowed, "expected GET");
  const std::string target = text_of(request.target());
  for (const PageFile& file : page_files())
    if (target == file.path) {
      Response response{http::status::ok, 11};
      response.set(http::field::content_type, boost::string_view(file.type.data(), file.type.size()));
      if (request.method() == http::verb::get) response.body() = std::string(file.content);
      return response;
    }
  return plain(http::status::not_found, "there is no such page");
}

/// The state that all connections of a server share. Only the server's thread uses it.
struct Shared {
  Admission admission;
  Painter painter;
  ViewLink link;
  std::size_t connection_count = 0, client_count = 0;
  asio::io_context context;  ///< last: connections that end with it use the others

  Shared(ViewedScene viewed, const ServerOptions& options)
      : painter(std::move(viewed), options.threads), link(options.tell_program) {}
  ~Shared() { painter.stop(); }  // which posts to the context
};

/// A client's WebSocket. Messages of the painter are posted to the server's thread.
template <class Protocol>
class Session : public std::enable_shared_from_this<Session<Protocol>> {
 public:
  Session(Shared& shared, beast::basic_stream<Protocol> stream) : shared_(shared), socket_(std::move(stream)) {
    ++shared_.client_count;
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session() {
    --shared_.client_count;
    if (!id_) return;
    shared_.link.remove(*id_);
    shared_.painter.remove(*id_);
  }

  void start(const Request& request) {
    beast::get_lowest_layer(socket_).expires_never();
    websocket::stream_base::timeout timeout{longest_silence, longest_without_pong, true};
    socket_.set_option(timeout);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, boost::string_view(view_protocol.data(), view_protocol.size()));
    }));
    socket_.read_message_max(view_limits::message_bytes);
    socket_.auto_fragment(false);  // a picture is one frame; the default cuts it into pieces of 4 KiB
    socket_.async_accept(request, [self = this->shared_from_this()](Code error) {
      if (!error) self->welcome();
    });
  }

 private:
  using Message = std::variant<std::string, std::vector<std::byte>>;

  void welcome() {
    const std::weak_ptr<Session> weak = this->weak_from_this();
    asio::io_context& context = shared_.context;
    const auto post = [weak, &context](Message message) {
      asio::post(context, [weak, message = std::make_shared<Message>(std::move(message))] {
        if (const auto self = weak.lock()) self->send(std::move(*message));
      });
    };
    send(shared_.painter.hello());
    id_ = shared_.painter.add({.send_picture = [post](std::vector<std::byte> bytes) { post(std::move(bytes)); },
                               .send_text = [post](std::string text) { post(std::move(text)); }});
    read();
  }

  void read() {
    socket_.async_read(buffer_, [self = this->shared_from_this()](Code error, std::size_t) {
      if (error) return;  // the last reference goes, and with it the client
      self->take();
      self->read();
    });
  }

  void take() {
    const std::string text = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    try {
      if (!socket_.got_text()) throw Error(ErrorCode::invalid, "message: expected text");
      const ClientMessage message = parse_client_message(text);
      if (std::holds_alternative<FollowRequest>(message)) return follow();
      const auto* const request = std::get_if<PictureRequest>(&message);
      if (request != nullptr && shared_.link.has(*id_)) shared_.link.show(*request);
      shared_.painter.take(*id_, message);
    } catch (const Error& error) {
      send(dump(Json{{"error", error.what()}}));
    }
  }

  void follow() {
    shared_.link.add(*id_, [weak = this->weak_from_this()](std::string text) {
      if (const auto self = weak.lock()) self->send(std::move(text));
    });
  }

  void send(Message message) {
    if (const auto* const text = std::get_if<std::string>(&message))
      if (id_ && shared_.link.has(*id_) && text->starts_with(R"({"error")")) shared_.link.report(*text);
    const std::size_t bytes = std::visit([](const auto& each) { return each.size(); }, message);
    bytes_waiting_ += bytes;
    if (bytes_waiting_ > most_bytes_waiting || waiting_.size() == most_messages_waiting)
      return beast::get_lowest_layer(socket_).close();
    waiting_.push_back(std::move(message));
    if (waiting_.size() == 1) write();
  }

  /// Writes one message at a time.
  void write() {
    const Message& message = waiting_.front();
    socket_.text(std::holds_alternative<std::string>(message));
    const asio::const_buffer bytes =
        std::visit([](const auto& each) { return asio::const_buffer(each.data(), each.size()); }, message);
    socket_.async_write(bytes, [self = this->shared_from_this()](Code error, std::size_t written) {
      if (error) return;
      self->bytes_waiting_ -= written;
      self->waiting_.pop_front();
      if (!self->waiting_.empty()) self->write();
    });
  }

  Shared& shared_;
  websocket::stream<beast::basic_stream<Protocol>> socket_;
  beast::flat_buffer buffer_{view_limits::message_bytes};
  std::deque<Message> waiting_;
  std::size_t bytes_waiting_ = 0;
  std::optional<Painter::ClientId> id_;
};

/// A connection until its one request is answered, or becomes a WebSocket.
template <class Protocol>
class Connection : public std::enable_shared_from_this<Connection<Protocol>> {
 public:
  Connection(Shared& shared, typename Protocol::socket socket) : shared_(shared), stream_(std::move(socket)) {
    ++shared_.connection_count;
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { --shared_.connection_count; }

  void start() {
    parser_.header_limit(most_header_bytes);
    parser_.body_limit(std::numeric_limits<std::uint64_t>::max());  // no body is read
    stream_.expires_after(longest_silence);
    http::async_read_header(stream_, buffer_, parser_, [self = this->shared_from_this()](Code error, std::size_t) {
      if (!error) self->answer_request();
    });
  }

 private:
  void answer_request() {
    const Request& request = parser_.get();
    if (!websocket::is_upgrade(request)) return respond(answer(request, shared_.admission));
    const std::string host = text_of(request[http::field::host]), origin = text_of(request[http::field::origin]);
    const Admission& admission = shared_.admission;
    if (!admission.is_own_origin(origin, host))
      return respond(plain(http::status::forbidden, "this server answers to its own page only"));
    if (!admission.has_token(text_of(request[http::field::sec_websocket_protocol])))
      return respond(plain(http::status::unauthorized, "the token of the printed URL is missing or wrong"));
    if (text_of(request.target()) != "/ws") return respond(plain(http::status::not_found, "there is no such page"));
    if (shared_.client_count >= most_clients)
      return respond(plain(http::status::service_unavailable, "too many viewers are open"));
    std::make_shared<Session<Protocol>>(shared_, std::move(stream_))->start(request);
  }

  void respond(Response response) {
    add_safety(response);
    response_ = std::move(response);
    http::async_write(stream_, response_, [self = this->shared_from_this()](Code, std::size_t) {
      Code ignored;
      self->stream_.socket().shutdown(Protocol::socket::shutdown_send, ignored);
      self->buffer_.clear();
      if (!self->parser_.is_done()) self->pass_over_body();
    });
  }

  /// Drops what the client still sends, until it ends or its time is over: closing the connection
  /// before would take the answer back.
  void pass_over_body() {
    stream_.async_read_some(buffer_.prepare(most_header_bytes),
                            [self = this->shared_from_this()](Code error, std::size_t) {
                              if (!error) self->pass_over_body();
                            });
  }

  Shared& shared_;
  beast::basic_stream<Protocol> stream_;
  beast::flat_buffer buffer_{most_header_bytes};
  http::request_parser<http::empty_body> parser_;
  Response response_;
};

template <class Protocol>
void accept(Shared& shared, typename Protocol::acceptor& acceptor) {
  acceptor.async_accept([&](Code error, typename Protocol::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && shared.connection_count < most_connections) {
      if constexpr (std::is_same_v<Protocol, asio::ip::tcp>) {
        Code ignored;  // a small message does not wait until the one before has arrived
        socket.set_option(asio::ip::tcp::no_delay(true), ignored);
      }
      std::make_shared<Connection<Protocol>>(shared, std::move(socket))->start();
    }
    accept<Protocol>(shared, acceptor);
  });
}

}  // namespace

class Server::Implementation {
 public:
  using Tcp = asio::ip::tcp;
  using Unix = asio::local::stream_protocol;

  Implementation(ViewedScene viewed, const ServerOptions& options)
      : shared_(std::move(viewed), options), socket_path_(options.socket) {
    shared_.admission.token = random_token();
    shared_.admission.proxies = options.allowed_hosts;
    if (socket_path_.empty())
      listen(options.port);
    else
      listen_on_socket(options.port);
  }

  ~Implementation() {
    if (unix_) ::unlink(socket_path_.c_str());
  }

  std::string url() const {
    return concat("http://127.0.0.1:", shared_.admission.port, "/#token=", shared_.admission.token);
  }
  std::uint16_t port() const { return shared_.admission.port; }
  std::string hello() const { return shared_.painter.hello(); }
  void set(const ViewState& state) {
    asio::post(shared_.context, [this, state] { shared_.link.set(state); });
  }

  void run(const std::stop_token& stop) {
    const std::stop_callback stopping(stop, [this] { shared_.context.stop(); });
    if (tcp_) accept<Tcp>(shared_, *tcp_);
    if (unix_) accept<Unix>(shared_, *unix_);
    shared_.context.run();
  }

 private:
  void listen(std::uint16_t port) {
    try {
      tcp_.emplace(shared_.context, Tcp::endpoint(asio::ip::address_v4::loopback(), port));
      shared_.admission.port = tcp_->local_endpoint().port();
    } catch (const boost::system::system_error& error) {
      throw Error(ErrorCode::resource, concat("--port ", port, ": ", error.code().message()));
    }
  }

  void listen_on_socket(std::uint16_t tunnel_port) {
    const mode_t old_mask = ::umask(0177);  // the socket is born with mode 0600
    try {
      unix_.emplace(shared_.context, Unix::endpoint(socket_path_.string()));
    } catch (const boost::system::system_error& error) {
      ::umask(old_mask);
      const bool is_there = error.code() == asio::error::address_in_use;
      throw Error(ErrorCode::resource, concat(socket_path_.string(), ": ", error.code().message(),
                                              is_there ? "; if no viewer uses it any more, remove it" : ""));
    }
    ::umask(old_mask);
    shared_.admission.port = tunnel_port != 0 ? tunnel_port : usual_tunnel_port;
  }

  Shared shared_;
  std::filesystem::path socket_path_;
  std::optional<Tcp::acceptor> tcp_;
  std::optional<Unix::acceptor> unix_;
};

Server::Server(ViewedScene viewed, const ServerOptions& options)
    : implementation_(std::make_unique<Implementation>(std::move(viewed), options)) {}
Server::~Server() = default;

std::string Server::url() const {
  return implementation_->url();
}
std::uint16_t Server::port() const {
  return implementation_->port();
}
std::string Server::hello() const {
  return implementation_->hello();
}
void Server::set(const ViewState& state) {
  implementation_->set(state);
}
void Server::run(const std::stop_token& stop) {
  implementation_->run(stop);
}

}  // namespace rhoray::tools
