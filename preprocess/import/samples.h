#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// Turns numbers of `element_bytes` bytes into the machine's order, in place.
void make_native(std::span<std::byte> bytes, std::size_t element_bytes, bool big_endian);

/// Number of bytes of a volume; refuses an axis below 1 and sizes that do not fit 2^62 bytes.
std::uint64_t checked_volume_bytes(const std::filesystem::path& path, const Index3& sample_count,
                                   formats::ElementType type);

/// The same of colours of 8 bits a component, of which a texel has 3 or 4.
std::uint64_t checked_color_bytes(const std::filesystem::path& path, const Index3& sample_count, int component_count);

/// Refuses sizes that so short a file cannot hold even if packed by zlib as tightly as it can.
void check_packed_size(const std::filesystem::path& path, std::uint64_t wanted_bytes, std::uint64_t file_bytes);

/// True when numbers of this type stand in the machine's order already.
bool is_native(formats::ElementType type, bool big_endian);

void set_samples(NeutralVolume& volume, Array<std::byte> samples);

/// Samples that stand in the file as they are wanted stay there: no copy is made on the way to the
/// packer.
void leave_samples_in(NeutralVolume& volume, const ForeignFile& file, std::span<const std::byte> samples);

/// The last step of every reader: 64-bit integers become F64 where each is kept exactly and are
/// refused otherwise; a map that is not finite or not invertible is refused.
void finish_volume(NeutralVolume& volume, const std::filesystem::path& path);

/// Axes along x, y, z with this spacing.
Affine axis_parallel(const Vec3& spacing, const Vec3& origin);

/// One array among several in a file that keeps values at grid points or in grid cells.
struct GridArray {
  std::string name;
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
  bool in_cells = false;
  Array<std::byte> owned;  ///< either this,
  /// or a view of memory that outlives the array; native order,
  std::span<const std::byte> values;
  std::function<Array<std::byte>()> load{};  ///< or a way to read them, when they are chosen
};

/// What a grid of points looks like: sample (i, j, k) lies at world_from_grid.point({i, j, k}), or,
/// on an axis that has a table, at the table's entry instead of the index.
struct PointGrid {
  Index3 point_count;
  Affine world_from_grid;
  std::array<std::vector<double>, 3> axes{};
};

/// The grid whose points stand at these positions along x, y and z, rising or falling. An axis
/// whose steps are equal, as far as numbers of this precision can tell, needs no table. Refuses
/// positions that are not finite or turn back.
/// @param relative_precision  of one position, such as 2^-23 for 32-bit floats
PointGrid rectilinear_grid(const std::filesystem::path& path, const std::array<std::vector<double>, 3>& positions,
                           double relative_precision);

/// What is thrown where no field is named and no array has a single component.
class VectorsOnly : public Error {
 public:
  VectorsOnly(const Error& error, std::string first) : Error(error), first_(std::move(first)) {}
  const std::string& first() const { return first_; }  ///< the name of the first array

 private:
  std::string first_;
};

/// The volume of one array: `field` names it, or one component of it as NAME.x, NAME.y, NAME.z,
/// NAME.<n>, NAME.mag; empty takes the first with one component, or throws VectorsOnly. Values in
/// cells become samples at the middles of cells, with a note.
NeutralVolume volume_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

using TakeField = NeutralVolume(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                                const std::string& field);

/// The colours in one array of 3 or 4 8-bit components at points: the one that `field` names, or
/// the first.
NeutralVolume colors_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

}  // namespace rhoray::preprocess
