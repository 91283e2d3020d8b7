#include "tools/pictures/surface_lines.h"

#include <optional>
#include <utility>

namespace rhoray::tools {

namespace {

/// The part of a line in front of the eye's plane; nothing where there is none.
std::optional<std::pair<Seen, Seen>> seen_part(std::array<Vec3, 2> line, const Projection& projection) {
  std::array<Seen, 2> ends{projection.of(line[0]), projection.of(line[1])};
  if (projection.is_orthographic()) return std::pair(ends[0], ends[1]);
  if (!(ends[0].distance > 0 || ends[1].distance > 0)) return std::nullopt;
  constexpr double nearest_share = 1e-3;  // of the other end's distance
  for (const std::size_t i : {0U, 1U}) {
    const std::size_t other = 1 - i;
    const double nearest = nearest_share * ends[other].distance;
    if (ends[i].distance >= nearest) continue;
    const double share = (ends[other].distance - nearest) / (ends[other].distance - ends[i].distance);
    ends[i] = projection.of(line[other] + share * (line[i] - line[other]));
  }
  return std::pair(ends[0], ends[1]);
}

}  // namespace

void draw_surface_lines(const SurfaceLines& lines, const Projection& projection, const Visibility& visibility,
                        double width, Canvas& canvas) {
  std::vector<std::pair<Seen, Seen>> seen;
  std::vector<std::array<Spot, 2>> ends;
  for (const std::array<Vec3, 2>& line : lines.lines)
    if (const auto part = seen_part(line, projection)) {
      seen.push_back(*part);
      ends.push_back({part->first.at, part->second.at});
    }
  canvas.lines(ends, width, lines.color, [&](std::size_t i, int x, int y, double share) {
    return visibility.is_before_surfaces(x, y, seen[i].first, seen[i].second, share);
  });
}

}  // namespace rhoray::tools
