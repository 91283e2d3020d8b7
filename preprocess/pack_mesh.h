#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// How rays find the tetrahedra on their way.
enum class MeshStructure {
  clusters,  ///< of neighbouring cells, with a tree of boxes and value ranges over them
  leaves     ///< lists of a uniform lattice of leaf cells, with macrocells over them (paper, section 4.2)
};

struct PackMeshOptions {
  /// Fields to keep: NAME of a scalar; NAME.x, NAME.y, NAME.z, NAME.<n>, NAME.mag of a vector. The first is the one
  /// shown by default. Empty: every scalar point field and the magnitude of every vector, in the file's order.
  std::vector<std::string> fields{};
  bool cells_to_points = false;  ///< also take cell fields, averaged to points by the volumes of their cells
  MeshStructure structure = MeshStructure::clusters;
  std::uint64_t cluster_size = 64;        ///< cells: a power of two, at most 64
  double leaf_cells_per_tetrahedron = 1;  ///< resolution of the leaf lattice; with clusters only a measure of length
  std::uint64_t leaf_cell_count = 0;      ///< when not 0, about this many leaf cells instead
  std::int64_t macro_factor = 4;
  int macro_level_count = 3;
  std::string command{};
  std::string source_name{};
  bool replace_existing = false;
};

struct PackMeshReport {
  formats::TetMeshDescription description;
  std::uint64_t file_bytes = 0;
  std::vector<std::string> notes;  ///< what was met and done about it, one sentence each; without the importer's
};

/// Cleans a tetrahedral mesh, puts its cells in an order in which neighbours stand close, builds the structure and
/// writes a packed mesh. Runs on all threads; the file does not depend on the number of threads. Refuses a mesh
/// without cells or without fields, and an index out of range.
PackMeshReport pack_mesh(const NeutralMesh& mesh, const std::filesystem::path& path,
                         const PackMeshOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess
