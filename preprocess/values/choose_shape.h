#pragma once

#include <cstdint>

#include "formats/macro_levels.h"

namespace rhoray::preprocess {

/// Returns the requested hierarchy. Refuses a factor outside 2..32 and a number of levels outside
/// 1..largest_level_count (ErrorCode::usage).
formats::MacroShape choose_macro_shape(const Index3& leaf_count, std::int64_t factor, int level_count);

}  // namespace rhoray::preprocess
