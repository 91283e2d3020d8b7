#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/framebuffer.h"

namespace rhoray::tools {

/// A line of text kept in a picture: PNG text or EXR attribute. TIFF and JPEG know few names; there the first
/// text other than Software becomes the image description, and others are left out.
struct PictureText {
  std::string name;
  std::string value;
};

/// The file formats of pictures, by the extension of the name: .png .exr .tif .tiff .jpg .jpeg. Refuses others, and
/// channels in a format that keeps none, that is all but EXR (Trouble::usage).
void require_picture_format(const std::filesystem::path& path, const render::ChannelSet& channels);

/// Writes a framebuffer; the format follows from the extension of `path`. The file is whole or not there.
///
/// PNG and TIFF hold 8-bit sRGB, opaque, over the background that the framebuffer carries; so does JPEG, with loss.
/// EXR holds 32-bit float: R, G, B (linear, 0 where nothing is hit) and A; and of the channels that were asked for
/// Z (depth), N.x, N.y, N.z, value, error; and as unsigned 32-bit cell (4294967295 where nothing is hit; an id that
/// does not fit is refused, Trouble::unsupported), roots, iterations and cost.
///
/// OpenImageIO stands in a module of its own beside the program, `rhoray-pictures.so`, loaded here: it takes longer to
/// load than most commands run.
void write_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                   const std::filesystem::path& path, bool replace_existing);

/// A picture as its file holds it: rows from the top, pixels from the left, channels side by side.
struct StoredPicture {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", "Z", ...
  std::vector<float> numbers;         ///< as stored; of integers the share of the largest that their type holds
};

/// Reads a picture of any format above. Refuses what is not there (Trouble::unreadable), and what is no picture or is
/// damaged (Trouble::invalid).
StoredPicture read_picture(const std::filesystem::path& path);

}  // namespace rhoray::tools
