#include "formats/base/library_text.h"

#include <algorithm>
#include <utility>

namespace rhoray {

namespace {

LibraryTextSink& sink() {
  static LibraryTextSink the_sink;
  return the_sink;
}

}  // namespace

void set_library_text_sink(LibraryTextSink new_sink) {
  sink() = std::move(new_sink);
}

void note_library_text(std::string_view text) {
  if (!sink()) return;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) sink()(std::string(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace rhoray
