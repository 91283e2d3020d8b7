#pragma once

#include <cstring>

namespace rhoray::tests {

/// Whether two vectors or spans have the same bytes: -0 and 0 differ, and a NaN equals itself.
template <class A, class B>
bool equal_bytes(const A& a, const B& b) {
  static_assert(sizeof(*a.data()) == sizeof(*b.data()));
  // memcmp takes no null pointer, not even for no bytes.
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(*a.data())) == 0);
}

}  // namespace rhoray::tests
