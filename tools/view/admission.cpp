#include "tools/view/admission.h"

#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "formats/base/error.h"
#include "formats/base/lower_case.h"
#include "formats/base/read_value.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

/// The name before the port, if there is one; an IPv6 address stands in brackets.
std::string_view without_port(std::string_view host) {
  const std::size_t colon = host.find(':', host.starts_with('[') ? std::min(host.find(']'), host.size()) : 0);
  const bool has_port = colon + 1 < host.size() && host.find_first_not_of("0123456789", colon + 1) == host.npos;
  return colon != host.npos && has_port ? host.substr(0, colon) : host;
}

bool is_host_name(std::string_view name) {
  if (name.starts_with('[') && name.ends_with(']') && name.size() > 2)
    return name.find_first_not_of("0123456789abcdef:.", 1) == name.size() - 1;
  return !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-._") == name.npos;
}

/// @param host  in lower case
bool names_one_of(const std::vector<HostName>& names, std::string_view host) {
  return std::any_of(names.begin(), names.end(),
                     [&](const HostName& name) { return host == name.text || without_port(host) == name.text; });
}

}  // namespace

void read_value(const std::string& text, std::vector<HostName>& out) {
  std::vector<std::string> names;
  rhoray::read_value(text, names);
  for (const std::string& name : names) {
    HostName host{lower_case(name)};
    if (!is_host_name(without_port(host.text)))
      refuse_value(name, "a host name such as hub.example.org, or with a port, hub.example.org:8443");
    out.push_back(std::move(host));
  }
}

bool Admission::is_own_host(std::string_view any_case) const {
  const std::string host = lower_case(any_case);
  if (host == concat("127.0.0.1:", port) || host == concat("localhost:", port)) return true;
  return names_one_of(proxies, host);
}

bool Admission::is_own_origin(std::string_view any_case, std::string_view host_in_any_case) const {
  if (!is_own_host(host_in_any_case)) return false;
  const std::string origin = lower_case(any_case), host = lower_case(host_in_any_case);
  if (origin == concat("http://", host)) return true;
  for (const std::string_view scheme : {"http://", "https://"})
    if (origin.starts_with(scheme) && names_one_of(proxies, std::string_view(origin).substr(scheme.size())))
      return true;
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
