#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/pictures.h"

namespace rhoray::tools {

// The acts of the module that holds OpenImageIO. Nothing is thrown out of them; they return an empty text, or what went
// wrong.

/// Writes into the file `open_name` as `format` ("png", "openexr", "tiff", "jpeg").
using EncodePicture = std::string(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                  const std::string& format, const std::string& open_name) noexcept;

using DecodePicture = std::string(const std::string& path, StoredPicture& picture) noexcept;

inline constexpr const char* pictures_module = "rhoray-pictures.so";  ///< beside the program
inline constexpr const char* encode_picture_symbol = "rhoray_encode_picture";
inline constexpr const char* decode_picture_symbol = "rhoray_decode_picture";

}  // namespace rhoray::tools
