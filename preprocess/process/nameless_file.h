#pragma once

#include <cstdint>
#include <filesystem>

namespace rhoray::preprocess {

/// Opens a file of this size in the folder that has no name: it vanishes with its last descriptor and mapping, however
/// the program ends. Its space is reserved, so that a full disk is an error here (ErrorCode::resource) and no signal
/// later. Returns a descriptor, closed on exec, that belongs to the caller.
int open_nameless_file(const std::filesystem::path& folder, std::uint64_t bytes);

}  // namespace rhoray::preprocess
