#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// How rays find the tetrahedra along their path.
enum class MeshStructure {
  clusters,  ///< clusters of neighbouring cells, with a tree of boxes and value ranges
  leaves     ///< lists of a uniform lattice of leaf cells, with macrocells (paper, section 4.2)
};

struct PackMeshOptions {
  /// Scalars to keep, by the names of components.h. The first is the one shown by default. Empty:
  /// the default scalar of every field, of points and of cells, in the file's order, but constants,
  /// ids and masks last.
  std::vector<std::string> fields{};
  bool cells_to_points = false;  ///< keep cell fields averaged to the points, too
  MeshStructure structure = MeshStructure::clusters;
  std::uint64_t cluster_size = 64;  ///< cells: a power of two, at most 64
  /// resolution of the leaf lattice; with clusters only a measure of length
  double leaf_cells_per_tetrahedron = 1;
  std::uint64_t leaf_cell_count = 0;  ///< when not 0, about this many leaf cells instead
  std::int64_t macro_factor = 4;
  int macro_level_count = 3;
  std::string command{};
  std::string source_name{};
  bool replace_existing = false;
};

struct PackMeshReport {
  formats::TetMeshDescription description;
  std::uint64_t file_bytes = 0;
  /// problems found and how they were handled, one sentence each; without the importer's
  std::vector<std::string> notes;
};

/// Sees to it that the mesh has a field to show. A mesh that has only cell fields shows these: sets
/// `cells_to_points`. A mesh without a varying field gets fields that describe its shape, such as
/// the distance from the boundary.
void give_fields(NeutralMesh& mesh, bool& cells_to_points);

/// Cleans a tetrahedral mesh, orders its cells so that neighbours are stored close together, builds
/// the structure and writes a packed mesh. Runs on all threads; the file does not depend on the
/// number of threads. Refuses a mesh without cells or without fields, and an index out of range.
PackMeshReport pack_mesh(const NeutralMesh& mesh, const formats::Destination& destination,
                         const PackMeshOptions& options = {}, const Progress& progress = {});

}  // namespace rhoray::preprocess
