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

  /// Refuses so many bytes, if the file does not store as many: packed ones even at zlib's best
  /// compression.
  void check_bytes(std::uint64_t wanted) const;

  /// Reads all numbers, or those of a part inside the shape. T is double, std::int64_t, or
  /// std::byte for numbers of type() in native byte order. `to` has memory for all. Refuses like
  /// Hdf5File::check_written.
  template <class T>
  void read(std::span<T> to, const Hyperslab* part = nullptr) const;

  class Handle;  ///< an identifier of the library

 private:
  friend class Hdf5File;

  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const;

  std::filesystem::path path_;
  std::string name_;
  std::shared_ptr<const Handle> file_, data_set_;
  std::vector<std::uint64_t> shape_;
  formats::ElementType type_ = formats::ElementType::U8;
  std::uint64_t stored_bytes_ = 0;  ///< at most the size of the file
  bool is_packed_ = false;          ///< by filters, or not all of it needs to be stored
};

/// An HDF5 file, open for reading. Refusals name the file and the data set.
class Hdf5File {
 public:
  /// HDF5's library takes a file opened by two drivers for two files. So a library that opens it by
  /// `direct`, as netCDF's does, needs none of the settings of a file opened by `buffered`.
  enum class Driver { direct, buffered };

  explicit Hdf5File(const std::filesystem::path& path, Driver driver = Driver::direct);

  /// Refuses one that is missing, other data than integers and floats of 16, 32 or 64 bits, and
  /// data outside the file.
  Hdf5DataSet data_set(const std::string& name) const;

  static bool is_hdf5(const std::filesystem::path& path);

  /// Refuses links to other files, and data sets whose numbers are in other files. A library that
  /// opens the file may follow all of them.
  void check_links() const;

  /// Refuses a data set or a part of it if numbers were never written and the file has no fill
  /// value for them: HDF5 reads zeros there. Accepts a name that no data set has.
  void check_written(const std::string& name, const Hyperslab* part = nullptr) const;

 private:
  std::filesystem::path path_;
  std::shared_ptr<const Hdf5DataSet::Handle> file_;
  std::uint64_t bytes_ = 0;
};

}  // namespace rhoray::preprocess
