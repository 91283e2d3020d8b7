#include "tools/rhoray/scene/picture_names.h"

#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"

namespace rhoray::tools {

namespace {

/// A channel's word and its place in the set.
constexpr std::pair<const char*, bool render::ChannelSet::*> channels[] = {
    {"depth", &render::ChannelSet::depth},
    {"normal", &render::ChannelSet::normal},
    {"cell", &render::ChannelSet::cell},
    {"value", &render::ChannelSet::value},
    {"error", &render::ChannelSet::error},
    {"roots", &render::ChannelSet::roots},
    {"iterations", &render::ChannelSet::iterations},
    {"cost", &render::ChannelSet::cost}};

constexpr std::pair<const char*, render::DebugChannel> pages[] = {{"error", render::DebugChannel::error},
                                                                  {"roots", render::DebugChannel::roots},
                                                                  {"iterations", render::DebugChannel::iterations},
                                                                  {"cost", render::DebugChannel::cost}};

}  // namespace

std::vector<std::string> view_words() {
  return {"iso", "+x", "-x", "+y", "-y", "+z", "-z"};
}

std::vector<std::string> channel_words() {
  std::vector<std::string> words;
  for (const auto& [word, member] : channels) words.emplace_back(word);
  return words;
}

render::ChannelSet channel_set(const std::vector<std::string>& words) {
  render::ChannelSet set;
  const std::vector<std::string> known = channel_words();
  for (const std::string& name : words) {
    bool found = false;
    for (const auto& [word, member] : channels)
      if (name == word) found = set.*member = true;
    if (found) continue;
    std::string known_text;
    for (const std::string& word : known) known_text += concat(known_text.empty() ? "" : ", ", word);
    throw Error(ErrorCode::usage, concat("--channels: found '", name, "'; expected ", known_text),
                did_you_mean(name, known));
  }
  return set;
}

std::vector<std::string> words_of(const render::ChannelSet& set) {
  std::vector<std::string> words;
  for (const auto& [word, member] : channels)
    if (set.*member) words.emplace_back(word);
  return words;
}

std::vector<std::string> show_words() {
  std::vector<std::string> words{"color"};
  for (const auto& [word, page] : pages) words.emplace_back(word);
  return words;
}

std::optional<render::DebugChannel> page_named(const std::string& word) {
  for (const auto& [name, page] : pages)
    if (word == name) return page;
  return std::nullopt;
}

std::string word_of(render::DebugChannel page) {
  for (const auto& [word, each] : pages)
    if (each == page) return word;
  return "color";
}

}  // namespace rhoray::tools
