#pragma once

#include <string>

#include "formats/base/json.h"
#include "render/render.h"

namespace rhoray::tools {

// The output of `--stats`: as JSON, and as lines of a table.
Json statistics_json(const render::FrameStatistics& statistics);
std::string statistics_text(const render::FrameStatistics& statistics);

/// The cost of proving stored ranges: bytes, seconds, seconds per GiB (null if nothing was read).
Json proof_json(const render::RangeProof& proof);
std::string proof_text(const render::RangeProof& proof);  ///< "1.2 GiB in 0.41 s, 0.34 s/GiB"; "none"

}  // namespace rhoray::tools
