#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "preprocess/neutral.h"
#include "render/cell/tet_crossing.h"
#include "tests/hard_cases/strict_tet.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {

/// Every change of side along a ray through the cells of a mesh, by our test and by the strict one.
/// Also the sides on which the ray enters and leaves the mesh, for a ray that does so once.
struct MeshCrossings {
  std::vector<double> ours, strict;
  bool enters_inside = false, leaves_inside = false;

  /// An odd number of changes leads to the other side, an even number to the same side.
  bool is_right(const std::vector<double>& changes) const {
    return (changes.size() % 2 != 0) == (enters_inside != leaves_inside);
  }
};

inline MeshCrossings crossings(const preprocess::NeutralMesh& mesh, double iso, const render::Ray& ray) {
  MeshCrossings found;
  double t_in = HUGE_VAL, t_out = -HUGE_VAL;
  const render::RayShear shear(ray);
  for (auto cell : mesh.cells) {
    std::sort(cell.begin(), cell.end());
    render::SeenTet tet;
    std::array<Vec3, 4> points;
    for (std::size_t i = 0; i < 4; ++i) {
      tet.vertex[i] = shear.see(mesh.points[cell[i]]);
      tet.value[i] = mesh.point_fields[0].values[cell[i]];
      points[i] = to_vec3(mesh.points[cell[i]]);
    }
    if (const auto passage = pass_through(tet, iso)) {
      if (const auto t = first_crossing(*passage)) found.ours.push_back(*t);
      if (passage->in.t < t_in) t_in = passage->in.t, found.enters_inside = render::is_inside(passage->in.value);
      if (passage->out.t > t_out) t_out = passage->out.t, found.leaves_inside = render::is_inside(passage->out.value);
    }
    const auto [lo, hi] = std::minmax_element(tet.value.begin(), tet.value.end());
    if (*lo <= iso && iso <= *hi)
      if (const auto t = strict_crossing(points, tet.value, iso, ray)) found.strict.push_back(*t);
  }
  std::sort(found.ours.begin(), found.ours.end());
  std::sort(found.strict.begin(), found.strict.end());
  return found;
}

}  // namespace rhoray::tests
