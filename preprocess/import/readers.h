#pragma once

#include <filesystem>
#include <string>

#include "preprocess/import_volume.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The readers themselves, without a process around them: what the import worker calls. Each picks
/// its format by the file's extension (importers.cpp) and refuses an extension that it does not
/// know (ErrorCode::unsupported).

struct VolumeRequest {
  std::optional<RawVolume> raw{};  ///< read as headerless bytes, whatever the extension
  std::string field{};             ///< as in ImportVolumeOptions
  bool colors = false;             ///< likewise
  bool length_of_vectors = false;
};

struct MeshRequest {
  std::string time;  ///< as in ImportMeshOptions
};

NeutralVolume read_volume(const std::filesystem::path& path, const VolumeRequest& request);
CellMesh read_cells(const std::filesystem::path& path, const MeshRequest& request);
NeutralMesh read_mesh(const std::filesystem::path& path);  ///< its cells as tetrahedra
NeutralSurface read_surface(const std::filesystem::path& path, const std::filesystem::path& sizes = {});

/// Writes VTU: appended, compressed, points in double precision. Not atomic by itself; `path` must
/// not matter when it fails.
void write_vtu(const NeutralMesh& mesh, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
