#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

struct ImportMeshOptions {
  /// The time step of a file that has several: "first", "last", "#N" (from 0), or a time. For a
  /// time, the nearest step is taken, with a note. Empty: the only step, or the last one with a
  /// note.
  std::string time{};
  double max_error = 0.01;  ///< of higher-order cells cut into tetrahedra (subdivide.h)
  /// the fields whose error counts (SubdivideOptions::fields); empty = all
  std::vector<std::string> error_fields{};
  std::uint64_t memory_limit_bytes = 0;  ///< of the reading process; 0 = none
  /// when not empty, the limit is a cap on anonymous memory (process/memory_cap.h)
  std::filesystem::path scratch_folder{};
  /// of subdividing, and "reading (bytes)" of formats that are read array by array
  Progress progress{};
};

/// Reads cells of every kind from the mesh formats of import/README.md, in a separate process. Line
/// and surface cells are left out with a note.
CellMesh import_cells(const std::filesystem::path& path, const ImportMeshOptions& options = {});

/// Reads a mesh and cuts its cells into tetrahedra (subdivide.h).
NeutralMesh import_mesh(const std::filesystem::path& path, const ImportMeshOptions& options = {});

/// Reads a surface from PLY, STL, OBJ, OFF, BrainVisa .tri, legacy VTK, TetGen .poly/.smesh (with
/// holes and regions) or .face. In formats that repeat points (STL), points that coincide exactly
/// are merged. A TetGen .mtr file beside the surface, or named by `sizes`, gives target sizes at
/// its points.
NeutralSurface import_surface(const std::filesystem::path& path, const std::filesystem::path& sizes = {},
                              const ImportMeshOptions& options = {});

/// Writes a mesh as VTU (appended, compressed). On failure, no file is left under the name.
void export_mesh(const NeutralMesh& mesh, const std::filesystem::path& path, bool replace_existing);

struct ConvertMeshOptions {
  /// point and cell fields to keep (--field), whose errors count; empty = all
  std::vector<std::string> fields{};
  ImportMeshOptions import{};  ///< without error_fields
  bool replace_existing = false;
};

/// Converts a mesh to tetrahedra in a VTU file and returns it. If cells were cut or left out, the
/// cell field "source_cell" holds the position in the input of each tetrahedron's cell. Refuses an
/// unknown field and names the nearest one (ErrorCode::usage).
NeutralMesh convert_mesh(const std::filesystem::path& input, const std::filesystem::path& output,
                         const ConvertMeshOptions& options = {});

}  // namespace rhoray::preprocess
