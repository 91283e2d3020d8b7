#include "render/document/place.h"

#include "formats/base/error.h"

namespace rhoray::render {

Place Place::at(std::string_view key) const {
  Place place = *this;
  place.pointer += '/';
  for (const char letter : key) {
    if (letter == '~')
      place.pointer += "~0";
    else if (letter == '/')
      place.pointer += "~1";
    else
      place.pointer += letter;
  }
  return place;
}

Place Place::at(std::size_t index) const {
  return at(concat(index));
}

std::string Place::text() const {
  return pointer.empty() ? document : concat(document, ": ", pointer);
}

void Place::refuse(const Json& found, const std::string& expected, const std::string& hint) const {
  throw Error(ErrorCode::invalid, concat(text(), ": found ", found_text(found), "; expected ", expected), hint);
}

std::string found_text(const Json& value) {
  constexpr std::size_t most = 40;
  if (value.is_object()) return "an object";
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return text.size() <= most ? dump(value) : concat(dump(text.substr(0, most - 3) + "..."));
  }
  const std::string text = value.is_array() && value.size() > most ? std::string(most + 1, ' ') : dump(value);
  return text.size() <= most ? text : concat("an array of ", value.size());
}

}  // namespace rhoray::render
