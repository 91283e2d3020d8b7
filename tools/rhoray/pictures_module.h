#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/pictures.h"

namespace rhoray::tools {

/// Writes into the file `open_name` as `format` ("png", "openexr", "tiff", "jpeg"); returns an empty text, or what went
/// wrong. The one act of the module that holds OpenImageIO; nothing is thrown out of it.
using EncodePicture = std::string(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                  const std::string& format, const std::string& open_name) noexcept;

inline constexpr const char* pictures_module = "rhoray-pictures.so";  ///< beside the program
inline constexpr const char* encode_picture_symbol = "rhoray_encode_picture";

}  // namespace rhoray::tools
