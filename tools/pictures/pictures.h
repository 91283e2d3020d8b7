#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/stored_picture.h"

namespace rhoray::tools {

/// Refuses if the module is missing that draws annotations, reads pictures, and writes all pictures
/// but PNG (ErrorCode::unsupported).
void require_pictures_module();

/// Whether annotations can be drawn: the module and a known font are there.
bool can_annotate();

/// The extensions of the pictures that are written.
std::vector<std::string> picture_extensions();

/// Checks the picture format, which follows from the extension: .png .exr .tif .tiff .jpg .jpeg.
/// Refuses other extensions. Refuses channels in all formats except EXR, because the others cannot
/// store them (ErrorCode::usage). Refuses JPEG for a picture with alpha (ErrorCode::usage). Refuses
/// formats that need the module if it is missing.
void require_picture_format(const std::filesystem::path& path, const render::ChannelSet& channels,
                            bool has_alpha = false);

/// Returns the bytes of a picture file. The format follows from the extension of `path`, which
/// messages name.
///
/// PNG and TIFF hold 8-bit sRGB, opaque, over the framebuffer's background; so does JPEG, with
/// loss. Without a background PNG and TIFF also hold alpha (render::srgb_bytes). EXR holds 32-bit
/// floats: R, G, B (linear, without the background: 0 where nothing is hit) and A. It also holds
/// the requested channels: Z (depth), N.x, N.y, N.z, value and error as floats; cell, roots,
/// iterations and cost as unsigned 32-bit integers. A cell is 4294967295 where nothing is hit; an
/// id that does not fit is refused (ErrorCode::unsupported).
///
/// OpenImageIO writes all formats but PNG. It takes longer to load than most commands run. So it is
/// in a separate module beside the program, `rhoray-pictures.so`, which is loaded here.
std::vector<std::byte> encode_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                      const std::filesystem::path& path);

/// Writes these bytes to a file. The file is complete or absent. An older file stays if it cannot
/// be written (ErrorCode::resource).
void write_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                   const std::filesystem::path& path, bool replace_existing);

/// Finds a font with the letters of most languages. If none of the known files exists, it refuses
/// and names the package that provides one (ErrorCode::unsupported).
std::filesystem::path find_font(const std::vector<std::filesystem::path>& known_fonts);
/// DejaVu Sans, at the paths of common systems
const std::vector<std::filesystem::path>& known_fonts();

/// Renders one line of UTF-8 at a font size in pixels. Characters missing in the font appear as its
/// empty box.
TextImage make_text_image(const std::string& text, int pixels, const std::filesystem::path& font);

/// Reads a picture in any format above. Refuses a missing file (ErrorCode::unreadable), and one
/// that is no picture or is damaged (ErrorCode::invalid).
StoredPicture read_picture(const std::filesystem::path& path);

}  // namespace rhoray::tools
