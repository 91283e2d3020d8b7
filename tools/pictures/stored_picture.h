#pragma once

#include <string>
#include <vector>

namespace rhoray::tools {

/// A line of text kept in a picture: PNG text or EXR attribute. TIFF and JPEG know few names; there the first
/// text other than Software becomes the image description, and others are left out.
struct PictureText {
  std::string name;
  std::string value;
};

/// A picture as its file holds it: rows from the top, pixels from the left, channels side by side.
struct StoredPicture {
  int width = 0, height = 0;
  std::vector<std::string> channels;  ///< "R", "G", "B", "A", "Z", ...
  std::vector<float> numbers;         ///< as stored; of integers the share of the largest that their type holds
};

}  // namespace rhoray::tools
