#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A netCDF file of any of its formats, open for reading. Every refusal names the file and the
/// variable.
///
/// The library reads zeros where a classic file was cut off, and believes any size that is written
/// in a header: here a file is refused when the variables that its header lists do not fit into it.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  struct Variable {
    int id = 0;
    std::string name;
    int type = 0;                      ///< nc_type
    std::vector<std::uint64_t> shape;  ///< slowest first
  };

  const std::filesystem::path& path() const { return path_; }
  std::optional<std::uint64_t> dimension(const std::string& name) const;
  std::optional<Variable> variable(const std::string& name) const;
  Variable need_variable(const std::string& name) const;

  /// The numbers of this shape, of a variable or, with `first` given, of its part [first, ...]
  /// along the slowest axis. Refuses a variable that has another shape or holds no numbers.
  Array<double> numbers(const Variable& variable, std::span<const std::uint64_t> shape,
                        std::optional<std::uint64_t> first = {}) const;
  Array<std::int64_t> integers(const Variable& variable, std::span<const std::uint64_t> shape) const;

  /// The rows of a two-dimensional variable of letters, without what fills them up.
  std::vector<std::string> texts(const Variable& variable) const;

  /// An attribute that is a text; empty when there is none.
  std::string text_attribute(const Variable& variable, const std::string& name) const;

  static bool is_double_precision(const Variable& variable);

 private:
  std::uint64_t checked_count(const Variable& variable, std::span<const std::uint64_t> shape, bool is_part) const;
  void check(int status, std::string_view place) const;

  std::filesystem::path path_;
  std::uint64_t file_bytes_ = 0;
  int id_ = -1;
};

}  // namespace rhoray::preprocess
