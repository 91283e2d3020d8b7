#pragma once

#include <cstddef>
#include <span>

namespace rhoray::study {

/// Replaces the mapping that contains these bytes by a copy: anonymous memory with a request for
/// huge pages, at the same addresses. The mapped content stays valid and unchanged; it only no
/// longer comes from its file.
/// @return  bytes held by huge pages according to the operating system; 0 where there are none
std::size_t move_to_huge_pages(std::span<const std::byte> bytes);

}  // namespace rhoray::study
