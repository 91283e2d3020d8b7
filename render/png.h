#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/framebuffer.h"

namespace rhoray::render {

/// Converts a linear value to 8-bit sRGB (IEC 61966-2-1). Values outside [0, 1] are clamped; NaN
/// gives 0.
std::uint8_t srgb_byte(float linear);

/// Returns red, green and blue of every pixel as 8-bit sRGB, over the background that the
/// framebuffer carries: rows from the top, pixels from the left.
///
/// Without a background, alpha is the fourth byte, and the colours are not multiplied by it. Such
/// pixels are to be composited in linear light. Over black and white, colours are then right within
/// half a step of the 8 bits of alpha.
std::vector<std::uint8_t> srgb_bytes(const Framebuffer& picture);

/// A text that a PNG file stores beside the pixels.
struct PngText {
  std::string keyword;  ///< 1 to 79 printable Latin-1 characters, no space at either end
  std::string text;     ///< UTF-8
};

/// Returns the bytes of a PNG file: srgb_bytes, with an alpha channel if the framebuffer has no
/// background. The same input gives the same bytes; no time is stored.
///
/// ASCII texts become tEXt chunks, others iTXt. Throws ErrorCode::internal for input that libpng
/// refuses (a picture without pixels, a keyword that breaks the rule above), and std::bad_alloc.
std::vector<std::byte> encode_png(const Framebuffer& picture, std::span<const PngText> texts);

}  // namespace rhoray::render
