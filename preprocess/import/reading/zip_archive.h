#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace rhoray::preprocess {

/// Decompresses every file of a zip archive in memory, one after the other, without folders.
/// Refuses a damaged archive, and files larger than an archive this short can hold.
void read_zip(const std::filesystem::path& path,
              const std::function<void(const std::string& name, std::string_view bytes)>& take);

}  // namespace rhoray::preprocess
