#include <CGAL/alpha_wrap_3.h>

#include "preprocess/workers/repair/steps.h"

namespace rhoray::preprocess::repair {

TriangleMesh wrap(const Soup& soup, double gap, double offset) {
  TriangleMesh mesh;
  CGAL::alpha_wrap_3(soup.points, soup.facets, gap, offset, mesh);
  return mesh;
}

}  // namespace rhoray::preprocess::repair
