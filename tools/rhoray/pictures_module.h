#pragma once

#include <string>
#include <vector>

#include "tools/rhoray/pictures.h"

namespace rhoray::tools {

/// Writes into the file `open_name` as `format` ("png", "openexr", "tiff", "jpeg"); returns an empty text, or what went
/// wrong. Acts of the module that holds OpenImageIO and FreeType throw nothing.
using EncodePicture = std::string(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                  const std::string& format, const std::string& open_name) noexcept;

/// How much of each pixel a line of text covers, drawn with the letters of a font file. Returns as above.
/// @param pixels  the font's size
using MakeTextImage = std::string(const std::string& text, int pixels, const std::string& font,
                                  TextImage& out) noexcept;

inline constexpr const char* pictures_module = "rhoray-pictures.so";  ///< beside the program
inline constexpr const char* encode_picture_symbol = "rhoray_encode_picture";
inline constexpr const char* make_text_image_symbol = "rhoray_make_text_image";

}  // namespace rhoray::tools
