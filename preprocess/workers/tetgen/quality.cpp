#include "preprocess/workers/tetgen/quality.h"

#include <algorithm>
#include <cmath>

#include "formats/base/vector.h"

namespace rhoray::preprocess {

namespace {

Vec3 place_of(const NeutralMesh& mesh, std::uint64_t point) {
  const auto& p = mesh.points[point];
  return {p[0], p[1], p[2]};
}

}  // namespace

BadShare share_above(const NeutralMesh& mesh, double ratio) {
  double bad_count = 0, bad_volume = 0, volume = 0;
  for (const auto& cell : mesh.cells) {
    const Vec3 origin = place_of(mesh, cell[0]);
    const Vec3 a = place_of(mesh, cell[1]) - origin, b = place_of(mesh, cell[2]) - origin,
               c = place_of(mesh, cell[3]) - origin;
    const double six_volumes = std::abs(a.dot(b.cross(c)));
    const double shortest = std::sqrt(
        std::min({a.length2(), b.length2(), c.length2(), (a - b).length2(), (b - c).length2(), (c - a).length2()}));
    // The circumcentre seen from the origin is this vector divided by twice six volumes.
    const Vec3 centre = a.length2() * b.cross(c) + b.length2() * c.cross(a) + c.length2() * a.cross(b);
    volume += six_volumes;
    if (centre.length() <= ratio * shortest * 2 * six_volumes && six_volumes > 0) continue;
    bad_count += 1;
    bad_volume += six_volumes;
  }
  if (mesh.cells.empty()) return {};
  return {.of_cells = bad_count / static_cast<double>(mesh.cells.size()),
          .of_volume = volume > 0 ? bad_volume / volume : 1};
}

}  // namespace rhoray::preprocess
