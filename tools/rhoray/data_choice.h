#pragma once

#include <filesystem>
#include <string>

#include "render/document.h"
#include "render/load.h"

namespace rhoray::tools {

/// Refuses a file that is not packed and whose name does not end in .rho, and names the command that
/// packs it (ErrorCode::unsupported).
void require_packed(const std::filesystem::path& path);

/// Opens a packed file or an OpenVDB file for rendering. Refuses other foreign files and names the
/// command that packs them; refuses an unknown field and names the nearest one. Without a name it
/// takes the first field that is not constant, or the first field if all are.
render::Dataset load_shown(const std::filesystem::path& path, const std::string& field);

/// As above; refuses a surface, which has no fields (ErrorCode::unsupported).
render::Dataset load_dataset(const std::filesystem::path& path, const std::string& field);

/// Opens the data of a scene by load_shown (render/document.h).
render::ResolvedScene resolve_layers(const render::SceneSpec& scene_spec);

}  // namespace rhoray::tools
