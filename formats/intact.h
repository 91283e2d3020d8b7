#pragma once

#include "formats/packed_file.h"

namespace rhoray::formats {

/// Throws (ErrorCode::invalid) when bytes of the mapped file were lost since it was opened
/// (formats/base/mapped_file.h): results computed from it since then are worthless. Call it when a
/// result is complete and before anybody sees it. Its cost does not depend on the file's size.
void require_intact(const PackedFile& file);

}  // namespace rhoray::formats
