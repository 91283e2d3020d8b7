#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace rhoray {

/// Receives each line that a library prints, and each reason that a library gives for a refusal.
/// Rhoray's own messages never contain these lines. Without a sink they are dropped. The sink is
/// set once, before any thread starts.
using LibraryTextSink = std::function<void(const std::string& line)>;
void set_library_text_sink(LibraryTextSink sink);

/// Passes the lines of a text to the sink. Empty lines are left out.
void note_library_text(std::string_view text);

}  // namespace rhoray
