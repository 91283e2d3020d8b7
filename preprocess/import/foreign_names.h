#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::preprocess {

/// By what the tables of importers look a path up: the extension in small letters with its dot
/// (".nii.gz" counts as one); for a folder, by what lies in it, "dicom/" or "images/"; empty for a
/// folder with neither.
std::string family_of(const std::filesystem::path& path);

/// Name of the program that reads this family; the import worker where nothing else is said.
std::string_view worker_for(const std::filesystem::path& path);

/// True for the extensions of pictures that can be slices of a volume.
bool is_picture_name(const std::filesystem::path& path);

/// The files of a folder, in the order in which people number them: a2 before a10. Hidden ones are
/// left out.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

}  // namespace rhoray::preprocess
