#pragma once

#include <array>

namespace rhoray::preprocess {

/// Returns the sign of (p1-p0) x (p2-p0) . (p3-p0): +1, -1, or 0 exactly when the four points are
/// coplanar.
///
/// The result is exact. A determinant in double decides where its error bound allows it, expansion
/// arithmetic elsewhere (Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust
/// Geometric Predicates, 1997). Exactness is not promised where products of three coordinate digits
/// leave the range of double, that is for digits above 1e100 or below 1e-100.
int orientation(const std::array<double, 3>& p0, const std::array<double, 3>& p1, const std::array<double, 3>& p2,
                const std::array<double, 3>& p3);

}  // namespace rhoray::preprocess
