#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/import/reading/point_grid.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Volumes made from the arrays of a file. An array with several numbers for each sample gives a
/// scalar by the rule of components.h.

/// A scalar of one of several arrays.
struct ScalarChoice {
  std::size_t array = 0;
  int component = 0;  ///< or magnitude_component
};

/// The scalar that `field` names. Without a name: the first array with one number for each sample,
/// else the magnitude of the first array. Refuses other names with the existing ones.
ScalarChoice choose_scalar(const std::filesystem::path& path, const std::vector<VectorArray>& arrays,
                           const std::string& field);

/// Names the chosen scalar in a volume, and the scalars and arrays that were not chosen. Where
/// `field` names none and there are others, a note says what was chosen and what else there is.
void set_names(NeutralVolume& volume, const std::vector<VectorArray>& arrays, const ScalarChoice& choice,
               const std::string& field);

/// The element type of a volume, and the count of numbers for each sample.
struct SampleKind {
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
};

/// Bytes of all numbers of a volume; refuses like checked_volume_bytes.
std::uint64_t checked_array_bytes(const std::filesystem::path& path, const Index3& sample_count,
                                  const SampleKind& kind);

/// Numbers of one type in native byte order, `component_count` for each sample, interleaved.
struct Samples {
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
  Array<std::byte> values;
};

/// Sets samples and type of a volume. Magnitudes are F32, or F64 where 32 bits would round much of
/// the numbers away.
void take_scalar(NeutralVolume& volume, Samples samples, int component);

/// Puts the numbers of each sample side by side. Before, they lie in `outer` blocks, each with all
/// first numbers of `inner` samples, then all second ones, and so on.
struct PlanarShape {
  std::size_t inner = 1, outer = 1;
};
void interleave(Samples& samples, const PlanarShape& shape);

/// Keeps these numbers of each sample, in this order.
void pick(Samples& samples, std::initializer_list<int> numbers);

/// The orders in which formats store symmetric tensors, as picks that give ours.
inline constexpr std::initializer_list<int> from_upper_rows = {0, 3, 5, 1, 4, 2};  ///< xx xy xz yy yz zz
inline constexpr std::initializer_list<int> from_lower_rows = {0, 2, 5, 1, 4, 3};  ///< xx yx yy zx zy zz

/// The grid with points at these positions along x, y and z, increasing or decreasing. An axis with
/// equal steps, within the given precision, needs no table. Refuses positions that are not finite
/// or not monotonic.
/// @param relative_precision  of one position, such as 2^-23 for 32-bit floats
PointGrid rectilinear_grid(const std::filesystem::path& path, const std::array<std::vector<double>, 3>& positions,
                           double relative_precision);

/// The volume of one scalar, as choose_scalar selects it. Cell values become samples at cell
/// centres, with a note. VTK's arrays vtkGhostType are no fields: the samples of points and cells
/// that they hide become NaN, with a note.
NeutralVolume volume_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

using TakeField = NeutralVolume(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                                const std::string& field);

/// The colours in one point array of 3 or 4 8-bit components: the one that `field` names, or the
/// first.
NeutralVolume colors_of_field(const std::filesystem::path& path, const PointGrid& grid, std::vector<GridArray> arrays,
                              const std::string& field);

}  // namespace rhoray::preprocess
