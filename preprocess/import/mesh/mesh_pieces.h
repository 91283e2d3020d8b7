#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Concatenates pieces into one mesh. Cells are numbered continuously over all pieces, as in
/// `cell_ids`.
class MeshPieces {
 public:
  /// Appends a piece that has points, fields and notes, and takes its cells as `sift_cells` does.
  /// If a piece lacks a field, the whole mesh drops it, with a note. Pieces without points and
  /// cells are ignored.
  /// @param path  path of the piece, for messages
  void add(CellMesh piece, ForeignCells cells, const std::filesystem::path& path);

  /// Returns the whole mesh, with coincident points of different pieces merged (merge_points.h).
  /// Refuses a mesh without cells.
  CellMesh finish(const std::filesystem::path& path);

 private:
  void append(CellMesh piece, std::uint64_t foreign_cell_count);

  CellMesh whole_;
  std::vector<std::uint64_t> point_offsets_{0};
  std::uint64_t foreign_cell_count_ = 0;
  std::set<std::string> incomplete_fields_;
  LeftOut left_out_;
};

}  // namespace rhoray::preprocess
