#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/surface/surface_building.h"

namespace rhoray::preprocess {

NeutralSurface read_off(const std::filesystem::path& path) {
  const ForeignFile file(path);
  LineReader lines(file, WordEnds::at_spaces);
  lines.need("OFF");
  // C and N mean colours and normals after the coordinates, ST texture coordinates; all are
  // skipped.
  const std::string_view word = lines.words().front();
  if (word != "OFF" && word != "COFF" && word != "NOFF" && word != "CNOFF" && word != "STOFF")
    lines.refuse(word, "OFF");
  std::size_t at = 1;
  if (lines.words().size() > 1 && lines.words()[1] == "BINARY")
    lines.refuse("BINARY: numbers in binary", "a text file", ErrorCode::unsupported);
  if (lines.words().size() == 1) {
    lines.need("numbers of points and facets");
    at = 0;
  }
  const auto point_count = lines.number<std::uint64_t>(at, "a number of points");
  const auto facet_count = lines.number<std::uint64_t>(at + 1, "a number of facets");
  NeutralSurface surface;
  for (std::uint64_t i = 0; i < point_count; ++i) {
    lines.need(concat(point_count, " points"));
    surface.points.push_back(lines.point(0));
  }
  Array<std::uint64_t> corners;
  for (std::uint64_t i = 0; i < facet_count; ++i) {
    lines.need(concat(facet_count, " facets"));
    const auto count = lines.number<std::uint64_t>(0, "a number of corners");
    if (count >= lines.words().size()) lines.refuse("the line ends too early", concat(count, " corners"));
    corners.clear();
    for (std::uint64_t k = 1; k <= count; ++k) corners.push_back(lines.number<std::uint64_t>(k, "a corner"));
    add_facet(surface, corners, path, concat("line ", lines.line_number()));
  }
  lines.note_rest("facets", surface.notes);
  finish_surface(surface, path);
  return surface;
}

}  // namespace rhoray::preprocess
