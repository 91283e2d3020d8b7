#include "tools/view/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <boost/asio/local/stream_protocol.hpp>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "formats/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/tools/view/running_server.h"
#include "tools/view/page.h"

namespace rhoray::tests {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;
using tools::Server;

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
  std::vector<std::string> paths{"/index.html", "/ws", "/view.js/..", "/view.js?x", "/.git/config", "http://evil.com/"};
  for (const char* way : {"/..", "/../..", "//", "/./", "/%2e%2e", "/..%2f..", "/..%5c", "/....//", "/%252e%252e",
                          "/%00", "/view.js/../.."})
    for (const char* file : {"/etc/passwd", "/proc/self/environ", "/box.rho", "etc/shadow", "%2fetc%2fpasswd"})
      paths.push_back(concat(way, file));
  for (const std::string& path : paths) {
    const http::status status = running.answer(http::verb::get, path).result();
    EXPECT_EQ(status, http::status::not_found) << path;
  }
  for (const std::size_t body_bytes : {0, 1, 3'000'000})
    EXPECT_EQ(running.answer(http::verb::post, "/", {}, std::string(body_bytes, 'x')).result(),
              http::status::method_not_allowed);
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
