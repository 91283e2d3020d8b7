#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "preprocess/mesh/inspect/finding.h"

namespace rhoray::preprocess {

namespace {

std::vector<Finding> findings_of(const NeutralMesh& mesh, const Progress& progress) {
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    for (const std::uint64_t vertex : mesh.cells[cell])
      if (vertex >= mesh.points.size())
        throw Error(ErrorCode::invalid, concat("cell ", inspect::id_of_cell(mesh, cell), ": found vertex ", vertex,
                                               "; expected a number below the count of points, ", mesh.points.size()));
  ProgressMeter meter(progress, "looking for faults", 6);
  std::vector<Finding> findings;
  const auto look = [&](auto&& at) {
    at();
    meter.add(1);
  };
  look([&] { inspect::coordinates(mesh, findings); });
  look([&] { inspect::shapes(mesh, findings); });
  std::vector<inspect::CellFace> faces;
  look([&] {
    faces = inspect::sorted_faces(mesh);
    inspect::shared_faces(mesh, faces, findings);
  });
  look([&] { inspect::boundary(mesh, faces, findings); });
  look([&] { inspect::overlaps(mesh, findings); });
  look([&] { inspect::values(mesh, findings); });
  return findings;
}

}  // namespace

std::vector<Finding> inspect_mesh(const NeutralMesh& mesh, const Progress& progress) {
  const DefaultFloatingPoint default_floating_point;
  return findings_of(mesh, progress);
}

}  // namespace rhoray::preprocess
