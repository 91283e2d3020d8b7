#include "render/shade/texture_lookup.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>

#include "preprocess/pack_colors.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/colors.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using render::CoveringColors;
using render::Machine;
using render::TextureLookup;

constexpr std::size_t group_size = render::RayBatch::group_size;

double decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

formats::ColorGrid packed(const TemporaryFolder& folder, const preprocess::NeutralVolume& colors,
                          const preprocess::PackColorsOptions& options = {}) {
  preprocess::pack_colors(colors, folder / "c.rho", options);
  return formats::ColorGrid(formats::PackedFile::open(folder / "c.rho"));
}

/// A group of hits at positions in the world.
struct Group {
  render::RayBatch rays{group_size};
  render::HitBatch hits{group_size};
  float shown[group_size];
  CoveringColors colors;

  explicit Group(const std::vector<Vec3>& places) {
    rays.count = group_size;
    for (std::size_t i = 0; i < group_size; ++i) {
      const Vec3 direction(1, -2, 3);
      rays.set(i, {.origin = places[i % places.size()] - 4.0 * direction, .direction = direction});
      hits.t[i] = 4;
      shown[i] = 1;
    }
  }

  int look_up(const formats::ColorGrid& grid, Machine machine = render::chosen_machine()) {
    return TextureLookup(grid, grid.description().world_from_grid.inverse(), machine)(rays, hits, 0, shown, colors);
  }
  /// As 8-bit sRGB would show it.
  double step(const float* channel, std::size_t i) const { return 255 * encoded(static_cast<double>(channel[i])); }
};

std::vector<Vec3> places_in(const Box3& box, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < group_size; ++i) places.push_back(dice.point(box.min, box.max));
  return places;
}

TEST(TextureLookup, repeats_a_ramp_of_light_in_each_channel_to_a_step_of_eight_bits) {
  const TemporaryFolder folder;
  const Affine world{{0, 0.5, 0.1}, {-0.25, 0, 0}, {0, 0.1, 2}, {1, -2, 3.5}};
  const Index3 count(23, 17, 12);
  const Vec3 slopes[3] = {{0.03, 0.01, -0.015}, {-0.02, 0.02, 0.01}, {0.01, -0.03, 0.03}};
  const double offsets[3] = {0.25, 0.5, 0.55};
  const auto light = [&](int channel, const Vec3& p) { return offsets[channel] + slopes[channel].dot(p); };
  const auto ramps = colors_of(
      count, 3,
      [&](const Index3& at) {
        std::array<std::uint8_t, 4> texel{};
        for (int c = 0; c < 3; ++c)
          texel[static_cast<std::size_t>(c)] =
              static_cast<std::uint8_t>(std::lround(255 * encoded(light(c, Vec3(at)))));
        return texel;
      },
      world);
  const formats::ColorGrid grid = packed(folder, ramps);
  const std::vector<Vec3> texels = places_in(Box3({0, 0, 0}, Vec3(count) - Vec3(1, 1, 1)), 7);
  std::vector<Vec3> places;
  for (const Vec3& p : texels) places.push_back(world.point(p));
  Group group(places);
  EXPECT_EQ(group.look_up(grid), static_cast<int>(group_size));
  for (std::size_t i = 0; i < group_size; ++i) {
    const float* channels[3] = {group.colors.red, group.colors.green, group.colors.blue};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(group.step(channels[c], i), 255 * encoded(light(c, texels[i])), 1) << c << ' ' << texels[i];
    EXPECT_EQ(group.colors.share[i], 1.0F);
  }
}

/// By the definition, in double precision: a mean of the eight texels around the point. Beyond the
/// border the last texel repeats.
std::array<double, 4> covering(const std::function<std::array<std::uint8_t, 4>(const Index3&)>& texel,
                               const Index3& count, int components, const Vec3& place) {
  std::array<double, 4> sum{};
  for (int axis = 0; axis < 3; ++axis)
    if (!(place[axis] >= -0.5 && place[axis] <= static_cast<double>(count[axis]) - 0.5)) return sum;
  for (int corner = 0; corner < 8; ++corner) {
    Index3 at;
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double before = std::floor(place[axis]);
      const bool is_behind = (corner >> axis & 1) != 0;
      weight *= is_behind ? place[axis] - before : 1 - (place[axis] - before);
      at[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>(before) + (is_behind ? 1 : 0), 0, count[axis] - 1);
    }
    const auto components_there = texel(at);
    const double share = components == 4 ? components_there[3] / 255.0 : 1;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * share * decoded(components_there[c] / 255.0);
    sum[3] += weight * share;
  }
  return sum;
}

