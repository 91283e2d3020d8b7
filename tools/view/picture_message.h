#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/stored_picture.h"

namespace rhoray::tools {

enum class Codec : std::uint8_t { jpeg = 1, png = 2 };

/// The header of a picture message.
struct PictureHeader {
  Codec codec = Codec::jpeg;
  bool is_thinned = false;    ///< the picture has every s-th pixel of every s-th row, s the spacing
  std::uint32_t frame = 0;    ///< counts up; the client acknowledges it
  std::uint32_t request = 0;  ///< number of the request that is shown
  int width = 0, height = 0;  ///< that the picture is to fill, in pixels
  float trace_ms = 0;         ///< since the request was taken up
  float spacing = 1;          ///< of the traced pixels, in pixels that are to be filled
};
inline constexpr std::size_t picture_header_bytes = 24;

/// Reads the header of a message. Refuses messages that are too short (ErrorCode::internal).
PictureHeader read_picture_header(std::span<const std::byte> message);

/// The quality of JPEG pictures, and whether colours keep their full resolution.
struct JpegQuality {
  int quality = 80;
  bool has_full_color = false;  ///< 4:4:4 instead of 4:2:0, which bleeds colour into fine lines
};

/// A binary message (PROTOCOL.md): the header's numbers in little-endian order, and the encoded
/// picture, thinned where the header says so.
std::vector<std::byte> jpeg_message(const PictureHeader& header, const render::Framebuffer& picture,
                                    const JpegQuality& quality);
/// As above, without loss, and never thinned. The texts stand in the PNG file.
std::vector<std::byte> png_message(const PictureHeader& header, const render::Framebuffer& picture,
                                   const std::vector<PictureText>& texts);

}  // namespace rhoray::tools
