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

namespace {

/// Whether this is one of the names, with any port or none.
bool names_one_of(const std::vector<std::string>& names, std::string_view host) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    if (!host.starts_with(name)) return false;
    const std::string_view rest = host.substr(name.size());
    return rest.empty() || (rest.front() == ':' && rest.find_first_not_of("0123456789", 1) == std::string_view::npos);
  });
}

}  // namespace

bool Admission::is_own_host(std::string_view host) const {
  if (host == concat("127.0.0.1:", port) || host == concat("localhost:", port)) return true;
  return names_one_of(proxies, host);
}

bool Admission::is_own_origin(std::string_view origin, std::string_view host) const {
  if (!is_own_host(host)) return false;
  if (origin == concat("http://", host)) return true;
  for (const std::string_view scheme : {"http://", "https://"})
    if (origin.starts_with(scheme) && names_one_of(proxies, origin.substr(scheme.size()))) return true;
  return false;
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
