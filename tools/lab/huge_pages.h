#pragma once

#include <cstddef>
#include <span>

namespace rhoray::study {

/// Puts a copy of the mapping that holds these bytes in its place: anonymous memory that asks for huge pages, at the
/// same addresses. What was mapped stays valid and unchanged; it just no longer comes from its file.
/// @return  bytes that huge pages hold, as the system says; 0 where there are none
std::size_t move_to_huge_pages(std::span<const std::byte> bytes);

}  // namespace rhoray::study
