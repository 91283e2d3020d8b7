#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Layout of the numbers in a PLOT3D file. The files do not describe it; it is inferred from what
/// fits.
struct Plot3dLayout {
  bool is_solution = false;  ///< four numbers and five arrays per block; else a grid: x, y, z
  bool is_text = false;
  bool is_big_endian = false;
  /// Fortran records: each has its 32-bit byte count before and after it
  bool has_records = false;
  bool has_block_count = false;  ///< stored before the block sizes
  bool has_iblank = false;       ///< of a grid: one integer per point
  int float_bytes = 4;
  std::vector<Index3> blocks;     ///< points along each axis
  std::uint64_t data_offset = 0;  ///< bytes before the first block; in text, numbers before it
};

/// "a grid of 40 x 32 x 32 points, binary, little-endian, 32 bits, without IBLANK".
std::string in_words(const Plot3dLayout& layout);

/// Every layout whose length equals the file's, to the byte (for text: to the number). If none
/// fits, trailing zeros that fill the last 512 bytes are ignored.
std::vector<Plot3dLayout> plot3d_layouts(const ForeignFile& file);

/// Numbers of a text file, separated by white space and commas. Fortran's `3*0.5` stands for three
/// numbers, `1.5D+3` for 1500.
class Plot3dNumbers {
 public:
  explicit Plot3dNumbers(std::string_view text) : text_(text) {}

  /// The next number; nothing at the end or before other text.
  std::optional<double> next();

  /// Skips the next number with its repetitions and returns how many there are.
  std::optional<std::uint64_t> skip();

 private:
  bool take_word();

  std::string_view text_;
  double value_ = 0;
  std::uint64_t left_ = 0;  ///< repetitions of the value still to return
};

}  // namespace rhoray::preprocess
