#pragma once

#include <string>
#include <string_view>

namespace rhoray::tools {

/// Escapes what HTML would interpret; `words` become code.
std::string html_text(std::string_view text);
/// Formats numbers such as 4.2e-07 for readers: 4.2 × 10<sup>−7</sup>. Code is unchanged.
std::string with_powers(std::string_view html);
std::string base64(std::string_view bytes);  ///< RFC 4648

/// A self-contained page that loads nothing (its policy forbids it).
std::string html_page(const std::string& title, const std::string& body);

}  // namespace rhoray::tools
