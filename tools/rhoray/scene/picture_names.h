#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "render/heat_map.h"

namespace rhoray::tools {

// Names of views, channels and heat maps, as options and documents take them.

std::vector<std::string> view_words();

std::vector<std::string> channel_words();
/// Refuses words that name none, as option --channels (ErrorCode::usage).
render::ChannelSet channel_set(const std::vector<std::string>& words);
std::vector<std::string> words_of(const render::ChannelSet& channels);

std::vector<std::string> show_words();                                    ///< "color" first
std::optional<render::DebugChannel> page_named(const std::string& word);  ///< nothing for color
std::string word_of(render::DebugChannel page);

}  // namespace rhoray::tools
