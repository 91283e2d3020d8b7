#pragma once

#include <string>

#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// The JSON Schema (draft 2020-12) of scene documents, as published in
/// data/scenes/scene.schema.json.
Json scene_schema();
std::string scene_schema_text();

/// Every key of every kind of object, as Markdown tables.
std::string scene_reference();

}  // namespace rhoray::tools
