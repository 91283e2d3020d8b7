#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace rhoray {

/// What the libraries below us print, and the reasons that they give, line by line. Our own messages
/// never contain it. Without a sink it is dropped. The sink is set once, before any thread starts.
using LibraryTextSink = std::function<void(const std::string& line)>;
void set_library_text_sink(LibraryTextSink sink);

/// Passes the lines of a text to the sink. Empty lines are left out.
void note_library_text(std::string_view text);

}  // namespace rhoray
