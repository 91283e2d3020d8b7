#pragma once

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

/// Reads points whose first line (how many, dimension, attributes, markers) is the current line of `lines`.
TetgenPoints read_tetgen_points(LineReader& lines);

/// Reads a whole .node file.
TetgenPoints read_tetgen_node_file(const std::filesystem::path& path);

/// The position of the point that word i of this line names; refuses numbers outside the points.
std::uint64_t tetgen_corner(const LineReader& lines, std::size_t i, const TetgenPoints& points);

/// The current line's first word: how many records follow. Refuses more than the rest of the file can hold.
std::uint64_t tetgen_count(const LineReader& lines, std::string_view what);

}  // namespace rhoray::preprocess
