#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A part of an array: along each axis `count` indices from `start` on, `stride` apart.
struct Hyperslab {
  std::vector<std::uint64_t> start, stride, count;
};

/// A data set of numbers in an HDF5 file, read by HDF5's library. Nothing outside the file is read:
/// external links, external storage and virtual data sets are refused.
class Hdf5DataSet {
 public:
  const std::vector<std::uint64_t>& shape() const { return shape_; }  ///< slowest axis first
  formats::ElementType type() const { return type_; }

  /// Refuses so many bytes, if the file does not store as many even at zlib's best compression.
  void check_bytes(std::uint64_t wanted) const;

  /// Reads all numbers, or those of a part inside the shape. T is double, std::int64_t, or
  /// std::byte for numbers of type() in native byte order. `to` has memory for all.
  template <class T>
  void read(std::span<T> to, const Hyperslab* part = nullptr) const;

 private:
  friend class Hdf5File;
  class Handle;

  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const;

  std::filesystem::path path_;
  std::string name_;
  std::shared_ptr<const Handle> file_, data_set_;
  std::vector<std::uint64_t> shape_;
  formats::ElementType type_ = formats::ElementType::U8;
  std::uint64_t stored_bytes_ = 0;  ///< at most the size of the file
};

/// An HDF5 file, open for reading. Refusals name the file and the data set.
class Hdf5File {
 public:
  explicit Hdf5File(const std::filesystem::path& path);

  /// Refuses one that is missing, other data than integers and floats of 16, 32 or 64 bits, and
  /// data outside the file.
  Hdf5DataSet data_set(const std::string& name) const;

 private:
  std::filesystem::path path_;
  std::shared_ptr<const Hdf5DataSet::Handle> file_;
  std::uint64_t bytes_ = 0;
};

}  // namespace rhoray::preprocess
