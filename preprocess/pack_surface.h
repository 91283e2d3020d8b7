#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/triangle_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct PackSurfaceOptions {
  std::string command{};
  std::string source_name{};
  bool replace_existing = false;
};

struct PackSurfaceReport {
  formats::TriangleMeshDescription description;
  std::uint64_t file_bytes = 0;
  /// problems found and how they were handled, one sentence each; without the importer's
  std::vector<std::string> notes;
};

/// Writes a surface as a packed one. Facets of more than three corners are cut into triangles
/// between their own corners. They are cut by ear clipping, projected along the largest component
/// of their mean normal. Points are stored as F32 where that keeps every bit, else as F64. Refuses
/// a surface without triangles. Refuses faces made of several outlines (ErrorCode::unsupported).
PackSurfaceReport pack_surface(const NeutralSurface& surface, const formats::Destination& destination,
                               const PackSurfaceOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess
