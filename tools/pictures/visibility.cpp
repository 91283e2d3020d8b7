#include "tools/pictures/visibility.h"

namespace rhoray::tools {

bool Visibility::is_before_surfaces(int x, int y, const Seen& from, const Seen& to, double share) const {
  const double distance = projection_.is_orthographic() ? from.distance + share * (to.distance - from.distance)
                                                        : 1 / ((1 - share) / from.distance + share / to.distance);
  const auto pixel =
      static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.width) + static_cast<std::size_t>(x);
  constexpr double slack = 2e-3;  // lines that lie in surfaces are visible
  return distance * projection_.ray_length({x + 0.5, y + 0.5}) <=
         static_cast<double>(picture_.depth[pixel]) * (1 + slack);
}

}  // namespace rhoray::tools
