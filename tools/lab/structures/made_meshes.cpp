#include "tools/lab/structures/made_meshes.h"

#include <cmath>

namespace rhoray::study {

using preprocess::NeutralMesh;

NeutralMesh graded(NeutralMesh mesh, double orders) {
  const double last_over_first = std::pow(10, orders / 3);
  for (auto& point : mesh.points)
    for (double& x : point) x = (std::pow(last_over_first, x) - 1) / (last_over_first - 1);
  return mesh;
}

NeutralMesh with_slivers(NeutralMesh mesh, std::int64_t edge) {
  for (auto& point : mesh.points) {
    const double layers = point[2] * static_cast<double>(edge), pairs = std::floor(layers / 2);
    const double rest = layers - 2 * pairs;
    point[2] = (pairs * 1.001 + (rest <= 1 ? rest : 1 + (rest - 1) * 1e-3)) / static_cast<double>(edge);
  }
  return mesh;
}

}  // namespace rhoray::study
