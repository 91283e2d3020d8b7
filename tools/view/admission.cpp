#include "tools/view/admission.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::tools {

bool Admission::is_own_host(std::string_view host) const {
  if (host == concat("127.0.0.1:", port) || host == concat("localhost:", port)) return true;
  return std::any_of(proxies.begin(), proxies.end(), [&](const std::string& proxy) {
    return host == proxy || host.starts_with(proxy + ":");  // proxies have ports of their own
  });
}

bool Admission::is_own_origin(std::string_view origin, std::string_view host) const {
  const bool is_same = origin == concat("http://", host) || (!proxies.empty() && origin == concat("https://", host));
  return is_own_host(host) && is_same;
}

bool Admission::has_token(std::string_view subprotocols) const {
  bool has_protocol = false, has_token = false;
  while (!subprotocols.empty()) {
    const std::size_t comma = std::min(subprotocols.find(','), subprotocols.size());
    std::string_view word = subprotocols.substr(0, comma);
    subprotocols.remove_prefix(std::min(comma + 1, subprotocols.size()));
    while (!word.empty() && (word.front() == ' ' || word.front() == '\t')) word.remove_prefix(1);
    while (!word.empty() && (word.back() == ' ' || word.back() == '\t')) word.remove_suffix(1);
    has_protocol |= word == view_protocol;
    has_token |= equal_in_constant_time(word, token);
  }
  return has_protocol && has_token && !token.empty();
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error(ErrorCode::resource, concat("getrandom: ", std::system_category().message(errno)));
  std::string text;
  for (const unsigned char byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  return difference == 0;
}

}  // namespace rhoray::tools
