#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "formats/base/vector.h"
#include "preprocess/export/output_stream.h"

namespace rhoray::preprocess {

/// Writes a binary STL file, triangle by triangle. Corners are rounded to the format's 32 bits.
class StlFile {
 public:
  /// @param name  for messages; empty: the path
  explicit StlFile(const std::filesystem::path& path, const std::string& name = {});

  /// Leaves the triangle out when two corners are the same after rounding.
  void add(const Vec3& a, const Vec3& b, const Vec3& c);

  /// Completes the file and returns the number of triangles in it. Refuses a file that could not be
  /// written (ErrorCode::resource) and more triangles than the format can count.
  std::uint64_t finish();

 private:
  std::string name_;
  OutputStream file_;
  std::uint64_t triangle_count_ = 0;
};

}  // namespace rhoray::preprocess
