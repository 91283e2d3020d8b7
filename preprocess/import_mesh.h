#pragma once

#include <filesystem>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct ImportMeshOptions {
  std::uint64_t memory_limit_bytes = 0;  ///< of the reading process; 0 = none
};

/// Reads tetrahedra from VTU (.vtu), legacy VTK (.vtk) or TetGen (.node or .ele, its partner beside it). The reader
/// runs in a process of its own. Line and surface cells are left out with a note; volume cells that are not linear
/// tetrahedra are refused with their kind and count (Trouble::unsupported).
NeutralMesh import_mesh(const std::filesystem::path& path, const ImportMeshOptions& options = {});

/// Reads a surface from PLY, STL, OBJ, OFF, or TetGen .poly/.smesh (with holes and regions). Points that coincide
/// exactly are merged in formats that repeat them (STL). A TetGen .mtr file beside it, or named here, gives wanted
/// sizes at its points.
NeutralSurface import_surface(const std::filesystem::path& path, const std::filesystem::path& sizes = {},
                              const ImportMeshOptions& options = {});

/// What kind of thing a foreign file holds, by its name and, for .vtk, its header.
enum class ForeignKind { volume, mesh, surface, unknown };
ForeignKind foreign_kind(const std::filesystem::path& path);

/// Writes a mesh as VTU (appended, compressed). Nothing is left under the name when it fails.
void export_mesh(const NeutralMesh& mesh, const std::filesystem::path& path, bool replace_existing);

}  // namespace rhoray::preprocess
