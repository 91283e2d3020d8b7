#pragma once

#include <filesystem>
#include <string>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Reads a volume from pictures: the files of a folder in the order of their numbers, or the pages
/// of one file. Each picture is a slice in z. Column i of row j is sample (i, j); rows count from
/// the top, as in scans. Such files contain no reliable spacing, so it is 1, with a note.
/// @param field  for pictures of several channels, the name of one, or "luminance"; empty takes the
///               only channel, or the grey value if all colours are equal
NeutralVolume read_image_slices(const std::filesystem::path& path, const std::string& field);

/// The same for colours: 8 bits each of red, green and blue, and separate alpha if there is one. A
/// single picture is one slice.
NeutralVolume read_color_slices(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
