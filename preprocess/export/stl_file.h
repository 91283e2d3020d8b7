#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/export/output_stream.h"

namespace rhoray::preprocess {

struct StlCounts {
  std::uint64_t written = 0;
  /// left out, because rounding to single precision joined corners that differed
  std::uint64_t vanished = 0;
};

/// Adds a note on vanished triangles, if there are some.
void note_vanished(const StlCounts& triangles, std::vector<std::string>& notes);

/// Writes a binary STL file, triangle by triangle. Corners are rounded to the format's 32 bits.
class StlFile {
 public:
  /// @param name  for messages; empty: the path
  explicit StlFile(const std::filesystem::path& path, const std::string& name = {});

  /// Leaves the triangle out when two corners are the same after rounding. Refuses a corner beyond
  /// the range of single precision (ErrorCode::unsupported).
  void add(const Vec3& a, const Vec3& b, const Vec3& c);

  /// Completes the file. Refuses a file that could not be written (ErrorCode::resource). Refuses
  /// more triangles than the format can count, and a surface of which all triangles vanished
  /// (ErrorCode::unsupported).
  StlCounts finish();

 private:
  std::array<float, 3> in_single_precision(const Vec3& corner) const;

  std::string name_;
  OutputStream file_;
  StlCounts triangles_;
};

}  // namespace rhoray::preprocess
