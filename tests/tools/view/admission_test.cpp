#include "tools/view/admission.h"

#include <gtest/gtest.h>

#include <set>

namespace rhoray::tests {
namespace {

using tools::Admission;

TEST(Admission, takes_its_own_host_and_port_only) {
  const Admission admission{.port = 4711, .token = "t"};
  for (const char* host : {"127.0.0.1:4711", "localhost:4711"}) EXPECT_TRUE(admission.is_own_host(host)) << host;
  for (const char* host : {"", "127.0.0.1", "127.0.0.1:4712", "127.0.0.1:47111", "evil.com", "evil.com:4711",
                           "localhost.evil.com:4711", "127.0.0.1.evil.com:4711", "LOCALHOST:4711 ", "[::1]:4711"})
    EXPECT_FALSE(admission.is_own_host(host)) << host;
  const Admission behind_proxy{.port = 4711, .proxies = {"hub.example.org"}, .token = "t"};
  EXPECT_TRUE(behind_proxy.is_own_host("hub.example.org"));
  EXPECT_TRUE(behind_proxy.is_own_host("hub.example.org:8443"));
  EXPECT_FALSE(behind_proxy.is_own_host("hub.example.org.evil.com"));
  EXPECT_FALSE(behind_proxy.is_own_host("hub.example.org:8443.evil.com"));
  EXPECT_FALSE(behind_proxy.is_own_host("127.0.0.1"));
  EXPECT_TRUE(behind_proxy.is_own_origin("https://hub.example.org", "hub.example.org"));
  EXPECT_FALSE(behind_proxy.is_own_origin("https://evil.com", "hub.example.org"));
  // Some proxies replace Host by the address of the server.
  EXPECT_TRUE(behind_proxy.is_own_origin("https://hub.example.org:8443", "127.0.0.1:4711"));
  EXPECT_TRUE(behind_proxy.is_own_origin("http://127.0.0.1:4711", "127.0.0.1:4711"));
  for (const char* origin : {"https://evil.com", "https://hub.example.org.evil.com", "https://127.0.0.1:4711",
                             "ftp://hub.example.org", "hub.example.org", "https://hub.example.org/"})
    EXPECT_FALSE(behind_proxy.is_own_origin(origin, "127.0.0.1:4711")) << origin;
}

TEST(Admission, takes_an_origin_that_is_there_and_names_the_own_host) {
  const Admission admission{.port = 4711, .token = "t"};
  EXPECT_TRUE(admission.is_own_origin("http://127.0.0.1:4711", "127.0.0.1:4711"));
  for (const auto& [origin, host] :
       {std::pair("", "127.0.0.1:4711"),
        {"null", "127.0.0.1:4711"},
        {"http://evil.com:4711", "127.0.0.1:4711"},
        {"http://evil.com:4711", "evil.com:4711"},  // a name of theirs that means this machine
        {"https://127.0.0.1:4711", "127.0.0.1:4711"},
        {"http://127.0.0.1:4712", "127.0.0.1:4711"},
        {"http://127.0.0.1:4711/", "127.0.0.1:4711"},
        {"http://localhost:4711", "127.0.0.1:4711"}})
    EXPECT_FALSE(admission.is_own_origin(origin, host)) << origin << " at " << host;
}

TEST(Admission, wants_the_token_beside_the_protocol) {
  const Admission admission{.port = 1, .token = "0123abcd"};
  EXPECT_TRUE(admission.has_token("rhoray.1, 0123abcd"));
  EXPECT_TRUE(admission.has_token("rhoray.1,0123abcd"));
  for (const char* protocols : {"", "rhoray.1", "0123abcd", "rhoray.1, 0123abce", "rhoray.1, 0123abc",
                                "rhoray.1, 0123abcd0", "rhoray.1 0123abcd", "rhoray.2, 0123abcd", ",,,"})
    EXPECT_FALSE(admission.has_token(protocols)) << protocols;
  EXPECT_FALSE((Admission{.port = 1, .token = ""}).has_token("rhoray.1, "));
}

TEST(Admission, draws_tokens_of_128_bits_that_differ) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    tokens.insert(tools::random_token());
    EXPECT_EQ(tokens.begin()->size(), 32U);
  }
  EXPECT_EQ(tokens.size(), 100U);
}

}  // namespace
}  // namespace rhoray::tests
