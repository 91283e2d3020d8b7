#pragma once

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/import/text_reading.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The points of a TetGen .node file, or of part 1 of a .poly or .smesh file.
struct TetgenPoints {
  Array<std::array<double, 3>> points;
  std::vector<Array<double>> attributes;  ///< for each attribute one value for each point
  std::int64_t first_number = 0;          ///< the number of the first point: 0 or 1
};

/// The records behind a first line that ends in BIN, as Chaste writes them: integers of 32 bits or
/// doubles, then more doubles, little-endian, without a number of their own. Counting begins with
/// 0. A comment may follow the last one.
class TetgenBinary {
 public:
  /// @param count  of the records, which must be there
  TetgenBinary(const LineReader& lines, std::uint64_t count, std::uint64_t record_bytes);

  template <class T>
  T next() {
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);  // the constructor has seen that it is there
    rest_ = rest_.subspan(sizeof value);
    return value;
  }

 private:
  std::span<const std::byte> rest_;
};

/// True when the current line, a file's first, says that binary records follow.
bool is_tetgen_binary(const LineReader& lines);

/// Reads points whose first line (how many, dimension, attributes, markers) is the current line of
/// `lines`.
TetgenPoints read_tetgen_points(LineReader& lines);

/// Reads a whole .node file.
TetgenPoints read_tetgen_node_file(const std::filesystem::path& path);

/// The position of the point that word i of this line names; refuses numbers outside the points.
std::uint64_t tetgen_corner(const LineReader& lines, std::size_t i, const TetgenPoints& points);

/// As above, for a number from a binary record.
std::uint64_t tetgen_corner(const LineReader& lines, std::uint32_t number, const TetgenPoints& points);

/// The current line's first word: how many records follow. Refuses more than the rest of the file
/// can hold.
std::uint64_t tetgen_count(const LineReader& lines, std::string_view what);

}  // namespace rhoray::preprocess