TEST(TextureLookup, is_trilinear_in_linear_light_and_weighed_by_alpha_in_every_layout_on_every_machine) {
  const auto noise = [](const Index3& at) {
    const auto byte = [&](std::int64_t a) {
      return static_cast<std::uint8_t>((at.x * 73 + at.y * 151 + at.z * 199 + a * 37) * 41 % 256);
    };
    return std::array<std::uint8_t, 4>{byte(1), byte(2), byte(3), byte(4)};
  };
  std::vector<Machine> machines = wide_machines();
  machines.push_back(Machine::scalar);
  for (const Index3& count : {Index3(9, 14, 11), Index3(1, 1, 1), Index3(2, 1, 70)})
    for (const int components : {3, 4})
      for (const std::int64_t edge : {0, 2, 4, 5, 8, 16, 64}) {
        const TemporaryFolder folder;
        const formats::ColorGrid grid =
            packed(folder, colors_of(count, components, noise),
                   {.is_linear = edge == 0, .brick_edge = edge == 0 ? 8 : edge, .largest_superbrick = 2});
        const std::vector<Vec3> places = places_in(Box3({-0.9, -0.9, -0.9}, Vec3(count) - Vec3(0.1, 0.1, 0.1)), 3);
        Group group(places);
        const int read = group.look_up(grid, Machine::scalar);
        int inside = 0;
        for (std::size_t i = 0; i < group_size; ++i) {
          const auto expected = covering(noise, count, components, places[i]);
          EXPECT_NEAR(group.colors.red[i], expected[0], 1e-5);
          EXPECT_NEAR(group.colors.green[i], expected[1], 1e-5);
          EXPECT_NEAR(group.colors.blue[i], expected[2], 1e-5);
          EXPECT_NEAR(group.colors.share[i], expected[3], 1e-5);
          inside += grid.description().box_grid().intersects(places[i]);
        }
        EXPECT_EQ(read, inside);
        EXPECT_GT(inside, 0);
        EXPECT_LT(inside, static_cast<int>(group_size));
        for (const Machine machine : machines) {
          Group other(places);
          EXPECT_EQ(other.look_up(grid, machine), read);
          EXPECT_EQ(std::memcmp(&other.colors, &group.colors, sizeof(CoveringColors)), 0);
        }
      }
}

TEST(TextureLookup, reads_nothing_for_hits_that_are_not_shown_or_lie_elsewhere) {
  const TemporaryFolder folder;
  const formats::ColorGrid grid = packed(folder, colors_of({5, 4, 3}, 3, telling_texel));
  void* texels = const_cast<std::uint8_t*>(grid.texels().data());
  ASSERT_EQ(::mprotect(texels, grid.texels().size(), PROT_NONE), 0);  // any read there crashes here
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  Group hidden(places_in(Box3({0, 0, 0}, {4, 3, 2}), 5));
  std::fill_n(hidden.shown, group_size, 0.0F);
  EXPECT_EQ(hidden.look_up(grid), 0);
  Group elsewhere({{4.51, 1, 1}, {-0.51, 1, 1}, {1, 1e300, 1}, {1, 1, -1e18}, {nan, 1, 1}, {infinity, 1, 1}});
  EXPECT_EQ(elsewhere.look_up(grid), 0);
  for (const Group* group : {&hidden, &elsewhere})
    for (std::size_t i = 0; i < group_size; ++i) {
      EXPECT_EQ(group->colors.share[i], 0.0F);
      EXPECT_EQ(group->colors.red[i] + group->colors.green[i] + group->colors.blue[i], 0.0F);
    }
  hidden.shown[17] = 1;
  EXPECT_DEATH(hidden.look_up(grid), "") << "are texels read at all?";
}

}  // namespace
}  // namespace rhoray::tests
