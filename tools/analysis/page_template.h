#pragma once

#include <string>
#include <string_view>

#include "formats/base/json.h"

namespace rhoray::tools {

/// Escapes what HTML would interpret; `words` become code.
std::string html_text(std::string_view text);
/// Formats numbers such as 4.2e-07 for readers: 4.2 × 10<sup>−7</sup>. Code is unchanged.
std::string with_powers(std::string_view html);
std::string base64(std::string_view bytes);  ///< RFC 4648

/// Like `rounded`, but whole numbers below ten million in full: 1170, not 1.17e+03.
std::string short_number(double number, int digits);

/// Fills a template of HTML with values.
///
/// {{name}} is a value as text, {{name|3}} a number with 3 digits. Other formats: `grouped`
/// (72,089,600), `bytes` (1.5 MiB), `powers` (text whose numbers become powers of ten), `html` (as
/// it is). Null becomes a dash. {{.}} is the item itself.
///
/// {{#name}} ... {{/name}} is repeated for every item of a list. With another value it appears
/// once, but not at all if the value is missing, null, false or empty. {{^name}} ... {{/name}}
/// appears in these cases. Names are looked up in the item, then in what surrounds it. A name in
/// {{name}} that does not exist is an error (ErrorCode::internal).
std::string fill_template(std::string_view text, const Json& values);

}  // namespace rhoray::tools
