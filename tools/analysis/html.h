#pragma once

#include <string>
#include <string_view>

namespace rhoray::tools {

std::string html_text(std::string_view text);  ///< with what HTML reads as its own escaped; `words` become code
/// Numbers such as 4.2e-07 as people write them: 4.2 × 10<sup>−7</sup>. Code stays as it is.
std::string with_powers(std::string_view html);
std::string base64(std::string_view bytes);  ///< RFC 4648

/// A page that needs nothing beside itself and sends for nothing (its policy forbids it).
std::string html_page(const std::string& title, const std::string& body);

}  // namespace rhoray::tools
