#pragma once

#include <filesystem>
#include <string>

#include "preprocess/import_volume.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The readers without a separate process around them; the import worker calls them. Each chooses
/// the format by the file's extension (importers.cpp) and refuses an unknown extension
/// (ErrorCode::unsupported).

struct VolumeRequest {
  std::optional<RawVolume> raw{};  ///< read as headerless bytes, whatever the extension
  std::string field{};             ///< as in ImportVolumeOptions
  bool colors = false;             ///< as in ImportVolumeOptions
  std::string time{};              ///< as in ImportVolumeOptions
};

struct MeshRequest {
  std::string time;  ///< as in ImportMeshOptions
};

NeutralVolume read_volume(const std::filesystem::path& path, const VolumeRequest& request);
CellMesh read_cells(const std::filesystem::path& path, const MeshRequest& request);
NeutralMesh read_mesh(const std::filesystem::path& path);  ///< cells split into tetrahedra
NeutralSurface read_surface(const std::filesystem::path& path, const std::filesystem::path& sizes = {});

}  // namespace rhoray::preprocess
