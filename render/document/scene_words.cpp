#include "render/scene_words.h"

#include <utility>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/word_list.h"
#include "render/color_map.h"

namespace rhoray::render {

namespace {

/// A channel's word and its place in the set.
constexpr std::pair<const char*, bool ChannelSet::*> channels[] = {
    {"depth", &ChannelSet::depth},           {"normal", &ChannelSet::normal}, {"cell", &ChannelSet::cell},
    {"value", &ChannelSet::value},           {"error", &ChannelSet::error},   {"roots", &ChannelSet::roots},
    {"iterations", &ChannelSet::iterations}, {"cost", &ChannelSet::cost}};

constexpr std::pair<const char*, DebugChannel> pages[] = {{"error", DebugChannel::error},
                                                          {"roots", DebugChannel::roots},
                                                          {"iterations", DebugChannel::iterations},
                                                          {"cost", DebugChannel::cost}};

}  // namespace

std::vector<std::string> view_words() {
  return {"iso", "front", "back", "left", "right", "top", "bottom", "+x", "-x", "+y", "-y", "+z", "-z"};
}

std::vector<std::string> up_axis_words() {
  return {"x", "y", "z", "-x", "-y", "-z"};
}

std::vector<std::string> channel_words() {
  return names_in(channels, [](const auto& row) { return row.first; });
}

ChannelSet channel_set(const std::vector<std::string>& words) {
  ChannelSet set;
  const std::vector<std::string> known = channel_words();
  for (const std::string& name : words) {
    bool found = false;
    for (const auto& [word, member] : channels)
      if (name == word) found = set.*member = true;
    if (found) continue;
    throw Error(ErrorCode::usage, concat("--channels: found '", name, "'; expected ", joined(known)),
                did_you_mean(name, known));
  }
  return set;
}

std::vector<std::string> words_of(const ChannelSet& set) {
  std::vector<std::string> words;
  for (const auto& [word, member] : channels)
    if (set.*member) words.emplace_back(word);
  return words;
}

std::vector<std::string> show_words() {
  std::vector<std::string> words = names_in(pages, [](const auto& row) { return row.first; });
  words.insert(words.begin(), "color");
  return words;
}

std::optional<DebugChannel> page_named(const std::string& word) {
  for (const auto& [name, page] : pages)
    if (word == name) return page;
  return std::nullopt;
}

std::string word_of(DebugChannel page) {
  for (const auto& [word, each] : pages)
    if (each == page) return word;
  return "color";
}

std::span<const NamedNormals> named_normals() {
  static constexpr NamedNormals rows[] = {{"flat", Normals::exact, true, false},
                                          {"smooth", Normals::smooth, true, true},
                                          {"exact", Normals::exact, false, true}};
  return rows;
}

std::vector<std::string> normals_words() {
  return names_in(named_normals(), &NamedNormals::name);
}

bool has_flat_normals(const Dataset& dataset) {
  return dataset.is_mesh() || dataset.is_surface();
}

std::string word_of(Normals normals, bool flat) {
  for (const NamedNormals& row : named_normals())
    if (row.normals == normals && (flat ? row.of_meshes : row.of_grids)) return row.name;
  return {};
}

std::vector<std::string> colormap_words() {
  return names_in(color_maps(), &NamedColorMap::name);
}

std::vector<std::string> scale_words() {
  return {"linear", "log"};
}

std::vector<std::string> space_words() {
  return {"ras", "lps"};
}

std::string word_of(ColorMap map) {
  for (const NamedColorMap& named : color_maps())
    if (named.map == map) return std::string(named.name);
  return {};
}

}  // namespace rhoray::render
