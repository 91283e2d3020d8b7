#include "tools/view/admission.h"

#include <gtest/gtest.h>

#include <set>

#include "formats/base/error.h"

namespace rhoray::tests {
namespace {

using tools::Admission;

TEST(Admission, takes_its_own_host_and_port_only) {
  const Admission admission{.port = 4711, .token = "t"};
  for (const char* host : {"127.0.0.1:4711", "localhost:4711"}) EXPECT_TRUE(admission.is_own_host(host)) << host;
  for (const char* host : {"", "127.0.0.1", "127.0.0.1:4712", "127.0.0.1:47111", "evil.com", "evil.com:4711",
                           "localhost.evil.com:4711", "127.0.0.1.evil.com:4711", "LOCALHOST:4711 ", "[::1]:4711"})
    EXPECT_FALSE(admission.is_own_host(host)) << host;
  const Admission behind_proxy{.port = 4711, .proxies = {{"hub.example.org"}}, .token = "t"};
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

TEST(Admission, does_not_tell_capitals_apart_in_host_names) {
  std::vector<tools::HostName> proxies;
  read_value("Hub.Example.org,other.example.org:8443", proxies);
  const Admission admission{.port = 4711, .proxies = proxies, .token = "t"};
  for (const char* host : {"hub.example.org", "HUB.example.ORG", "Hub.Example.org:8443", "Other.Example.org:8443"})
    EXPECT_TRUE(admission.is_own_host(host)) << host;
  for (const char* host : {"other.example.org", "other.example.org:8444", "other.example.org:8443:1"})
    EXPECT_FALSE(admission.is_own_host(host)) << host;
  EXPECT_TRUE(admission.is_own_host("LocalHost:4711"));
  EXPECT_TRUE(admission.is_own_origin("https://HUB.example.org", "hub.example.org"));
}

TEST(Admission, refuses_what_is_no_host_name) {
  std::vector<tools::HostName> proxies;
  for (const char* text : {"https://hub.example.org", "hub.example.org/", "hub.example.org:", "hub.example.org:port",
                           "hub.example.org:1:2", ":8443", "hub example.org", "*.example.org", "a,,b", ""}) {
    try {
      read_value(text, proxies);
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage);
    }
  }
  for (const char* text : {"hub", "hub-1.example.org", "10.0.0.7:80", "[::1]", "[fe80::1]:8443"})
    EXPECT_NO_THROW(read_value(text, proxies)) << text;
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
