#pragma once

#include <filesystem>
#include <string>

#include "formats/base/interval.h"
#include "preprocess/neutral.h"

namespace rhoray::study {

/// A field of a packed grid as plain samples, x fastest, that own their memory. The axes are those
/// of the world, with the grid's spacing and the first sample at the origin, so that every system
/// can show it. Refuses files of another kind, sparse grids and grids whose spacing varies
/// (ErrorCode::usage).
/// @param field  name; empty takes the first
preprocess::NeutralVolume plain_grid(const std::filesystem::path& packed_file, const std::string& field);

/// Length of a step along each axis of a plain grid.
Vec3 spacing_of(const preprocess::NeutralVolume& grid);

/// The same field in another type. For an integer type, the range is spread over the type's range
/// from 0 up; floats keep the values.
preprocess::NeutralVolume converted(const preprocess::NeutralVolume& grid, formats::ElementType type,
                                    const Interval<double>& range);

/// The isovalue in a converted field.
double converted_isovalue(double isovalue, formats::ElementType type, const Interval<double>& range);

}  // namespace rhoray::study
