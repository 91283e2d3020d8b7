#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/readers.h"

namespace rhoray::preprocess {

/// Name of the program that reads this file; the import worker by default.
std::string_view worker_for(const std::filesystem::path& path);

/// Size of a file whose reader reads no other file; 0 for other inputs and for folders.
std::uint64_t bytes_of_single_file(const std::filesystem::path& path);

/// The command `volume` and its kin (process/worker_names.h), and what it asks for.
std::vector<std::string> volume_arguments(const std::filesystem::path& path, const VolumeRequest& request);
VolumeRequest volume_request(const std::vector<std::string>& arguments);

}  // namespace rhoray::preprocess
