#pragma once

#include <filesystem>
#include <string>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A volume from pictures: the files of a folder in the order of their numbers, or the pages of one
/// file, each a slice in z. Column i of row j is sample (i, j), rows counted from the top, as they
/// stand in scans. Files say nothing of spacing that could be trusted: it is 1, with a note.
/// @param field  for pictures of several channels: the name of one, or "luminance"; empty takes the
///               only one, or the grey that all colours agree on
NeutralVolume read_image_slices(const std::filesystem::path& path, const std::string& field);

/// The same of colours: red, green and blue of 8 bits each, and alpha by itself where there is one.
/// A single picture is a single slice.
NeutralVolume read_color_slices(const std::filesystem::path& path);

}  // namespace rhoray::preprocess
