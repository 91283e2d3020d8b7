#pragma once

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/import/reading/text_reading.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The points of a TetGen .node file, or of part 1 of a .poly or .smesh file.
struct TetgenPoints {
  Array<std::array<double, 3>> points;
  std::vector<Array<double>> attributes;  ///< per attribute, one value per point
  std::int64_t first_number = 0;          ///< number of the first point: 0 or 1
  std::vector<std::string> notes;         ///< of a .node file
};

/// The binary records after a first line that ends in BIN, as Chaste writes them. A record is
/// 32-bit integers or doubles, then more doubles, little-endian, without its own number. Numbering
/// starts at 0. A comment may follow the last record.
class TetgenBinary {
 public:
  /// @param count  number of records, which must all be there
  TetgenBinary(const LineReader& lines, std::uint64_t count, std::uint64_t record_bytes);

  template <class T>
  T next() {
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);  // the constructor has checked the size
    rest_ = rest_.subspan(sizeof value);
    return value;
  }

 private:
  std::span<const std::byte> rest_;
};

/// True when the current line, the file's first, says that binary records follow.
bool is_tetgen_binary(const LineReader& lines);

/// Reads points. The current line of `lines` is their first line: count, dimension, attributes,
/// markers.
TetgenPoints read_tetgen_points(LineReader& lines);

/// Reads a whole .node file.
TetgenPoints read_tetgen_node_file(const std::filesystem::path& path);

/// Index of the point that word i of this line names; refuses a number without a point.
std::uint64_t tetgen_corner(const LineReader& lines, std::size_t i, const TetgenPoints& points);

/// The same for a number from a binary record.
std::uint64_t tetgen_corner(const LineReader& lines, std::uint32_t number, const TetgenPoints& points);

/// Where the records that a number counts begin.
enum class RecordPlace { on_next_line, from_this_line };

/// The current line's first word: the number of records that follow. Refuses more than the rest of
/// the file can hold.
std::uint64_t tetgen_count(const LineReader& lines, std::string_view what,
                           RecordPlace place = RecordPlace::on_next_line);

}  // namespace rhoray::preprocess
