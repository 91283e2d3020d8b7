#include "render/shadow/occluder_heights.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/base/stopping.h"
#include "render/query/compiled_for.h"

namespace rhoray::render::wide {

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

/// Maximum number of squares along one side, so that all fit into a core's own cache.
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

void Squares::divide(const double (&last)[2], double edge) {
  const double longest = std::max(last[0] - first[0], last[1] - first[1]);
  const double wanted = longest / edge;
  // Rounded to single precision, which some squares are counted in.
  per_length = static_cast<double>(static_cast<float>(std::clamp(wanted, 1.0, double{most_places} - 1) / longest));
  for (int i = 0; i < 2; ++i) count[i] = static_cast<int>((last[i] - first[i]) * per_length) + 1;
}

OccluderHeights::OccluderHeights(const SeenFromLight& seen, const Frame& frame, std::span<const Footprint> footprints,
                                 const std::stop_token& stop)
    : seen_(seen), frame_(frame) {
  if (footprints.empty()) return;
  double last[2] = {-nowhere, -nowhere}, size = 0;
  squares_.first[0] = squares_.first[1] = nowhere;
  const auto for_each_footprint = [&](const auto& act) {
    for_each_until_stopped(0, footprints.size(), 1 << 14, stop, [&](std::uint64_t f) { act(footprints[f]); });
  };
  for_each_footprint([&](const Footprint& of) {
    for (int i = 0; i < 2; ++i) {
      squares_.first[i] = std::min(squares_.first[i], of.low[i] - frame.margin);
      last[i] = std::max(last[i], of.high[i] + frame.margin);
    }
    size += std::max(of.high[0] - of.low[0], of.high[1] - of.low[1]);
  });
  // About half as large as the occluders.
  squares_.divide(last, 0.5 * size / static_cast<double>(footprints.size()));
  heights_.assign(squares_.size() + 1, -nowhere);  // the last one: outside all squares
  const Squares squares = squares_;
  for_each_footprint([&](const Footprint& of) {
    int from[2], to[2];
    for (int i = 0; i < 2; ++i) {
      from[i] = static_cast<int>((of.low[i] - frame.margin - squares.first[i]) * squares.per_length);
      to[i] = static_cast<int>((of.high[i] + frame.margin - squares.first[i]) * squares.per_length);
    }
    for (int y = from[1]; y <= to[1]; ++y) {
      float* row = heights_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(squares.count[0]);
      for (int x = from[0]; x <= to[0]; ++x) row[x] = std::max(row[x], of.height);
    }
  });
}

RHORAY_INLINE void OccluderHeights::find_known(const OccluderHeights& heights, RayBatch& rays, std::size_t first,
                                               std::uint8_t* is_asked, std::uint8_t* is_in_shadow) {
  constexpr std::size_t size = RayBatch::group_size;
  const SeenFromLight seen = heights.seen_;
  const Squares& squares = heights.squares_;
  const int height_axis = seen.height_axis();
  double at[3][size];
  for (int a = 0; a < 3; ++a) {
    const int axis = a < 2 ? seen.place_axis(a) : height_axis;
    const double anchor = heights.frame_.anchor[axis], scale = heights.frame_.scale;
    const double* origin = rays.origin[axis].data() + first;
    for (std::size_t i = 0; i < size; ++i) at[a][i] = (origin[i] - anchor) * scale;
  }
  for (int a = 0; a < 2; ++a) {
    const double slope = seen.slope(a), begin = squares.first[a], per_length = squares.per_length;
    for (std::size_t i = 0; i < size; ++i) at[a][i] = (at[a][i] - slope * at[2][i] - begin) * per_length;
  }
  std::int32_t index[size];
  const std::int32_t across = squares.count[0];
  const double end_x = squares.count[0], end_y = squares.count[1];
  for (std::size_t i = 0; i < size; ++i) {
    const double x = at[0][i], y = at[1][i];
    const bool is_within = (x >= 0) & (y >= 0) & (x < end_x) & (y < end_y);
    const std::int32_t found =
        static_cast<std::int32_t>(is_within ? y : 0) * across + static_cast<std::int32_t>(is_within ? x : 0);
    index[i] = is_within ? found : across * squares.count[1];
  }
  const double sign = seen.sign(), margin = heights.frame_.margin;
  float of[size];  // gathered in a loop of its own: the loops beside it are vectorised
  const float* all = heights.heights_.data();
  for (std::size_t i = 0; i < size; ++i) of[i] = all[index[i]];
  // Written so that a NaN may be occluded.
  for (std::size_t i = 0; i < size; ++i)
    is_asked[i] = !(sign * at[2][i] > static_cast<double>(of[i]) + margin) | !(at[0][i] + at[1][i] < nowhere);
  if (!heights.shadows_.empty()) {
    float depth[size];
    const float* depths = heights.shadows_.data();
    for (std::size_t i = 0; i < size; ++i) depth[i] = depths[index[i]];
    for (std::size_t i = 0; i < size; ++i) is_in_shadow[i] = sign * at[2][i] < static_cast<double>(depth[i]) - margin;
  }
  if (heights.frame_.ends_rays) {
    const double* direction = rays.direction[height_axis].data() + first;
    double* t_max = rays.t_max.data() + first;
    for (std::size_t i = 0; i < size; ++i) {
      // Twice the margin: the rest of the ray may come out longer than needed, not shorter.
      const double t =
          (static_cast<double>(of[i]) + 2 * margin - sign * at[2][i]) / (sign * heights.frame_.scale * direction[i]);
      t_max[i] = t < t_max[i] ? t : t_max[i];
    }
  }
}

namespace {

/// Converts bytes that are 0 or 1 to bits.
std::uint64_t bits_of(const std::uint8_t* bytes) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < RayBatch::group_size; i += 8) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes + i, 8);
    bits |= (eight * 0x0102'0408'1020'4080) >> 56 << i;
  }
  return bits;
}

}  // namespace

OccluderHeights::Known OccluderHeights::know(Machine machine, RayBatch& rays, std::size_t first,
                                             std::uint64_t chosen) const {
  if (heights_.empty()) return {.asked = 0, .in_shadow = 0};
  std::uint8_t is_asked[RayBatch::group_size], is_in_shadow[RayBatch::group_size] = {};
  compiled_for<find_known>(machine)(*this, rays, first, is_asked, is_in_shadow);
  const std::uint64_t in_shadow = bits_of(is_in_shadow) & chosen;
  return {.asked = bits_of(is_asked) & chosen & ~in_shadow, .in_shadow = in_shadow};
}

}  // namespace rhoray::render::wide
