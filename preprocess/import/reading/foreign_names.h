#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace rhoray::preprocess {

/// The key of a path in the importers' tables: the extension in lower case with its dot (".nii.gz"
/// counts as one). For a folder it depends on the content: "dicom/", "images/", or empty for
/// neither.
std::string family_of(const std::filesystem::path& path);

/// True for extensions of pictures that can be slices of a volume.
bool is_picture_name(const std::filesystem::path& path);

/// The files of a folder in natural order: a2 before a10. Hidden files are left out.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

}  // namespace rhoray::preprocess
