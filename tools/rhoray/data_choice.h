#pragma once

#include <filesystem>
#include <string>

#include "render/load.h"
#include "render/texture.h"

namespace rhoray::tools {

// What is shown of a file about which little is said.

/// The isovalue that `text` stands for, and where it came from: "given", "percentile 95", "Otsu's threshold". Refuses
/// one outside the field's range and percentages outside [0, 100] (ErrorCode::usage).
struct Isovalue {
  double value = 0;
  std::string from;
};
Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field);

/// True for a number that the field nowhere has: choose_isovalue refuses it.
bool is_outside(const std::string& isovalue, const formats::FieldSummary& field);

/// Opens a packed file, or an OpenVDB file, for rendering: refuses other foreign files with the way to pack them, and
/// an unknown field with the nearest one. Without a name it takes the first field that is not the same everywhere, or
/// the first when all are.
render::Volume load_shown(const std::filesystem::path& path, const std::string& field);

/// As above; refuses a surface, which has no fields (ErrorCode::invalid).
render::Volume load_volume(const std::filesystem::path& path, const std::string& field);

/// Opens a packed file of colours; refuses others with the way to pack colours (ErrorCode::invalid).
render::Texture load_texture(const std::filesystem::path& path);

}  // namespace rhoray::tools
