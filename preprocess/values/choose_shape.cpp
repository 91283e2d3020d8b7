#include "preprocess/values/choose_shape.h"

#include "formats/base/error.h"

namespace rhoray::preprocess {

formats::MacroShape choose_macro_shape(const Index3& leaf_count, std::int64_t factor, int level_count) {
  constexpr std::int64_t largest_factor = 32;  // what a reader accepts: 32^12 fits 64 bits
  if (level_count < 1 || level_count > formats::MacroShape::largest_level_count)
    throw Error(ErrorCode::usage, concat("macro levels: found ", level_count, "; expected 1 to ",
                                         formats::MacroShape::largest_level_count));
  if (factor < 2 || factor > largest_factor)
    throw Error(ErrorCode::usage, concat("macro factor: found ", factor, "; expected 2 to ", largest_factor));
  return {.leaf_count = leaf_count, .factor = factor, .level_count = level_count};
}

}  // namespace rhoray::preprocess
