#include "preprocess/import/mesh/tetgen_text.h"

#include <bit>

#include "formats/base/bytes.h"

namespace rhoray::preprocess {

static_assert(std::endian::native == std::endian::little, "TetgenBinary copies little-endian numbers");

TetgenBinary::TetgenBinary(const LineReader& lines, std::uint64_t count, std::uint64_t record_bytes) {
  const std::optional<std::uint64_t> size = checked_product({count, record_bytes});
  const std::span<const std::byte> there = lines.rest();
  if (!size || *size > there.size())
    lines.refuse(concat(there.size(), " bytes behind it"), concat(count, " records of ", record_bytes, " bytes"));
  rest_ = there.first(*size);
  const std::span<const std::byte> behind = there.subspan(*size);
  const bool is_comment = !behind.empty() && (behind.front() == std::byte{'#'} || behind.front() == std::byte{'\n'});
  if (!behind.empty() && !is_comment)
    lines.refuse(concat(behind.size(), " bytes behind the records"), "a comment or nothing");
}

bool is_tetgen_binary(const LineReader& lines) {
  return lines.words().back() == "BIN";
}

std::uint64_t tetgen_count(const LineReader& lines, std::string_view what, RecordPlace place) {
  const auto count = lines.number<std::uint64_t>(0, what);
  std::uint64_t bytes = lines.bytes_left();
  if (place == RecordPlace::from_this_line && lines.words().size() > 1) bytes += lines.text_from(1).size() + 1;
  if (count > bytes / 2 + 1)  // a record has at least a digit and an end of line or a blank
    lines.refuse(concat(count, " records in ", bytes, " bytes"), what);
  return count;
}

TetgenPoints read_tetgen_points(LineReader& lines) {
  const std::uint64_t count = tetgen_count(lines, "a number of points");
  if (lines.words().size() > 1 && lines.number<int>(1, "the dimension") != 3)
    lines.refuse(lines.words()[1], "3 dimensions", ErrorCode::unsupported);
  const auto attribute_count = lines.words().size() > 2 ? lines.number<std::uint64_t>(2, "a number of attributes") : 0;
  if (attribute_count > 1024) lines.refuse(lines.words()[2], "at most 1024 attributes");

  TetgenPoints result;
  result.attributes.resize(count == 0 ? 0 : attribute_count);
  if (is_tetgen_binary(lines)) {
    TetgenBinary records(lines, count, (3 + attribute_count) * sizeof(double));
    for (std::uint64_t i = 0; i < count; ++i) {
      for (double& coordinate : result.points.emplace_back()) coordinate = records.next<double>();
      for (Array<double>& values : result.attributes) values.push_back(records.next<double>());
    }
    return result;
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    lines.need(concat(count, " points"));
    const auto number = lines.number<std::int64_t>(0, "a point's number");
    if (i == 0) result.first_number = number;
    if (number != result.first_number + static_cast<std::int64_t>(i) || result.first_number < 0 ||
        result.first_number > 1)
      lines.refuse(lines.words()[0], i == 0 ? "0 or 1" : concat(result.first_number + static_cast<std::int64_t>(i)));
    result.points.push_back(lines.point(1));
    for (std::size_t a = 0; a < attribute_count; ++a)
      result.attributes[a].push_back(lines.number<double>(4 + a, concat(attribute_count, " attributes")));
  }
  return result;
}

TetgenPoints read_tetgen_node_file(const std::filesystem::path& path) {
  const ForeignFile file(path);
  LineReader lines(file);
  lines.need("a number of points");
  const bool is_binary = is_tetgen_binary(lines);
  TetgenPoints points = read_tetgen_points(lines);
  if (!is_binary) lines.note_rest("points", points.notes);
  return points;
}

std::uint64_t tetgen_corner(const LineReader& lines, std::uint32_t number, const TetgenPoints& points) {
  if (number >= points.points.size())
    lines.refuse(concat("a record with point ", number), concat("0 to ", points.points.size() - 1));
  return number;
}

std::uint64_t tetgen_corner(const LineReader& lines, std::size_t i, const TetgenPoints& points) {
  const std::int64_t position = lines.number<std::int64_t>(i, "a point's number") - points.first_number;
  if (position < 0 || static_cast<std::uint64_t>(position) >= points.points.size())
    lines.refuse(lines.words()[i], concat("a point's number, ", points.first_number, " to ",
                                          points.first_number + static_cast<std::int64_t>(points.points.size()) - 1));
  return static_cast<std::uint64_t>(position);
}

}  // namespace rhoray::preprocess
