#include <algorithm>

#include "preprocess/tetrahedralize.h"

namespace rhoray::preprocess {

namespace {

void append_facets(const NeutralSurface& from, NeutralSurface& to, bool in_faces) {
  const std::uint64_t first_point = to.points.size() - from.points.size(), first_corner = to.facet_corners.size();
  const std::uint64_t first_face = to.facet_faces.empty() ? 0 : to.facet_faces.back() + 1;
  for (const std::uint64_t corner : from.facet_corners) to.facet_corners.push_back(first_point + corner);
  for (std::size_t f = 1; f < from.facet_offsets.size(); ++f) {
    to.facet_offsets.push_back(first_corner + from.facet_offsets[f]);
    if (in_faces) to.facet_faces.push_back(first_face + (from.facet_faces.empty() ? f - 1 : from.facet_faces[f - 1]));
  }
  for (const auto& opening : from.openings) to.openings.push_back({first_face + opening.face, opening.seed});
}

}  // namespace

NeutralSurface join(std::span<const NeutralSurface> surfaces) {
  const auto any = [&](auto holds) { return std::any_of(surfaces.begin(), surfaces.end(), holds); };
  const bool in_faces = any([](const NeutralSurface& s) { return !s.facet_faces.empty(); });
  const bool with_sizes = any([](const NeutralSurface& s) { return !s.point_sizes.empty(); });
  NeutralSurface all;
  for (const NeutralSurface& s : surfaces) {
    all.points.insert(all.points.end(), s.points.begin(), s.points.end());
    all.point_sizes.insert(all.point_sizes.end(), s.point_sizes.begin(), s.point_sizes.end());
    if (with_sizes) all.point_sizes.resize(all.points.size(), 0);  // 0: none wanted
    append_facets(s, all, in_faces);
    all.holes.insert(all.holes.end(), s.holes.begin(), s.holes.end());
    all.regions.insert(all.regions.end(), s.regions.begin(), s.regions.end());
    all.notes.insert(all.notes.end(), s.notes.begin(), s.notes.end());
    all.sources.insert(all.sources.end(), s.sources.begin(), s.sources.end());
  }
  return all;
}

}  // namespace rhoray::preprocess
