#pragma once

#include <string>

#include "render/render.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

// What `--stats` tells of a frame: as JSON, and as lines of a table.
Json statistics_json(const render::FrameStatistics& statistics);
std::string statistics_text(const render::FrameStatistics& statistics);

}  // namespace rhoray::tools
