#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Makes one mesh of pieces, one after the other. Their cells are counted through, as `cell_ids`
/// says.
class MeshPieces {
 public:
  /// Appends a piece that has points, fields and notes, and takes its cells as `sift_cells` does. A
  /// field that a piece lacks is left out of the whole, with a note; pieces without points and
  /// cells do not count.
  /// @param path  of the piece, for messages
  void add(CellMesh piece, ForeignCells cells, const std::filesystem::path& path);

  /// The whole: points of different pieces at the same place are merged (merge_points.h). Refuses
  /// one without cells.
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
