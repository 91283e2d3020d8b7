#include "tools/view/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "formats/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/tools/view/viewed.h"
#include "tools/view/page.h"

namespace rhoray::tests {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Json = nlohmann::json;
using Tcp = asio::ip::tcp;
using testing::HasSubstr;
using tools::Server;

/// A server on a thread of its own.
class Running {
 public:
  explicit Running(const tools::ServerOptions& options = {})
      : server_(viewed_box(folder_), options), thread_([this](const std::stop_token& stop) { server_.run(stop); }) {}

  Server& server() { return server_; }
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
                                           std::optional<std::string> other_host = {}) {
    Tcp::socket socket = connected();
    http::request<http::empty_body> request{verb, target, 11};
    request.set(http::field::host, other_host.value_or(host()));
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
  Server server_;
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

TEST(ViewServer, serves_its_page_and_nothing_else) {
  Running running;
  EXPECT_THAT(running.server().url(), testing::MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/#token=[0-9a-f]{32}"));
  std::size_t bytes = 0;
  ASSERT_GE(tools::page_files().size(), 4U);
  for (const tools::PageFile& file : tools::page_files()) {
    const std::string path(file.path);
    const auto page = running.answer(http::verb::get, path);
    EXPECT_EQ(page.result(), http::status::ok) << path;
    EXPECT_EQ(page[http::field::content_type], std::string(file.type));
    EXPECT_EQ(page.body(), file.content);
    EXPECT_THAT(std::string(page["Content-Security-Policy"]), HasSubstr("default-src 'none'"));
    EXPECT_EQ(page["X-Content-Type-Options"], "nosniff");
    bytes += page.body().size();
    for (const char* foreign : {"http://", "https://"})
      EXPECT_EQ(page.body().find(foreign, page.body().find("xmlns=") == std::string::npos ? 0 : 40), std::string::npos)
          << path << " asks others for something";
    EXPECT_TRUE(running.answer(http::verb::head, path).body().empty());
  }
  EXPECT_LE(bytes, 150U << 10);
  for (const char* path : {"/index.html", "/ws", "/../etc/passwd", "//etc/passwd", "/%2e%2e/etc/passwd", "/view.js/..",
                           "/view.js?x", "/..%2f..%2fetc%2fpasswd", "/.git/config", "http://evil.com/"})
    EXPECT_EQ(running.answer(http::verb::get, path).result(), http::status::not_found) << path;
  EXPECT_EQ(running.answer(http::verb::post, "/").result(), http::status::method_not_allowed);
  for (const char* host : {"evil.com", "", "127.0.0.1", "127.0.0.1:1"})
    EXPECT_EQ(running.answer(http::verb::get, "/", host).result(), http::status::forbidden) << host;
}

TEST(ViewServer, lets_in_only_its_own_page_with_the_token) {
  Running running;
  const std::string own = running.host(), origin = "http://" + own, token = "rhoray.1, " + running.token();
  const std::string wrong_token = "rhoray.1, " + std::string(32, '0');
  for (const std::string& host : {own, std::string("evil.com"), concat("evil.com:", running.server().port())})
    for (const std::string& from : {origin, std::string(), std::string("null"), "http://" + host + ".evil.com",
                                    concat("http://evil.com:", running.server().port())})
      for (const std::string& protocols : {token, wrong_token, std::string("rhoray.1"), std::string()}) {
        const bool is_right = host == own && from == origin && protocols == token;
        const unsigned status = running.handshake(host, from, protocols);
        EXPECT_EQ(status == 101, is_right) << host << " | " << from << " | " << protocols << " | " << status;
        EXPECT_TRUE(is_right || status == 401 || status == 403) << status;
      }
  EXPECT_EQ(running.handshake(own, origin, token, "/other"), 404U);
}

TEST(ViewServer, says_hello_and_sends_pictures) {
  Running running;
  Page page(running);
  const Json hello = Json::parse(page.text()).at("hello");
  EXPECT_EQ(hello["title"], "box");
  EXPECT_EQ(hello["document"]["layers"]["0"]["isovalue"], 0.8);
  EXPECT_EQ(hello["data"]["data"]["kind"], "mesh");
  EXPECT_EQ(hello["data"]["data"]["fields"], Json({"distance", "x"}));
  for (std::uint32_t n = 1; n <= 20; ++n) {
    page.ask(n);
    while (page.picture() != n) {
    }
  }
  page.say(R"({"keep": true})");
  std::string text = page.text();
  while (text.find("keep") == std::string::npos) text = page.text();
  EXPECT_THAT(text, HasSubstr(R"("command":"iso 0.8")"));
}

/// Messages to the program that started a server.
class Told {
 public:
  void add(std::string text) {
    const std::lock_guard lock(mutex_);
    texts_.push_back(std::move(text));
    changed_.notify_one();
  }
  /// The next message; an empty one after a minute.
  Json next() {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, std::chrono::minutes(1), [&] { return !texts_.empty(); })) return {};
    Json json = Json::parse(texts_.front());
    texts_.pop_front();
    return json;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> texts_;
};

TEST(ViewServer, shares_a_views_state_with_the_program_that_started_it) {
  Told told;
  Running running({.tell_program = [&](std::string text) { told.add(std::move(text)); }});
  const auto next_set = [](Page& page) {
    for (;;)
      if (const Json message = Json::parse(page.text()); message.contains("set")) return message["set"];
  };
  const auto ask = [](Page& page, int n, double isovalue, int set) {
    page.say(concat(R"({"n": )", n, R"(, "size": [8, 8], "moving": true, "set": )", set,
                    R"(, "scene": {"layers": {"0": {"isovalue": )", isovalue, "}}}}"));
  };
  Page page(running), other(running);
  ask(other, 1, 0.1, 0);  // does not follow, and is not told about
  page.say(R"({"follow": true})");
  ask(page, 1, 0.5, 0);
  const Json first = told.next()["state"];
  EXPECT_EQ(first["scene"]["layers"]["0"]["isovalue"], 0.5);
  EXPECT_EQ(first["size"], Json({8, 8}));
  EXPECT_EQ(first["moving"], true);
  EXPECT_EQ(first["n"], 0);

  running.server().set(tools::parse_program_message(R"({"set": {"n": 1, "scene": {"style": "fast"}}})"));
  const Json set = next_set(page);
  EXPECT_EQ(set, Json({{"n", 1}, {"scene", {{"style", "fast"}}}}));
  ask(page, 2, 0.6, 0);  // was sent before the page knew of it
  ask(page, 3, 0.7, 1);
  EXPECT_EQ(told.next()["state"]["scene"]["layers"]["0"]["isovalue"], 0.7);

  Page late(running);
  late.say(R"({"follow": true})");
  EXPECT_EQ(next_set(late)["scene"]["layers"]["0"]["isovalue"], 0.7) << "a page that comes later shows the same";

  page.say(R"({"n": 4, "size": [8, 8], "set": 1, "scene": {"colour": 1}})");
  EXPECT_TRUE(told.next().contains("state"));
  while (page.text().find("error") == std::string::npos) {
  }
  EXPECT_THAT(told.next()["error"].get<std::string>(), HasSubstr("colour"));
}

TEST(ViewServer, survives_what_clients_send) {
  Running running;
  Page good(running), bad(running);
  good.text(), bad.text();
  std::mt19937_64 random(7);
  const std::string right = R"({"n": 1, "size": [8, 8], "moving": true, "scene": {"style": "fast"}})";
  const std::string seeds[] = {right, R"({"ack": 1})", R"({"probe": [1, 2], "id": 3})", R"({"keep": true})",
                               R"({"follow": true})"};
  const int count = message_count(2000), batch = 100;
  std::uint32_t number = 0;
  for (int i = 0; i < count; i += batch) {
    for (int k = 0; k < batch; ++k) bad.say(mutated(seeds[random() % 5], random));
    // A right request and a probe of it are answered whatever came before.
    bad.say(right);
    bad.say(concat(R"({"probe": [0, 0], "id": )", 1'000'000'000 + i, "}"));
    const std::string answer = concat("\"id\":", 1'000'000'000 + i);
    while (bad.text().find(answer) == std::string::npos) {
    }
    ++number;
    good.ask(number);
    while (good.picture() != number) {
    }
  }
  bad.say_bytes("\x01\x02");
  while (bad.text().find("expected text") == std::string::npos) {
  }
  // A message that is too long ends its connection only.
  EXPECT_THROW(
      {
        bad.say(std::string(70000, ' '));
        for (;;) bad.text();
      },
      boost::system::system_error);
  good.ask(++number);
  while (good.picture() != number) {
  }
}

TEST(ViewServer, serves_a_client_beside_half_open_connections_and_takes_eight) {
  Running running;
  Page good(running);
  good.text();
  {
    std::vector<Tcp::socket> idle;
    for (int i = 0; i < 200; ++i) idle.push_back(running.connected());
    good.ask(1, 64);
    EXPECT_EQ(good.picture(), 1U);
  }
  std::vector<std::unique_ptr<Page>> others;
  for (int i = 0; i < 7; ++i) others.push_back(std::make_unique<Page>(running));
  EXPECT_EQ(running.handshake(running.host(), "http://" + running.host(), "rhoray.1, " + running.token()), 503U);
  others.pop_back();
  good.ask(2);
  while (good.picture() != 2) {
  }
  unsigned status = 503;
  for (int tries = 0; tries < 100 && status == 503; ++tries) {  // until the one that left is noticed
    status = running.handshake(running.host(), "http://" + running.host(), "rhoray.1, " + running.token());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(status, 101U);
}

TEST(ViewServer, refuses_a_port_that_is_taken) {
  Running running;
  const TemporaryFolder folder;
  expect_error(ErrorCode::resource, concat("--port ", running.server().port()),
               [&] { Server(viewed_box(folder), {.port = running.server().port()}); });
}

TEST(ViewServer, listens_on_a_socket_that_only_its_user_may_open) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "s.sock";
  {
    Running running({.socket = path});
    struct stat facts {};
    ASSERT_EQ(::stat(path.c_str(), &facts), 0);
    EXPECT_EQ(facts.st_mode & 0777, 0600U);
    asio::io_context context;
    asio::local::stream_protocol::socket socket(context);
    socket.connect(path.string());
    http::request<http::empty_body> request{http::verb::get, "/", 11};
    request.set(http::field::host, "localhost:8123");
    http::write(socket, request);
    beast::flat_buffer buffer;
    http::response<http::string_body> response;
    http::read(socket, buffer, response);
    EXPECT_EQ(response.result(), http::status::ok);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace rhoray::tests
