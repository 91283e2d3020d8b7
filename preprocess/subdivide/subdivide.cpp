#include "preprocess/subdivide.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "formats/base/trouble.h"

namespace rhoray::preprocess {

NeutralMesh subdivide(CellMesh mesh, const SubdivideOptions&, const Progress&) {
  const auto others =
      std::count_if(mesh.kinds.begin(), mesh.kinds.end(), [](CellKind kind) { return kind != CellKind::tetrahedron; });
  if (others != 0)
    throw Error(Trouble::unsupported, concat("cells: found ", others, " that are no linear tetrahedra; expected 0"));
  NeutralMesh result;
  result.points = std::move(mesh.points);
  result.cells.resize(mesh.kinds.size());
  if (!mesh.kinds.empty())
    std::memcpy(result.cells.data(), mesh.cell_nodes.data(), mesh.cell_nodes.size() * sizeof(std::uint64_t));
  result.cell_ids = std::move(mesh.cell_ids);
  result.point_fields = std::move(mesh.point_fields);
  result.cell_fields = std::move(mesh.cell_fields);
  result.length_unit = std::move(mesh.length_unit);
  result.notes = std::move(mesh.notes);
  return result;
}

}  // namespace rhoray::preprocess
