#pragma once

#include <cstdint>
#include <filesystem>

namespace rhoray::preprocess {

/// Opens a file of this size without a name in the folder. It vanishes with its last descriptor and
/// mapping, however the program ends. Its space is reserved, so that a full disk is an error here
/// (ErrorCode::resource) instead of a signal later. Returns a descriptor, closed on exec, that the
/// caller owns.
int open_nameless_file(const std::filesystem::path& folder, std::uint64_t bytes);

}  // namespace rhoray::preprocess
