#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/surface/surface_building.h"

namespace rhoray::preprocess {
namespace {

/// A corner, "7", "7/1", "7//3" or "7/1/3". The first number counts points from 1, or backwards
/// from the last if negative.
std::uint64_t corner_of(const LineReader& lines, std::size_t i, std::size_t point_count) {
  const std::string_view word = lines.words()[i];
  const std::optional<std::int64_t> number = parse_number<std::int64_t>(word.substr(0, word.find('/')));
  const auto count = static_cast<std::int64_t>(point_count);
  if (!number || *number == 0 || *number > count || *number < -count)
    lines.refuse(word, concat("a point read before, 1 to ", count));
  return static_cast<std::uint64_t>(*number > 0 ? *number - 1 : count + *number);
}

}  // namespace

NeutralSurface read_obj(const std::filesystem::path& path) {
  const ForeignFile file = unpacked_file(path);
  LineReader lines(file, WordEnds::at_spaces);
  NeutralSurface surface;
  std::uint64_t left_out = 0;
  Array<std::uint64_t> corners;
  while (lines.next()) {
    const std::string_view keyword = lines.words().front();
    if (lines.words().back().ends_with('\\'))
      lines.refuse("a line that continues on the next", "each record on one line", ErrorCode::unsupported);
    if (keyword == "v") {
      surface.points.push_back(lines.point(1));
    } else if (keyword == "f") {
      corners.clear();
      for (std::size_t i = 1; i < lines.words().size(); ++i)
        corners.push_back(corner_of(lines, i, surface.points.size()));
      add_facet(surface, corners, path, concat("line ", lines.line_number()));
    } else if (keyword == "p" || keyword == "l" || keyword == "curv" || keyword == "surf") {
      ++left_out;
    }
  }
  if (left_out > 0) surface.notes.push_back(concat(left_out, " points, lines, curves or free-form surfaces left out"));
  finish_surface(surface, path);
  return surface;
}

}  // namespace rhoray::preprocess
