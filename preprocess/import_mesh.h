#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

struct ImportMeshOptions {
  /// Which time step of a file that has several: "first", "last", "#N" (from 0), or a time: the nearest is taken, with
  /// a note. Empty: the only one, or the last with a note.
  std::string time{};
  double max_error = 0.01;                  ///< of higher-order cells made tetrahedra (subdivide.h)
  std::vector<std::string> error_fields{};  ///< whose error counts (SubdivideOptions::fields); empty = of all
  std::uint64_t memory_limit_bytes = 0;     ///< of the reading process; 0 = none
  std::filesystem::path scratch_folder{};   ///< when not empty, a cap on anonymous memory (memory_cap.h), not a limit
  Progress progress{};                      ///< of subdividing, and "reading (bytes)" of formats read array by array
};

/// Reads cells of every kind from the mesh formats of import/README.md, in a process of its own. Line and surface cells
/// are left out with a note.
CellMesh import_cells(const std::filesystem::path& path, const ImportMeshOptions& options = {});

/// Reads a mesh and makes its cells tetrahedra (subdivide.h).
NeutralMesh import_mesh(const std::filesystem::path& path, const ImportMeshOptions& options = {});

/// Reads a surface from PLY, STL, OBJ, OFF, BrainVisa .tri, legacy VTK, or TetGen .poly/.smesh (with holes and regions)
/// and .face. Points that coincide exactly are merged in formats that repeat them (STL). A TetGen .mtr file beside it,
/// or named here, gives wanted sizes at its points.
NeutralSurface import_surface(const std::filesystem::path& path, const std::filesystem::path& sizes = {},
                              const ImportMeshOptions& options = {});

/// What kind of thing a foreign file holds, by its name and, for .vtk, its header.
enum class ForeignKind { volume, mesh, surface, unknown };
ForeignKind foreign_kind(const std::filesystem::path& path);

/// The extensions of files of that kind, and what else is of it, for messages.
std::string extensions_of(ForeignKind kind);

/// What to do with a file whose format is known, by its name, but not read here: one sentence. Empty for others.
std::string advice_on(const std::filesystem::path& path);

/// Writes a mesh as VTU (appended, compressed). Nothing is left under the name when it fails.
void export_mesh(const NeutralMesh& mesh, const std::filesystem::path& path, bool replace_existing);

}  // namespace rhoray::preprocess
