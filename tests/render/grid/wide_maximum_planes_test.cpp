#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/render/support/maximum_agreement.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Ray;

/// A square of pixels seen from an eye.
std::vector<Ray> picture(const Vec3& eye, const Vec3& forward, double pixel, double distance, int edge) {
  const Vec3 u = forward.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = forward.cross(u);
  std::vector<Ray> rays;
  for (int square = 0; square < edge * edge / 64; ++square)
    for (int i = 0; i < 64; ++i) {
      const double column = 8 * (square % (edge / 8)) + i % 8 - 0.5 * (edge - 1),
                   row = 8 * (square / (edge / 8)) + i / 8 - 0.5 * (edge - 1);
      const Vec3 target = eye + distance * forward + pixel * (column * u + row * v);
      rays.push_back({.origin = eye, .direction = (target - eye).normalized()});
    }
  return rays;
}

/// Range of distances of the eye and of pixel sizes at the middle; directions are rotated from an
/// axis by the given amounts.
struct Pictures {
  Index3 count;
  double nearest, furthest;
  double smallest, largest;
  std::array<double, 3> turns;
};

/// Compares pictures along each axis and diagonally, of samples of 16 and of 8 bits.
int agreement_in(const Pictures& pictures, const Samples& samples, std::uint64_t seed) {
  const Index3& count = pictures.count;
  const Vec3 size(static_cast<double>(count.x - 1), static_cast<double>(count.y - 1), static_cast<double>(count.z - 1));
  Dice dice(seed);
  std::vector<Ray> rays;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (const double turn : pictures.turns) {
        Vec3 forward = turn * dice.direction();
        forward[axis] += side;
        const Vec3 ahead = forward.normalized();
        const double distance = dice.between(pictures.nearest, pictures.furthest);
        const double pixel = dice.between(pictures.smallest, pictures.largest);
        const std::vector<Ray> one = picture(0.5 * size - distance * ahead, ahead, pixel, distance, 32);
        rays.insert(rays.end(), one.begin(), one.end());
      }
  const TracedDataset words(
      volume_of<std::uint16_t>(count, [&](const Index3& at) { return static_cast<std::uint16_t>(samples(at)); }));
  const TracedDataset bytes(volume_of<std::int8_t>(
      count, [&](const Index3& at) { return static_cast<std::int8_t>(samples(at) / 256 - 128); }));
  return expect_agreement(words, rays) + expect_agreement(bytes, rays);
}

/// Samples use one bit or all sixteen: the rounding of 16-bit words differs by 2^15. Rays far from
/// an axis leave the sweep from plane to plane and continue with the blocks.
TEST(WideMaximum, is_the_scalar_kernels_answer_from_plane_to_plane_whatever_the_range_of_samples) {
  const std::vector<Samples> kinds{
      over_all_of<std::uint16_t>(),
      noise(65536, 0),
      noise(2, 40000),
      noise(17, 30000),
      [](const Index3& at) { return 300.0 * static_cast<double>(at.x + 2 * at.y + at.z % 9); },
      [](const Index3& at) { return 30000 + 9000 * waves(at); },
      [](const Index3& at) { return at.z % 7 == 3 && at.x % 5 == 2 ? 60000.0 : noise(40, 20)(at); },
      [](const Index3& at) { return std::min(50000.0, 9000.0 * static_cast<double>(at.x % 11)); }};
  int hits = 0;
  std::uint64_t seed = 950;
  for (const Samples& samples : kinds)
    hits += agreement_in({{52, 43, 61}, 4, 120, 0.1, 1.3, {0, 0.15, 0.5}}, samples, ++seed);
  EXPECT_GT(hits, 100000);
}

/// Pixels one to ten cells apart, as in small pictures and where slices are thin: windows around
/// the rays are wide. Rays that are even farther apart continue with the blocks.
TEST(WideMaximum, is_the_scalar_kernels_answer_where_rays_lie_apart) {
  const std::vector<Samples> kinds{
      noise(65536, 0), noise(17, 30000), [](const Index3& at) { return 30000 + 9000 * waves(at) + noise(300, 0)(at); },
      [](const Index3& at) { return 2000 + 500 * waves(at) + (at.z % 23 == 3 && at.x % 19 == 2 ? 60000.0 : 0); },
      [](const Index3& at) { return std::min(60000.0, 300.0 * static_cast<double>(at.x + at.y % 40 + at.z)); }};
  int hits = 0;
  std::uint64_t seed = 1950;
  for (const Samples& samples : kinds)
    hits += agreement_in({{130, 75, 150}, 60, 600, 1, 10, {0, 0.3, 0.6}}, samples, ++seed);
  EXPECT_GT(hits, 40000);
}

/// Squares of parallel rays close to an axis, through samples or just beside them.
std::vector<Ray> rays_through_samples(const Index3& count, std::size_t squares, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  for (std::size_t square = 0; square < squares; ++square) {
    const int major = static_cast<int>(dice.below(3)), u = (major + 1) % 3, v = (major + 2) % 3;
    const auto either = [&](double x) { return dice.coin() ? x : -x; };
    Vec3 direction, target;
    for (int a = 0; a < 3; ++a) {
      const double slope = dice.coin() ? dice.between(0, 0.95) : std::pow(10.0, -dice.between(0, 9));
      direction[a] = either(a == major ? 1 : slope);
      target[a] = static_cast<double>(dice.below(static_cast<std::uint64_t>(count[a])));
      if (dice.coin()) target[a] += either(std::pow(10.0, -dice.between(4, 14)));
    }
    const double back = dice.between(0, 100);
    for (int i = 0; i < 64; ++i) {
      Vec3 origin = target - back * direction;
      origin[u] += i % 8, origin[v] += i / 8;
      rays.push_back({.origin = origin, .direction = direction});
    }
  }
  return rays;
}

/// There rays go from cell to cell where they pass a plane of samples, and rounding makes the value
/// different in each cell.
TEST(WideMaximum, is_the_scalar_kernels_answer_where_the_largest_is_a_sample) {
  const Index3 count(61, 52, 74);
  const std::vector<Samples> kinds{noise(65536, 0),
                                   [](const Index3& at) { return at.z % 6 == 0 ? 50000 + noise(9000, 0)(at) : 100; },
                                   [](const Index3& at) { return noise(9, 0)(at) == 8 ? noise(60000, 0)(at) : 7; }};
  int hits = 0;
  std::uint64_t seed = 730;
  for (const Samples& samples : kinds) {
    const TracedDataset traced(
        volume_of<std::uint16_t>(count, [&](const Index3& at) { return static_cast<std::uint16_t>(samples(at)); }));
    hits += expect_agreement(traced, rays_through_samples(count, 800, ++seed));
  }
  EXPECT_GT(hits, 80000);
}

}  // namespace
}  // namespace rhoray::tests
