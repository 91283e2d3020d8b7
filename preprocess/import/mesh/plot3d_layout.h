#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// How the numbers of a PLOT3D file lie in it. The files do not say so themselves: it is found out
/// by what fits.
struct Plot3dLayout {
  bool is_solution = false;  ///< four numbers and five arrays for each block; else a grid: x, y, z
  bool is_text = false;
  bool is_big_endian = false;
  /// Fortran's: the byte count of each before and behind it, in 32 bits
  bool has_records = false;
  bool has_block_count = false;  ///< before the sizes of blocks
  bool has_iblank = false;       ///< of a grid: an integer for each point
  int float_bytes = 4;
  std::vector<Index3> blocks;     ///< points along each axis
  std::uint64_t data_offset = 0;  ///< bytes before the first block; of text, numbers before it
};

/// "a grid of 40 x 32 x 32 points, binary, little-endian, 32 bits, without IBLANK".
std::string in_words(const Plot3dLayout& layout);

/// Every layout with which the file would be as long as it is, to the byte (of text: to the
/// number). Zeros that fill the last 512 bytes are passed over when nothing fits without them.
std::vector<Plot3dLayout> plot3d_layouts(const ForeignFile& file);

/// The numbers of a text, between white space and commas. Fortran's `3*0.5` stands for three
/// numbers, `1.5D+3` for 1500.
class Plot3dNumbers {
 public:
  explicit Plot3dNumbers(std::string_view text) : text_(text) {}

  /// The next number, or nothing at the end and where something else stands.
  std::optional<double> next();

  /// Passes over the next number with all its repetitions and says how many they are.
  std::optional<std::uint64_t> skip();

 private:
  bool take_word();

  std::string_view text_;
  double value_ = 0;
  std::uint64_t left_ = 0;  ///< how often the value is still to be given
};

}  // namespace rhoray::preprocess
