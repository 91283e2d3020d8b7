#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/reading/hdf5_file.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A netCDF file in any of its formats, or another HDF5 file, open for reading. Every refusal names
/// the file and the variable. Names of variables may begin with groups: "VTKHDF/PointData/flow".
///
/// The library reads zeros where a classic file was cut off, and accepts any size in a header. This
/// class refuses a file that is too short for the variables in its header. It refuses an HDF5 file
/// that leads to other files, and numbers in it that were never written (Hdf5File).
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  struct Variable {
    int id = 0;
    int group = 0;  ///< of the library
    std::string name;
    int type = 0;                      ///< nc_type
    std::vector<std::uint64_t> shape;  ///< slowest axis first
  };

  const std::filesystem::path& path() const { return path_; }
  std::optional<std::uint64_t> dimension(const std::string& name) const;
  std::optional<Variable> variable(const std::string& name) const;
  Variable need_variable(const std::string& name) const;

  bool has_group(const std::string& group) const;
  /// Names of the variables in a group, without it; none when there is no such group.
  std::vector<std::string> names_in(const std::string& group) const;

  /// An attribute of a group; empty when there is none of numbers, or of text.
  std::vector<double> number_attribute(const std::string& group, const std::string& name) const;
  std::string text_attribute(const std::string& group, const std::string& name) const;

  /// The type of a variable's numbers; nothing when it holds others, such as texts.
  static std::optional<formats::ElementType> element_type(const Variable& variable);

  /// All numbers of a variable with this shape, in its element_type and native byte order.
  Array<std::byte> bytes(const Variable& variable, std::span<const std::uint64_t> shape) const;

  /// Numbers of a variable with this shape or, if `first` is given, of its part [first, ...] along
  /// the slowest axis. Refuses a variable with another shape or without numbers.
  Array<double> numbers(const Variable& variable, std::span<const std::uint64_t> shape,
                        std::optional<std::uint64_t> first = {}) const;
  Array<std::int64_t> integers(const Variable& variable, std::span<const std::uint64_t> shape) const;

  /// The rows of a two-dimensional character variable, without padding.
  std::vector<std::string> texts(const Variable& variable) const;

  /// A text attribute; empty when there is none.
  std::string text_attribute(const Variable& variable, const std::string& name) const;

  /// The number that stands where nothing was written: the variable's _FillValue, or netCDF's for
  /// floating-point numbers. NaN for other variables.
  double fill_value(const Variable& variable) const;

  static bool is_double_precision(const Variable& variable);

 private:
  std::uint64_t checked_count(const Variable& variable, std::span<const std::uint64_t> shape, bool is_part) const;
  /// Refuses numbers that were never written, of all or of the part [first, ...].
  void check_written(const Variable& variable, std::optional<std::uint64_t> first = {}) const;
  void check(int status, std::string_view place) const;
  std::optional<int> group_id(const std::string& group) const;
  std::string text_attribute(int group, int variable, const std::string& name, std::string_view place) const;

  std::filesystem::path path_;
  std::uint64_t file_bytes_ = 0;
  std::optional<Hdf5File> hdf5_;
  int id_ = -1;
};

}  // namespace rhoray::preprocess
