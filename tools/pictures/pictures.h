#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "render/framebuffer.h"
#include "tools/pictures/canvas.h"
#include "tools/pictures/stored_picture.h"

namespace rhoray::tools {

/// The file formats of pictures, by the extension of the name: .png .exr .tif .tiff .jpg .jpeg. Refuses others, and
/// channels in a format that keeps none, that is all but EXR (ErrorCode::usage).
void require_picture_format(const std::filesystem::path& path, const render::ChannelSet& channels);

/// The bytes of a picture file; the format follows from the extension of `path`, which messages name.
///
/// PNG and TIFF hold 8-bit sRGB, opaque, over the background that the framebuffer carries; so does JPEG, with loss.
/// EXR holds 32-bit float: R, G, B (linear, without the background: 0 where nothing is hit) and A; and of the channels
/// that were asked for Z (depth), N.x, N.y, N.z, value, error; and as unsigned 32-bit cell (4294967295 where nothing is
/// hit; an id that does not fit is refused, ErrorCode::unsupported), roots, iterations and cost.
///
/// OpenImageIO, which writes all but PNG, stands in a module of its own beside the program, `rhoray-pictures.so`,
/// loaded here: it takes longer to load than most commands run.
std::vector<std::byte> encode_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                      const std::filesystem::path& path);

/// Writes these bytes. The file is whole or not there; an older one stays when it cannot be written
/// (ErrorCode::resource).
void write_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                   const std::filesystem::path& path, bool replace_existing);

/// A font with the letters of most languages; refuses where none of the known files is there, naming the package that
/// brings it (ErrorCode::unsupported).
std::filesystem::path find_font(const std::vector<std::filesystem::path>& known_fonts);
const std::vector<std::filesystem::path>& known_fonts();  ///< DejaVu Sans, where systems keep it

/// One line of UTF-8, in letters of so many pixels. What the font does not have is shown as its empty box.
TextImage make_text_image(const std::string& text, int pixels, const std::filesystem::path& font);

/// Reads a picture of any format above. Refuses what is not there (ErrorCode::unreadable), and what is no picture or is
/// damaged (ErrorCode::invalid).
StoredPicture read_picture(const std::filesystem::path& path);

}  // namespace rhoray::tools
