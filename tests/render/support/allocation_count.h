#pragma once

#include <cstddef>

namespace rhoray::tests {

/// Returns the number of calls of operator new in this program so far, from all threads.
std::size_t allocation_count();

}  // namespace rhoray::tests
