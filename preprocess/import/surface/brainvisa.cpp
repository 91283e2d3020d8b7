#include <array>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/surface/surface_building.h"

namespace rhoray::preprocess {

namespace {

/// The count after a dash: `- 870`, or `- 1736 1736 1736`.
std::uint64_t count_in(LineReader& lines, std::string_view what) {
  lines.need(what);
  if (lines.words().front() != "-") lines.refuse(lines.words().front(), concat("-, then ", what));
  return lines.number<std::uint64_t>(1, what);
}

}  // namespace

/// BrainVisa's text format: points, each with its normal, then triangles.
NeutralSurface read_brainvisa(const std::filesystem::path& path) {
  const ForeignFile file(path);
  LineReader lines(file, WordEnds::at_spaces);
  NeutralSurface surface;
  const std::uint64_t point_count = count_in(lines, "a number of points");
  for (std::uint64_t i = 0; i < point_count; ++i) {
    lines.need(concat(point_count, " points"));
    surface.points.push_back(lines.point(0));
    if (lines.words().size() != 6) lines.refuse(concat(lines.words().size(), " numbers"), "a point and its normal, 6");
  }
  const std::uint64_t triangle_count = count_in(lines, "a number of triangles");
  for (std::uint64_t i = 0; i < triangle_count; ++i) {
    lines.need(concat(triangle_count, " triangles"));
    std::array<std::uint64_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = lines.number<std::uint64_t>(k, "three corners");
    add_facet(surface, corners, path, concat("line ", lines.line_number()));
  }
  lines.note_rest("triangles", surface.notes);
  finish_surface(surface, path);
  return surface;
}

}  // namespace rhoray::preprocess
