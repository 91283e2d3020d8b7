// V16. More than 2^32 samples. Sample and cell numbers in 32 bits would start again at 0, and data
// of the far corner would be looked up in the near one. The grid is sparse, so it fits a test.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "formats/brick_grid.h"
#include "render/ray_caster.h"
#include "tests/render/support/rays.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr std::int64_t brick_edge = 64;
const Index3 sample_count(4096, 2048, 1024);  // 2^33
const std::vector<Index3> stored{{0, 0, 0}, {31, 15, 7}, {63, 31, 15}};
const Vec3 slope(1, 2, 3);

float value_at(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<float>(i + 2 * j + 3 * k);  // whole numbers below 2^24
}

/// Level 1 of the ranges: those of the macrocells in which a stored brick has cells.
std::vector<float> first_level(const formats::MacroShape& shape) {
  const Index3 count = shape.count(1);
  std::vector<Interval<float>> ranges(static_cast<std::size_t>(volume(count)));
  const std::int64_t cells = brick_edge - 1, per_brick = brick_edge / shape.factor;
  for (const Index3& brick : stored)
    for (std::int64_t m = 0; m < per_brick * per_brick * per_brick; ++m) {
      const Index3 in_brick(m % per_brick, m / per_brick % per_brick, m / per_brick / per_brick);
      const Index3 at = brick * per_brick + in_brick;
      Index3 low, high;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = at[axis] * shape.factor;
        high[axis] = brick[axis] * brick_edge + std::min((in_brick[axis] + 1) * shape.factor, cells);
      }
      Interval<float>& range = ranges[static_cast<std::size_t>((at.z * count.y + at.y) * count.x + at.x)];
      range.include(value_at(low.x, low.y, low.z));
      range.include(value_at(high.x, high.y, high.z));
    }
  std::vector<float> flat;
  for (const Interval<float>& range : ranges) flat.insert(flat.end(), {range.lo, range.hi});
  return flat;
}

std::string packed_file() {
  formats::GridDescription d;
  d.layout = formats::BrickLayout::sparse(sample_count, stored.size(), brick_edge);
  d.length_unit = "mm";
  d.macro = {sample_count - Index3(1, 1, 1), 32, 2};
  const Index3 bricks = d.layout.brick_count();
  std::vector<std::uint32_t> slots(static_cast<std::size_t>(volume(bricks)), formats::BrickGrid::no_brick);
  std::vector<float> samples;
  for (std::size_t slot = 0; slot < stored.size(); ++slot) {
    const Index3& brick = stored[slot];
    slots[static_cast<std::size_t>((brick.z * bricks.y + brick.y) * bricks.x + brick.x)] =
        static_cast<std::uint32_t>(slot);
    for (std::int64_t k = 0; k < brick_edge; ++k)
      for (std::int64_t j = 0; j < brick_edge; ++j)
        for (std::int64_t i = 0; i < brick_edge; ++i)
          samples.push_back(value_at(brick.x * brick_edge + i, brick.y * brick_edge + j, brick.z * brick_edge + k));
  }
  d.fields = {summarize("sum", std::span<const float>(samples))};
  d.fields[0].no_data_count = static_cast<std::uint64_t>(volume(sample_count)) - samples.size();
  const std::vector<std::vector<float>> levels = levels_above(d.macro, 1, first_level(d.macro));

  const MemoryFile memory;
  formats::PackedFileWriter writer(memory.descriptor(), formats::describe(d), formats::grid_arrays(d));
  for (std::size_t level = 0; level < levels.size(); ++level)
    writer.write_all(concat(formats::macro_prefix(0), level + 1), std::span<const float>(levels[level]));
  writer.write_all(formats::samples_array(0), std::span<const float>(samples));
  writer.write_all("bricks", std::span<const std::uint32_t>(slots));
  writer.commit();
  return memory.content();
}

TEST(MoreThan32Bits, of_samples_are_told_apart) {
  ASSERT_GT(volume(sample_count), std::int64_t{1} << 32);
  const TemporaryFolder folder;
  write_file(folder / "sum.rho", packed_file());
  const render::Dataset dataset = render::Dataset::load(folder / "sum.rho");
  int beyond = 0;
  for (const Index3& brick : stored) {
    const Vec3 low(static_cast<double>(brick.x * brick_edge), static_cast<double>(brick.y * brick_edge),
                   static_cast<double>(brick.z * brick_edge));
    const Vec3 high = low + Vec3(brick_edge - 1);
    const double isovalue = slope.dot((low + high) / 2.0);
    for (const render::Method::Algorithm algorithm :
         {render::Method::Algorithm::direct, render::Method::Algorithm::certified, render::Method::Algorithm::exact}) {
      render::RayCaster queries(dataset, isovalue, {.algorithm = algorithm});
      Dice dice(1);
      for (int trial = 0; trial < 100; ++trial) {
        // Upwards through a point of the plane in the brick, starting outside the brick's lower
        // corner.
        const Vec3 target = dice.point(low + Vec3(20), high - Vec3(20));
        const Vec3 direction = dice.point(Vec3(0.5), Vec3(1));
        const render::Ray ray{.origin = target - 1e4 * direction, .direction = direction};
        const double t = (isovalue - slope.dot(ray.origin)) / slope.dot(direction);
        const Vec3 p = ray.at(t);
        bool is_inside = true;
        for (int axis = 0; axis < 3; ++axis) is_inside = is_inside && p[axis] > low[axis] && p[axis] < high[axis];
        if (!is_inside) continue;
        const render::Hit hit = queries.first_crossing(ray);
        ASSERT_NEAR(hit.t, t, 1e-6 + (std::isnan(hit.error) ? 0 : hit.error)) << brick << ", " << trial;
        const Index3 cells = sample_count - Index3(1, 1, 1);
        const auto cell = [&](int axis) { return static_cast<std::int64_t>(std::floor(p[axis])); };
        bool is_on_a_face = false;
        for (int axis = 0; axis < 3; ++axis) is_on_a_face |= std::abs(p[axis] - std::round(p[axis])) < 1e-5;
        if (is_on_a_face) continue;
        const std::int64_t id = (cell(2) * cells.y + cell(1)) * cells.x + cell(0);
        EXPECT_EQ(hit.cell, static_cast<std::uint64_t>(id));
        beyond += id > std::int64_t{0xffffffff};
      }
    }
  }
  EXPECT_GT(beyond, 200) << "no cell's number needs more than 32 bits: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests
