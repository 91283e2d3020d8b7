#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

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

/// Names the volume of the chosen array, and the others with so many axes. A note tells of these
/// when `field` is empty.
void set_names(NeutralVolume& volume, const std::vector<NamedShape>& arrays, std::size_t chosen,
               const std::string& field, std::size_t axis_count);

/// Refuses an array that has not so many axes (ErrorCode::unsupported).
/// @param expected  "3 axes: z, y, x"
void check_axes(const std::filesystem::path& path, const NamedShape& array, std::size_t axis_count,
                std::string_view expected);

}  // namespace rhoray::preprocess
