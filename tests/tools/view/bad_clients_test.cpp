// Clients that lie, flood, stall, and leave at the wrong time: the others still get pictures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <random>
#include <vector>

#include "tests/tools/view/running_server.h"

namespace rhoray::tests {
namespace {

/// Asks for a picture and waits for it.
void expect_picture(Page& page, std::uint32_t number) {
  page.ask(number);
  while (page.picture() != number) {
  }
}

/// Closes the connection at once: what is under way is lost (TCP's RST).
void leave_at_once(Tcp::socket& socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  socket.close();
}

/// A client's frame. The mask is 0, so the text stays readable.
std::string frame(unsigned char first, const std::string& text, bool has_mask = true) {
  return std::string{static_cast<char>(first), static_cast<char>((has_mask ? 0x80U : 0U) | text.size())} +
         (has_mask ? std::string(4, '\0') : "") + text;
}

std::size_t resident_bytes() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  return pages * 4096;
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
    expect_picture(good, ++number);
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
  expect_picture(good, ++number);
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
  expect_picture(good, 2);
  unsigned status = 503;
  for (int tries = 0; tries < 100 && status == 503; ++tries) {  // until the one that left is noticed
    status = running.handshake(running.host(), "http://" + running.host(), "rhoray.1, " + running.token());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(status, 101U);
}

TEST(ViewServer, takes_a_message_in_pieces) {
  Running running;
  Page page(running);
  page.text();
  const std::string right = R"({"n": 1, "size": [8, 8], "moving": true})";
  page.say_in_fragments(right);
  EXPECT_EQ(page.picture(), 1U);
  for (const char byte : frame(0x81, R"({"n": 2, "size": [8, 8], "moving": true})"))
    asio::write(page.connection(), asio::buffer(&byte, 1));
  EXPECT_EQ(page.picture(), 2U);
}

TEST(ViewServer, ends_only_the_connection_whose_frames_are_wrong) {
  Running running;
  Page good(running);
  std::uint32_t number = 0;
  const std::pair<const char*, std::string> cases[] = {
      {"without a mask", frame(0x81, "{}", false)},
      {"a reserved opcode", frame(0x83, "{}")},
      {"a reserved bit", frame(0xc1, "{}")},
      {"a continuation of nothing", frame(0x80, "{}")},
      {"a ping of 126 bytes", frame(0x89, std::string(126, 'x'))},
      {"a text that is no UTF-8", frame(0x81, "\xff\xfe")},
      {"2^63 bytes", std::string("\x81\xff\x80\0\0\0\0\0\0\0", 10) + std::string(4, '\0')}};
  for (const auto& [name, bytes] : cases) {
    Page bad(running);
    bad.text();
    asio::write(bad.connection(), asio::buffer(bytes));
    EXPECT_THROW(bad.text(), boost::system::system_error) << name;
    expect_picture(good, ++number);
  }
}

TEST(ViewServer, serves_others_when_clients_leave_in_the_middle_of_a_frame) {
  Running running;
  Page good(running);
  for (std::uint32_t number = 1; number <= 20; ++number) {
    Page of_half_a_frame(running), of_half_a_picture(running);
    asio::write(of_half_a_frame.connection(), asio::buffer(frame(0x81, R"({"n": 1, "size": [8, 8]})").substr(0, 10)));
    of_half_a_picture.say(R"({"n": 1, "size": [2000, 2000], "moving": true})");
    if (number % 2 == 0) of_half_a_picture.text();
    leave_at_once(of_half_a_frame.connection());
    leave_at_once(of_half_a_picture.connection());
    expect_picture(good, number);
  }
}

TEST(ViewServer, closes_the_connection_of_a_client_that_does_not_read) {
  Running running;
  Page good(running), bad(running);
  // How many messages the buffers of the connection hold depends on the machine.
  const auto flood = [&, end = std::chrono::steady_clock::now() + std::chrono::minutes(2)] {
    while (std::chrono::steady_clock::now() < end) bad.say(R"({"wrong": true})");
  };
  EXPECT_THROW(flood(), boost::system::system_error);
  expect_picture(good, 1);
}

TEST(ViewServer, lets_a_client_in_once_half_open_connections_have_been_closed) {
  Running running;
  Page good(running);
  const std::size_t before = resident_bytes();
  std::vector<Tcp::socket> idle;
  for (int i = 0; i < 200; ++i) {
    idle.push_back(running.connected());
    if (i % 2 == 0) asio::write(idle.back(), asio::buffer("GET /ws HT", 10));
  }
  // The server takes 64 connections, and closes one that says nothing for 10 s.
  std::unique_ptr<Page> late;
  for (std::uint32_t number = 1; !late && number < 600; ++number) {
    expect_picture(good, number);
    try {
      late = std::make_unique<Page>(running);
    } catch (const boost::system::system_error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  ASSERT_TRUE(late);
  expect_picture(*late, 1);
  EXPECT_LE(resident_bytes(), before + (32U << 20));
}

}  // namespace
}  // namespace rhoray::tests
