#include "formats/format_error.h"

#include "formats/base/printable.h"

namespace rhoray::formats {
namespace {

/// Long text is cut.
std::string shown(std::string_view text) {
  constexpr std::size_t most = 600;
  return printable(text.substr(0, most)) + (text.size() > most ? "..." : "");
}

}  // namespace

void refuse(std::string_view file, std::string_view place, std::string_view found, std::string_view expected,
            ErrorCode error_code) {
  throw Error(error_code, concat(file, ", ", shown(place), ": found ", shown(found), "; expected ", shown(expected)));
}

}  // namespace rhoray::formats
