#pragma once

#include <string>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Converts the samples to another type. Refuses a value that would change (ErrorCode::invalid,
/// with the sample's position): every number must be the same number afterwards. NaN and infinity
/// need a floating-point type. Holds both the old and the new samples until it returns.
void convert_samples(NeutralVolume& volume, formats::ElementType type, const std::string& source_name);

/// Copies samples that do not start at a multiple of their own size, as those of a mapped file may.
void align_samples(NeutralVolume& volume);

}  // namespace rhoray::preprocess
