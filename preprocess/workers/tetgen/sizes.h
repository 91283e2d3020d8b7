#pragma once

#include <array>
#include <functional>
#include <optional>

#include "preprocess/tetrahedralize.h"

namespace rhoray::preprocess {

/// The wanted edge length at a point, or nothing where none is wanted.
using SizeAt = std::function<std::optional<double>(const std::array<double, 3>&)>;

/// Answers from the field, which must live as long. From a volume by trilinear interpolation, from
/// a mesh by barycentric interpolation in the tetrahedron that holds the point.
SizeAt size_at(const SizeField& field);

/// By the exact nearest point of a surface (rounded to doubles).
SizeAt size_by_distance(const SizeByDistance& distance);

}  // namespace rhoray::preprocess
