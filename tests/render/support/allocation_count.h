#pragma once

#include <cstddef>

namespace rhoray::tests {

/// How often this program has called operator new so far, from any thread.
std::size_t allocation_count();

}  // namespace rhoray::tests
