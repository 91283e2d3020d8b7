#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/inspect_mesh.h"

/// One function for each check of a mesh; findings.cpp calls them in the order of the report.
namespace rhoray::preprocess::inspect {

/// Index in the source of the cell that a tetrahedron is or was part of.
inline std::uint64_t id_of_cell(const NeutralMesh& mesh, std::size_t cell) {
  return mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
}

/// Counts findings, added in any order, and keeps the five smallest ids.
class Tally {
 public:
  void add(std::uint64_t id) {
    ++count_;
    if (first_.size() == kept && id >= first_.back()) return;
    const auto at = std::lower_bound(first_.begin(), first_.end(), id);
    if (at != first_.end() && *at == id) return;  // parts of one source cell
    first_.insert(at, id);
    if (first_.size() > kept) first_.pop_back();
  }
  Finding finding(std::string name, std::string thing, std::string packing) && {
    return {.name = std::move(name),
            .thing = std::move(thing),
            .count = count_,
            .first_ids = std::move(first_),
            .packing = std::move(packing)};
  }

 private:
  static constexpr std::size_t kept = 5;
  std::uint64_t count_ = 0;
  std::vector<std::uint64_t> first_;
};

/// A face of a tetrahedron by its vertices, ascending, and its cell. `corner` is the cell's vertex
/// opposite the face.
struct CellFace {
  std::array<std::uint64_t, 3> vertices;
  std::uint64_t cell;
  std::uint8_t corner;
};

/// Returns all faces of the cells that can be traced (four different vertices, finite coordinates),
/// sorted by vertices, then by cells.
std::vector<CellFace> sorted_faces(const NeutralMesh& mesh);

/// False for a cell that packing drops.
bool is_traceable(const NeutralMesh& mesh, std::size_t cell);

using Findings = std::vector<Finding>;
/// not finite, coincident, not referenced
void coordinates(const NeutralMesh& mesh, Findings& findings);
/// a vertex twice, flat, flipped, slivers
void shapes(const NeutralMesh& mesh, Findings& findings);
/// faces shared by too many cells
void shared_faces(const NeutralMesh& mesh, const std::vector<CellFace>& faces, Findings& findings);
/// hanging points, cavities
void boundary(const NeutralMesh& mesh, const std::vector<CellFace>& faces, Findings& findings);
void overlaps(const NeutralMesh& mesh, Findings& findings);  ///< duplicated and overlapping cells
void values(const NeutralMesh& mesh, Findings& findings);    ///< not finite, for each field

}  // namespace rhoray::preprocess::inspect
