#include "preprocess/import/mesh/netcdf_classic.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "formats/base/bytes.h"

namespace rhoray::preprocess {
namespace {

/// Bytes per number, for the types numbered from 1: byte, char, short, int, float, double, and in
/// CDF-5 the unsigned and 64-bit ones.
constexpr std::uint64_t type_bytes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};

class Header {
 public:
  explicit Header(const ForeignFile& file) : file_(file), version_(std::to_integer<int>(file.bytes()[3])) {}

  void check() {
    const std::uint64_t records = number(count_bytes());
    const bool is_streaming = records == (version_ == 5 ? ~std::uint64_t{0} : 0xffffffffU);
    read_dimensions();
    skip_attributes();
    read_variables();
    check_extent(is_streaming ? 0 : records);
  }

 private:
  struct Extent {
    std::uint64_t begin, bytes;
    bool is_record;
  };

  std::uint64_t count_bytes() const { return version_ == 5 ? 8 : 4; }
  std::uint64_t offset_bytes() const { return version_ == 1 ? 4 : 8; }

  [[noreturn]] void refuse(std::string_view found, std::string_view expected) const {
    refuse_input(file_.path(), concat("byte ", position_), found, expected);
  }

  void skip(std::uint64_t bytes) {
    if (bytes > file_.bytes().size() - position_) refuse("the end of the file", "more of the netCDF header");
    position_ += bytes;
  }

  std::uint64_t number(std::uint64_t bytes) {
    const std::uint64_t begin = position_;
    skip(bytes);
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < bytes; ++i)
      value = (value << 8) | std::to_integer<std::uint64_t>(file_.bytes()[begin + i]);
    return value;
  }

  /// Skips `bytes`, padded to four.
  void skip_padded(std::uint64_t bytes) {
    if (bytes > file_.bytes().size()) refuse(concat(bytes, " bytes"), "no more than the file has");
    skip((bytes + 3) / 4 * 4);
  }

  /// Length of the list that starts here; its elements have at least 8 bytes.
  std::uint64_t list(std::uint64_t tag) {
    const std::uint64_t found = number(4), count = number(count_bytes());
    if (found != tag && !(found == 0 && count == 0)) refuse(concat("a list marked ", found), concat(tag));
    if (count > (file_.bytes().size() - position_) / 8)
      refuse(concat("a list of ", count), "no more than the file can hold");
    return count;
  }

  void read_dimensions() {
    for (std::uint64_t left = list(10); left > 0; --left) {
      skip_padded(number(count_bytes()));
      dimensions_.push_back(number(count_bytes()));
    }
  }

  std::uint64_t type() {
    const std::uint64_t found = number(4);
    if (found == 0 || found >= std::size(type_bytes)) refuse(concat("a type numbered ", found), "1 to 11");
    return type_bytes[found];
  }

  void skip_attributes() {
    for (std::uint64_t left = list(12); left > 0; --left) {
      skip_padded(number(count_bytes()));
      const std::uint64_t bytes = type();
      const std::optional<std::uint64_t> size = checked_product({bytes, number(count_bytes())});
      skip_padded(size.value_or(~std::uint64_t{0}));
    }
  }

  void read_variables() {
    for (std::uint64_t left = list(11); left > 0; --left) {
      skip_padded(number(count_bytes()));
      Extent extent{0, 1, false};
      for (std::uint64_t axes = number(count_bytes()), axis = 0; axis < axes; ++axis) {
        const std::uint64_t dimension = number(count_bytes());
        if (dimension >= dimensions_.size())
          refuse(concat("dimension ", dimension), concat("one below ", dimensions_.size()));
        if (axis == 0 && dimensions_[dimension] == 0) {
          extent.is_record = true;
          continue;
        }
        const std::optional<std::uint64_t> bytes = checked_product({extent.bytes, dimensions_[dimension]});
        if (!bytes) refuse("a variable of more than 2^64 numbers", "fewer");
        extent.bytes = *bytes;
      }
      skip_attributes();
      const std::optional<std::uint64_t> bytes = checked_product({extent.bytes, type()});
      if (!bytes) refuse("a variable of more than 2^64 bytes", "fewer");
      extent.bytes = *bytes;
      skip(count_bytes());  // its size again, in a form that overflows
      extent.begin = number(offset_bytes());
      extents_.push_back(extent);
    }
  }

  /// Records of all variables are interleaved, padded to four bytes unless there is only one.
  void check_extent(std::uint64_t records) {
    std::uint64_t record_bytes = 0;
    const auto kinds = std::count_if(extents_.begin(), extents_.end(), [](const Extent& e) { return e.is_record; });
    const std::uint64_t file_bytes = file_.bytes().size();
    for (const Extent& extent : extents_) {
      if (extent.bytes > file_bytes) refuse_end(extent.bytes);
      if (extent.is_record) record_bytes += kinds == 1 ? extent.bytes : (extent.bytes + 3) / 4 * 4;
    }
    for (const Extent& extent : extents_) {
      if (extent.is_record && records == 0) continue;
      const std::optional<std::uint64_t> before =
          extent.is_record ? checked_product({records - 1, record_bytes}) : std::optional<std::uint64_t>(0);
      if (extent.begin > file_bytes || !before || *before > file_bytes) refuse_end(extent.begin);
      // three numbers, each no larger than a file can be
      const std::uint64_t end = extent.begin + *before + extent.bytes;
      if (end > file_bytes) refuse_end(end);
    }
  }

  [[noreturn]] void refuse_end(std::uint64_t expected) const {
    refuse_input(file_.path(), "variables", concat("a file of ", file_.bytes().size(), " bytes"),
                 concat("at least ", expected, ", as its header says"));
  }

  const ForeignFile& file_;
  int version_;
  std::uint64_t position_ = 4;
  std::vector<std::uint64_t> dimensions_;
  std::vector<Extent> extents_;
};

}  // namespace

void check_classic_netcdf(const ForeignFile& file) {
  const std::string_view text = file.text();
  if (!text.starts_with("CDF") || text.size() < 4) return;
  if (text[3] == 1 || text[3] == 2 || text[3] == 5) Header(file).check();
}

}  // namespace rhoray::preprocess
