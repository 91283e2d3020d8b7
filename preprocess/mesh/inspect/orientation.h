#pragma once

#include <array>

namespace rhoray::preprocess {

/// The sign of (p1-p0) x (p2-p0) . (p3-p0): +1, -1, or 0 exactly when the four points lie in one plane.
///
/// Exact: a determinant in double decides where its error bound allows, expansion arithmetic elsewhere (Shewchuk,
/// Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997). Not promised where
/// products of three coordinate digits leave the range of double, that is for digits above 1e100 or below 1e-100.
int orientation(const std::array<double, 3>& p0, const std::array<double, 3>& p1, const std::array<double, 3>& p2,
                const std::array<double, 3>& p3);

}  // namespace rhoray::preprocess
