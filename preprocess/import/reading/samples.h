#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Converts numbers of `element_bytes` bytes to the machine's byte order, in place.
void make_native(std::span<std::byte> bytes, std::size_t element_bytes, bool big_endian);

/// Number of bytes of a volume; refuses an axis below 1 and sizes that do not fit 2^62 bytes.
std::uint64_t checked_volume_bytes(const std::filesystem::path& path, const Index3& sample_count,
                                   formats::ElementType type);

/// The same for colours of 8 bits per component, with 3 or 4 components per texel.
std::uint64_t checked_color_bytes(const std::filesystem::path& path, const Index3& sample_count, int component_count);

/// Refuses sizes that a file this short cannot hold even at zlib's best compression.
void check_packed_size(const std::filesystem::path& path, std::uint64_t wanted_bytes, std::uint64_t file_bytes);

/// True when numbers of this type are already in the machine's byte order.
bool is_native(formats::ElementType type, bool big_endian);

/// Numbers in native byte order as doubles.
/// @param to  memory for all of them
void copy_as_doubles(formats::ElementType type, std::span<const std::byte> numbers, double* to);

/// The `wanted` bytes of samples behind the first `skipped`. Refuses a file that ends before.
std::span<const std::byte> samples_behind(const std::filesystem::path& path, std::span<const std::byte> source,
                                          std::uint64_t skipped, std::uint64_t wanted);

/// The name of file `number` in a series such as "slice%03d.raw"; nothing if the pattern does not
/// contain exactly one number.
std::optional<std::string> numbered_name(const std::string& pattern, std::int64_t number);

/// The value of a key in a table; nothing if it is not there.
template <class Key, class Value, std::size_t N, class Sought>
std::optional<Value> find_in(const std::pair<Key, Value> (&table)[N], const Sought& sought) {
  for (const auto& [key, value] : table)
    if (key == sought) return value;
  return std::nullopt;
}

void set_samples(NeutralVolume& volume, Array<std::byte> samples);

/// Leaves samples in the file if they already have the wanted form, so that nothing is copied on
/// the way to the packer.
void leave_samples_in(NeutralVolume& volume, const ForeignFile& file, std::span<const std::byte> samples);

/// Last step of every volume reader. Converts 64-bit integers to F64 if every value is exact, and
/// refuses them otherwise. Refuses a map that is not finite or not invertible.
void finish_volume(NeutralVolume& volume, const std::filesystem::path& path);

/// Returns axes along x, y, z with this spacing.
Affine axis_parallel(const Vec3& spacing, const Vec3& origin);

/// One array of a file that stores several, with values at grid points or in grid cells.
struct GridArray {
  std::string name;
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
  bool in_cells = false;
  Array<std::byte> values;                   ///< in native byte order; either these
  std::function<Array<std::byte>()> load{};  ///< or what reads them when the array is chosen
};

/// A grid of points. Sample (i, j, k) lies at world_from_grid.point({i, j, k}). On an axis with a
/// table, the table's entry replaces the index.
struct PointGrid {
  Index3 point_count;
  Affine world_from_grid;
  std::array<std::vector<double>, 3> axes{};
};

/// The grid with points at these positions along x, y and z, increasing or decreasing. An axis with
/// equal steps, within the given precision, needs no table. Refuses positions that are not finite
/// or not monotonic.
/// @param relative_precision  of one position, such as 2^-23 for 32-bit floats
PointGrid rectilinear_grid(const std::filesystem::path& path, const std::array<std::vector<double>, 3>& positions,
                           double relative_precision);

/// Thrown when no field is named and no array has a single component.
class VectorsOnly : public Error {
 public:
  VectorsOnly(const Error& error, std::string first) : Error(error), first_(std::move(first)) {}
  const std::string& first() const { return first_; }  ///< name of the first array

 private:
  std::string first_;
};

/// The volume of one array. `field` names the array, or one component of it as NAME.x, NAME.y,
/// NAME.z, NAME.<n>, NAME.mag. Empty selects the first array with one component, or throws
/// VectorsOnly. Cell values become samples at cell centres, with a note.
NeutralVolume volume_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

using TakeField = NeutralVolume(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                                const std::string& field);

/// The colours in one point array of 3 or 4 8-bit components: the one that `field` names, or the
/// first.
NeutralVolume colors_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

}  // namespace rhoray::preprocess
