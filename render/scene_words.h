#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "render/heat_map.h"
#include "render/load.h"
#include "render/scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

// Names of views, styles, channels, heat maps, normals and colour maps, as options and documents
// take them.

std::vector<std::string> view_words();
std::vector<std::string> up_axis_words();  ///< x, y, z, -x, -y, -z

std::vector<std::string> style_words();  ///< the default first
std::string style_help();                ///< what each style is for, and what it costs
/// @param style  empty: the default
std::vector<LightSpec> lights_of_style(const std::string& style);

std::vector<std::string> channel_words();
/// Refuses words that name none, as option --channels (ErrorCode::usage).
ChannelSet channel_set(const std::vector<std::string>& words);
std::vector<std::string> words_of(const ChannelSet& channels);

std::vector<std::string> show_words();                            ///< "color" first
std::optional<DebugChannel> page_named(const std::string& word);  ///< nothing for color
std::string word_of(DebugChannel page);

struct NamedNormals {
  const char* name;
  Normals normals;
  bool of_meshes;  ///< and of triangles
  bool of_grids;
};
std::span<const NamedNormals> named_normals();
/// Names of normals: flat in meshes and of triangles, exact in grids, smooth in all.
std::vector<std::string> normals_words();
std::string word_of(Normals normals, bool has_flat_normals);
bool has_flat_normals(const Dataset& dataset);  ///< meshes and surfaces

std::vector<std::string> colormap_words();
std::vector<std::string> scale_words();  ///< of LayerSpec::scale; linear first
std::vector<std::string> space_words();  ///< of SceneSpec::space
std::string word_of(ColorMap map);

}  // namespace rhoray::render
