#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/stored_picture.h"

namespace rhoray::tools {

// Functions of the module that contains OpenImageIO and FreeType. They throw nothing. They return
// an empty string, or the error message.

/// Writes the bytes of a file of `format` ("openexr", "tiff", "jpeg").
/// @param srgb  the picture in the layout of render::srgb_bytes, for TIFF and JPEG; may be empty
///              for EXR
using EncodePicture = std::string(const render::Framebuffer& picture, const std::vector<std::uint8_t>& srgb,
                                  const std::vector<PictureText>& texts, const std::string& format,
                                  std::vector<std::byte>& bytes) noexcept;

using DecodePicture = std::string(const std::string& path, StoredPicture& picture) noexcept;

/// Computes the share of each pixel that a line of text covers, with the letters of a font file.
/// @param pixels  font size
using MakeTextImage = std::string(const std::string& text, int pixels, const std::string& font,
                                  TextImage& out) noexcept;

inline constexpr const char* pictures_module = "rhoray-pictures.so";  ///< beside the program
inline constexpr const char* encode_picture_symbol = "rhoray_encode_picture";
inline constexpr const char* decode_picture_symbol = "rhoray_decode_picture";
inline constexpr const char* make_text_image_symbol = "rhoray_make_text_image";

}  // namespace rhoray::tools
