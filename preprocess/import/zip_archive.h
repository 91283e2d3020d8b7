#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace rhoray::preprocess {

/// Unpacks every file of a zip archive in memory, one after the other, folders left out. Refuses a
/// damaged archive, and files larger than so short an archive can hold.
void read_zip(const std::filesystem::path& path,
              const std::function<void(const std::string& name, std::string_view bytes)>& take);

}  // namespace rhoray::preprocess
