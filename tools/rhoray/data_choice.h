#pragma once

#include <filesystem>
#include <string>

#include "render/load.h"
#include "render/texture.h"

namespace rhoray::tools {

// Defaults for a file: isovalue, field and kind.

/// The isovalue that `text` names, and its origin: "given", "percentile 95", "Otsu's threshold".
/// Refuses a value outside the field's range and percentages outside [0, 100] (ErrorCode::usage).
struct Isovalue {
  double value = 0;
  std::string from;
};
Isovalue choose_isovalue(const std::string& text, const formats::FieldSummary& field);

/// True for a number outside the field's range, which choose_isovalue refuses.
bool is_outside(const std::string& isovalue, const formats::FieldSummary& field);

/// Opens a packed file or an OpenVDB file for rendering. Refuses other foreign files and names the
/// command that packs them; refuses an unknown field and names the nearest one. Without a name it
/// takes the first field that is not constant, or the first field if all are.
render::Volume load_shown(const std::filesystem::path& path, const std::string& field);

/// As above; refuses a surface, which has no fields (ErrorCode::invalid).
render::Volume load_volume(const std::filesystem::path& path, const std::string& field);

/// Opens a packed file of colours; refuses others and names the command that packs colours
/// (ErrorCode::invalid).
render::Texture load_texture(const std::filesystem::path& path);

}  // namespace rhoray::tools
