#include "render/kernels/wide/blocker_heights.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "render/kernels/compiled_for.h"

namespace rhoray::render::wide {

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

/// Places along an edge of the plane, at most: then they fit a core's own cache.
constexpr int most_places = 512;

}  // namespace

SeenFromLight::SeenFromLight(const Vec3& towards) : axis_(0) {
  for (int a = 1; a < 3; ++a)
    if (std::abs(towards[a]) > std::abs(towards[axis_])) axis_ = a;
  for (int i = 0; i < 2; ++i) slope_[i] = towards[place_axis(i)] / towards[axis_];
  sign_ = towards[axis_] < 0 ? -1 : 1;
}

Footprint Footprint::of_nothing() {
  return {.low = {nowhere, nowhere}, .high = {-nowhere, -nowhere}, .height = -nowhere};
}

BlockerHeights::BlockerHeights(const SeenFromLight& seen, const Frame& frame, std::span<const Footprint> footprints)
    : seen_(seen), frame_(frame) {
  if (footprints.empty()) return;
  double last[2] = {-nowhere, -nowhere}, size = 0;
  first_[0] = first_[1] = nowhere;
  for (const Footprint& of : footprints) {
    for (int i = 0; i < 2; ++i) {
      first_[i] = std::min(first_[i], of.low[i] - frame.margin);
      last[i] = std::max(last[i], of.high[i] + frame.margin);
    }
    size += std::max(of.high[0] - of.low[0], of.high[1] - of.low[1]);
  }
  // About half as large as what stands there.
  const double longest = std::max(last[0] - first_[0], last[1] - first_[1]);
  const double wanted = 2 * longest * static_cast<double>(footprints.size()) / size;
  per_length_ = std::clamp(wanted, 1.0, double{most_places} - 1) / longest;
  for (int i = 0; i < 2; ++i) count_[i] = static_cast<int>((last[i] - first_[i]) * per_length_) + 1;
  heights_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) + 1,
                  -nowhere);  // the last: beyond all
  for (const Footprint& of : footprints) {
    int from[2], to[2];
    for (int i = 0; i < 2; ++i) {
      from[i] = static_cast<int>((of.low[i] - frame.margin - first_[i]) * per_length_);
      to[i] = static_cast<int>((of.high[i] + frame.margin - first_[i]) * per_length_);
    }
    for (int y = from[1]; y <= to[1]; ++y) {
      float* row = heights_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(count_[0]);
      for (int x = from[0]; x <= to[0]; ++x) row[x] = std::max(row[x], of.height);
    }
  }
}

RHORAY_INLINE void BlockerHeights::find_below(const BlockerHeights& heights, const RayBatch& rays, std::size_t first,
                                              std::uint8_t* is_below) {
  constexpr std::size_t size = RayBatch::group_size;
  const SeenFromLight seen = heights.seen_;
  double at[3][size];
  for (int a = 0; a < 3; ++a) {
    const int axis = a < 2 ? seen.place_axis(a) : seen.height_axis();
    const double anchor = heights.frame_.anchor[axis], scale = heights.frame_.scale;
    const double* origin = rays.origin[axis].data() + first;
    for (std::size_t i = 0; i < size; ++i) at[a][i] = (origin[i] - anchor) * scale;
  }
  for (int a = 0; a < 2; ++a) {
    const double slope = seen.slope(a), begin = heights.first_[a], per_length = heights.per_length_;
    for (std::size_t i = 0; i < size; ++i) at[a][i] = (at[a][i] - slope * at[2][i] - begin) * per_length;
  }
  std::int32_t index[size];
  const std::int32_t across = heights.count_[0];
  const double end_x = heights.count_[0], end_y = heights.count_[1];
  for (std::size_t i = 0; i < size; ++i) {
    const double x = at[0][i], y = at[1][i];
    const bool is_within = (x >= 0) & (y >= 0) & (x < end_x) & (y < end_y);
    const std::int32_t found =
        static_cast<std::int32_t>(is_within ? y : 0) * across + static_cast<std::int32_t>(is_within ? x : 0);
    index[i] = is_within ? found : across * heights.count_[1];
  }
  const float* of = heights.heights_.data();
  const double sign = seen.sign(), margin = heights.frame_.margin;
  // Written so that what is no number may be held back.
  for (std::size_t i = 0; i < size; ++i)
    is_below[i] = !(sign * at[2][i] > of[index[i]] + margin) | !(at[0][i] + at[1][i] < nowhere);
}

std::uint64_t BlockerHeights::below(Machine machine, const RayBatch& rays, std::size_t first,
                                    std::uint64_t chosen) const {
  if (heights_.empty()) return 0;
  std::uint8_t is_below[RayBatch::group_size];
  compiled_for<find_below>(machine)(*this, rays, first, is_below);
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < RayBatch::group_size; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, is_below + i, 8);
    below |= (eight * 0x0102'0408'1020'4080) >> 56 << i;
  }
  return below & chosen;
}

}  // namespace rhoray::render::wide
