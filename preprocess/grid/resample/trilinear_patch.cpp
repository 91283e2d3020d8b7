#include "preprocess/grid/resample/trilinear_patch.h"

#include <algorithm>
#include <cmath>

#include "preprocess/grid/resample/points.h"

namespace rhoray::preprocess {

ClippedTriangle::ClippedTriangle(const std::array<PatchPoint, 3>& triangle) {
  std::copy(triangle.begin(), triangle.end(), corners_.begin());
  for (std::size_t axis = 0; axis < 3 && size_ > 0; ++axis) {
    double low = corners_[0].at[axis], high = low;
    for (std::size_t i = 1; i < size_; ++i) {
      low = smaller(low, corners_[i].at[axis]);
      high = larger(high, corners_[i].at[axis]);
    }
    if (high < 0 || low > 1) {
      size_ = 0;
      return;
    }
    if (low < 0) clip(axis, 1, 0);
    if (high > 1) clip(axis, -1, 1);
  }
}

/// Keeps the part with sign * (coordinate - place) >= 0. A corner that is cut off is replaced by
/// points exactly on the side.
void ClippedTriangle::clip(std::size_t axis, double sign, double place) {
  std::array<PatchPoint, capacity> kept;
  std::size_t count = 0;
  const PatchPoint* a = &corners_[size_ - 1];
  double from = sign * (a->at[axis] - place);
  for (std::size_t i = 0; i < size_; ++i) {
    const PatchPoint* b = &corners_[i];
    const double to = sign * (b->at[axis] - place);
    if ((from >= 0) != (to >= 0)) {
      const double t = from / (from - to);
      PatchPoint& cut = kept[count++];
      for (std::size_t c = 0; c < 3; ++c) cut.at[c] = a->at[c] + t * (b->at[c] - a->at[c]);
      cut.at[axis] = place;
      cut.value = a->value + t * (b->value - a->value);
    }
    if (to >= 0) kept[count++] = *b;
    a = b;
    from = to;
  }
  std::copy_n(kept.begin(), count, corners_.begin());
  size_ = count;
}

PatchBounds patch_bounds(const std::array<PatchPoint, 3>& t, const std::array<double, 8>& corners) {
  // mixed[a][b][c] = T(x of corner a, y of corner b, z of corner c)
  std::array<std::array<std::array<double, 3>, 3>, 3> mixed;
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = t[a].at[0];
    std::array<double, 4> on_x;
    for (std::size_t e = 0; e < 4; ++e) on_x[e] = corners[2 * e] + x * (corners[2 * e + 1] - corners[2 * e]);
    for (std::size_t b = 0; b < 3; ++b) {
      const double y = t[b].at[1];
      const double low = on_x[0] + y * (on_x[1] - on_x[0]), high = on_x[2] + y * (on_x[3] - on_x[2]);
      for (std::size_t c = 0; c < 3; ++c) mixed[a][b][c] = low + t[c].at[2] * (high - low);
    }
  }
  PatchBounds bounds{0, -1, {}};
  for (std::size_t v = 0; v < 3; ++v) {
    const double here = std::abs(mixed[v][v][v] - t[v].value);
    if (here > bounds.attained) {
      bounds.attained = here;
      bounds.at = t[v].at;
    }
  }
  bounds.upper = bounds.attained;
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t w = 0; w < 3; ++w) {
      if (v == w) continue;
      const double polar = (mixed[w][v][v] + mixed[v][w][v] + mixed[v][v][w]) / 3;
      bounds.upper = std::max(bounds.upper, std::abs(polar - (2 * t[v].value + t[w].value) / 3));
    }
  const double middle =
      (mixed[0][1][2] + mixed[0][2][1] + mixed[1][0][2] + mixed[1][2][0] + mixed[2][0][1] + mixed[2][1][0]) / 6;
  bounds.upper = std::max(bounds.upper, std::abs(middle - (t[0].value + t[1].value + t[2].value) / 3));
  return bounds;
}

}  // namespace rhoray::preprocess
