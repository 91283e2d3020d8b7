#pragma once

#include <cstdint>

#include "formats/macro_levels.h"

namespace rhoray::preprocess {

/// The hierarchy that the options ask for; refuses (ErrorCode::usage) a factor outside 2..32 and a number of levels
/// outside 1..largest_level_count.
formats::MacroShape choose_macro_shape(const Index3& leaf_count, std::int64_t factor, int level_count);

}  // namespace rhoray::preprocess
