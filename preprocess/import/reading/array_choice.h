#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// An array of a file that may hold several, of any shape.
struct NamedShape {
  std::string name;
  std::vector<std::int64_t> shape;
};

/// "5 x 4 x 3"
std::string shape_text(const std::vector<std::int64_t>& shape);

/// The array that `field` names, or without a name the first with so many axes. Refuses a file
/// without such an array, and names those it has.
std::size_t choose_array(const std::filesystem::path& path, const std::vector<NamedShape>& arrays,
                         const std::string& field, std::size_t axis_count);

/// Numbers for each sample of an array with three axes (one), or with a fourth for the components
/// of vectors and tensors (2 to 9); nothing for other arrays, such as time steps.
/// @param sizes  the last is the fourth axis
std::optional<int> component_count_of(const std::vector<std::int64_t>& sizes);

/// A scalar among the arrays of a file, of any shape.
struct VolumeChoice {
  std::size_t array = 0;             ///< of all arrays
  std::vector<VectorArray> volumes;  ///< the arrays that component_count_of accepts
  ScalarChoice scalar;               ///< of these
};

/// The scalar that `field` names, or the default (grid_arrays.h). Refuses a file without such an
/// array, and names those it has.
VolumeChoice choose_volume(const std::filesystem::path& path, const std::vector<NamedShape>& arrays,
                           const std::string& field, std::string_view expected);

/// Refuses an array that has not so many axes (ErrorCode::unsupported).
/// @param expected  "3 axes: z, y, x"
void check_axes(const std::filesystem::path& path, const NamedShape& array, std::size_t axis_count,
                std::string_view expected);

}  // namespace rhoray::preprocess
