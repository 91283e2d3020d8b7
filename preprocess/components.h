#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Arrays with several numbers for each sample, point or cell, and the scalars made from them. This
/// is the one rule for volumes and meshes of every format.
///
/// The default scalar of such an array is its magnitude, NAME.mag. The others are its components,
/// in the order of the array. Each has one name:
///
///     2 numbers, a vector            NAME.x, NAME.y
///     3 numbers, a vector            NAME.x, NAME.y, NAME.z
///     6 numbers, a symmetric tensor  NAME.xx, NAME.yy, NAME.zz, NAME.xy, NAME.yz, NAME.xz
///     9 numbers, a tensor            NAME.xx, .xy, .xz, .yx, .yy, .yz, .zx, .zy, .zz
///     any other count                NAME.0, NAME.1, ...
///
/// The six numbers have VTK's order. Importers bring symmetric tensors that a format declares, in
/// another order, to this one. The magnitude is the square root of the sum of squares. In a
/// symmetric tensor the numbers off the diagonal count twice, so it is the Frobenius norm.
///
/// An array with one number for each sample is a scalar under its own name.

/// A component counts from 0, or is the magnitude.
inline constexpr int magnitude_component = -1;

/// "flow.x" or "flow.mag"; the name alone for an array of one number.
std::string scalar_name(std::string_view array, int component_count, int component);

/// The names of all scalars of an array, the default first.
std::vector<std::string> scalars_of(std::string_view array, int component_count);

/// The same as text, for messages: "flow.mag, flow.x, flow.y", "dwi.mag, dwi.0 to dwi.63".
std::string scalars_text(std::string_view array, int component_count);

/// The component or the magnitude that `field` names in an array; nothing when it names neither.
std::optional<int> component_in(std::string_view field, std::string_view array, int component_count);

/// Names the chosen scalar of these arrays and the alternatives: "using the magnitude of 3
/// components, 'flow.mag'; choose another with --field: flow.x, flow.y, flow.z, pressure". Empty
/// when there is nothing else.
std::string note_of_choice(const std::vector<VectorArray>& arrays, std::size_t array, int component);

/// The magnitude of one sample. NaN where a component is NaN or infinite. Components whose squares
/// leave the range of double are scaled first.
double magnitude_of(std::span<const double> components);

}  // namespace rhoray::preprocess
