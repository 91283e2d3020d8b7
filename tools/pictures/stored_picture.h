#pragma once

#include <string>
#include <vector>

namespace rhoray::tools {

/// A line of text stored in a picture: PNG text or EXR attribute. TIFF and JPEG support few names.
/// There the first text other than Software becomes the image description, and others are omitted.
struct PictureText {
  std::string name;
  std::string value;
};

/// The text that holds the scene of a picture. Relative file names start at the picture's folder.
inline constexpr const char* scene_text_name = "rhoray:scene";

/// A picture as stored in its file: rows from the top, pixels from the left, channels interleaved.
struct StoredPicture {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", "Z", ...
  /// As stored; integers of 8 and 16 bits are divided by the largest value of their type.
  std::vector<double> numbers;
  std::vector<PictureText> texts{};  ///< all that the file holds
};

}  // namespace rhoray::tools
