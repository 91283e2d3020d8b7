#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <variant>
#include <vector>

#include "render/grid/largest/maximum.h"
#include "render/method.h"
#include "render/query/intersectors.h"
#include "tests/render/support/allocation_count.h"
#include "tests/render/support/bundles.h"
#include "tests/render/support/grid_judge.h"
#include "tests/render/support/maximum_agreement.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<Ray> rays_through(const Vec3& size, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays = bundles(size, count, seed);
  const std::vector<Ray> single = stressful_rays(size, count, seed);
  rays.insert(rays.end(), single.begin(), single.end());
  return rays;
}

template <class T>
int agreement_of(const Samples& samples, std::uint64_t seed) {
  using Limits = std::numeric_limits<T>;
  const TracedDataset traced(volume_of<T>({37, 22, 70}, [&](const Index3& at) {
    return static_cast<T>(std::clamp<double>(samples(at), Limits::lowest(), Limits::max()));
  }));
  return expect_agreement(traced, rays_through({36, 21, 69}, 2000, seed));
}

TEST(WideMaximum, is_the_scalar_kernels_answer_bit_for_bit_for_every_type_of_samples) {
  int hits = 0;
  hits += agreement_of<std::uint8_t>([](const Index3& at) { return 120 + 60 * waves(at); }, 1);
  hits += agreement_of<std::int8_t>([](const Index3& at) { return 60 * waves(at); }, 2);
  hits += agreement_of<std::uint16_t>([](const Index3& at) { return 30000 + 9000 * waves(at); }, 3);
  hits += agreement_of<std::int16_t>([](const Index3& at) { return 9000 * waves(at) - 1000; }, 4);
  hits += agreement_of<std::uint32_t>([](const Index3& at) { return 4e9 + 100 * waves(at); }, 5);
  hits += agreement_of<std::int32_t>([](const Index3& at) { return -2e9 + 1e7 * waves(at); }, 6);
  hits += agreement_of<float>(waves, 7);
  hits += agreement_of<double>(waves, 8);
  EXPECT_GT(hits, 8000);
}

// Waves in a ball and a few more beside it; what is not stored has no data.
TEST(WideMaximum, is_the_scalar_kernels_answer_where_only_some_bricks_are_stored) {
  int hits = 0;
  const auto agreement_in_bricks_of = [&]<class T>(T, std::int64_t edge, std::uint64_t seed) {
    const auto sample = [](const Index3& at) {
      const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
      const bool is_known = (p - Vec3(14, 11, 30)).length() < 11 || (at.z > 60 && at.x > 20);
      return static_cast<T>(is_known ? waves(at) : nan);
    };
    const TracedDataset traced(volume_of<T>({37, 22, 70}, sample),
                               {.order = preprocess::SampleOrder::sparse, .brick_edge = edge});
    const auto& grid = std::get<render::UniformGrid>(traced.dataset().implementation().view);
    EXPECT_EQ(grid.source()->type, formats::element_type_of<T>());
    EXPECT_LT(2 * grid.source()->bricks.stored_count, grid.packed()->brick_slots().size());
    hits += expect_agreement(traced, rays_through({36, 21, 69}, 2000, seed));
  };
  agreement_in_bricks_of(float(), 8, 311);
  agreement_in_bricks_of(float(), 4, 312);
  agreement_in_bricks_of(double(), 4, 313);
  EXPECT_GT(hits, 3000);
}

TEST(WideMaximum, is_the_scalar_kernels_answer_where_samples_span_their_whole_type) {
  int hits = 0;
  hits += agreement_of<std::uint8_t>(over_all_of<std::uint8_t>(), 301);
  hits += agreement_of<std::int8_t>(over_all_of<std::int8_t>(), 302);
  hits += agreement_of<std::uint16_t>(over_all_of<std::uint16_t>(), 303);
  hits += agreement_of<std::int16_t>(over_all_of<std::int16_t>(), 304);
  EXPECT_GT(hits, 4000);
}

// Groups of 8 x 8 rays from one eye; only few of them pass the blocks with high values.
TEST(WideMaximum, is_the_scalar_kernels_answer_from_eyes_near_and_far) {
  const Vec3 size(36, 21, 69), middle = 0.5 * size;
  const TracedDataset traced(volume_of<std::uint16_t>(
      {37, 22, 70}, [](const Index3& at) { return static_cast<std::uint16_t>(over_all_of<std::uint16_t>()(at)); }));
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  std::vector<Ray> rays;
  for (const double distance : {1.0, 1e2, 1e4, 1e7, 1e12, 1e30, 1e150}) {
    for (int group = 0; group < 16; ++group) {
      const Vec3 forward = Vec3(anywhere(random), anywhere(random), anywhere(random)).normalized();
      const Vec3 eye = middle - distance * forward;
      for (int pixel = 0; pixel < 64; ++pixel) {
        const Vec3 target = middle + Vec3(1.1 * (pixel % 8) - 4, 0.9 * (pixel / 8) - 3, 0.8 * (pixel % 8) - 3);
        rays.push_back({.origin = eye, .direction = (target - eye).normalized()});
      }
    }
  }
  EXPECT_GT(expect_agreement(traced, rays), 3000);
}

TEST(WideMaximum, is_the_scalar_kernels_answer_in_noise_plateaus_and_constants) {
  const std::vector<Samples> kinds{
      noise(100000, -50000),
      noise(17, 2),
      noise(3, 0),
      noise(100, -200),
      [](const Index3&) { return 0.1; },
      [](const Index3&) { return 0.0; },
      [](const Index3& at) { return std::min(0.7, 0.01 * static_cast<double>(at.x * at.y)); },
      [](const Index3& at) { return at.x == 5 || at.x == 17 ? 0.3 : 0.1; },
      [](const Index3& at) { return at.y >= 9 && at.y <= 14 ? 200.0 : noise(200, 0)(at); },
      [](const Index3& at) { return noise(11, 0)(at) == 3 ? -1e9 : noise(50, -3)(at); }};
  int hits = 0;
  std::uint64_t seed = 20;
  for (const Samples& samples : kinds) {
    hits += agreement_of<double>(samples, ++seed);
    hits += agreement_of<float>(samples, ++seed);
    hits += agreement_of<std::int16_t>(samples, ++seed);
  }
  EXPECT_GT(hits, 30000);
}

/// Squares of 8 x 8 rays that run along an axis, slightly or clearly inclined towards the others,
/// so that they reach planes at all angles. A third begin or end somewhere inside, some of them in
/// a plane.
std::vector<Ray> rays_across_planes(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const int major = static_cast<int>(dice.below(3));
    Vec3 direction;
    for (int a = 0; a < 3; ++a)
      direction[a] = (dice.coin() ? 1 : -1) * (a == major ? 1 : std::pow(10.0, -dice.between(0, 8)));
    const Vec3 target = dice.point({0, 0, 0}, size);
    const double spread = std::pow(10.0, -dice.between(0, 7));
    for (int i = 0; i < 64; ++i) {
      Ray ray{.origin = target + spread * dice.point({-1, -1, -1}, {1, 1, 1}), .direction = direction};
      for (int a = 0; a < 3; ++a)
        if (a != major) ray.direction[a] *= 1 + 0.1 * dice.between(-1, 1);
      if (dice.below(8) == 0) ray.origin[static_cast<int>(dice.below(3))] = std::round(target.x);
      const bool is_cut = dice.below(3) == 0, ends = dice.coin();
      ray.t_min = is_cut && !ends ? dice.between(-0.2, 0.2) : -1000;
      ray.t_max = is_cut && ends ? dice.between(0, 5) : 1000;
      rays.push_back(ray);
    }
  }
  return rays;
}

/// Where samples of a plane are high, the largest value of a ray is on the plane, at the end of two
/// cells. One of them is refined, and must be the one that the scalar kernel chooses, whichever
/// block, slab or vector it is in.
TEST(WideMaximum, is_the_scalar_kernels_answer_where_the_largest_lies_between_two_cells) {
  const auto on_planes = [](std::int64_t apart, std::int64_t height, std::int64_t kinds) -> Samples {
    return [=](const Index3& at) {
      const bool is_on_plane = at.x % apart == 1 || at.y % apart == 2 || at.z % apart == 0;
      return noise(kinds, 0)(at) + (is_on_plane ? static_cast<double>(height) : 0);
    };
  };
  int hits = 0;
  std::uint64_t seed = 40;
  for (const Samples& samples :
       {on_planes(4, 60, 60), on_planes(3, 100, 9), on_planes(9, 30, 90), on_planes(16, 80, 2)})
    for (const Index3& count : {Index3(40, 37, 66), Index3(300, 21, 18)}) {
      const auto agreement_in = [&](const TracedDataset& traced) {
        const Vec3 size(static_cast<double>(count.x - 1), static_cast<double>(count.y - 1),
                        static_cast<double>(count.z - 1));
        return expect_agreement(traced, rays_across_planes(size, 3000, ++seed));
      };
      hits += agreement_in(TracedDataset(
          volume_of<std::uint8_t>(count, [&](const Index3& at) { return static_cast<std::uint8_t>(samples(at)); })));
      hits += agreement_in(TracedDataset(
          volume_of<float>(count, [&](const Index3& at) { return static_cast<float>(0.1 * samples(at)); })));
    }
  EXPECT_GT(hits, 30000);
}

TEST(WideMaximum, leaves_cells_without_data_out_as_the_scalar_kernel_does) {
  const std::vector<Samples> kinds{[](const Index3& at) { return noise(9, 0)(at) == 0 ? nan : noise(50, -3)(at); },
                                   [](const Index3& at) { return at.x == 7 && at.y < 12 ? nan : waves(at); },
                                   [](const Index3& at) { return noise(40, 0)(at) == 1 ? HUGE_VAL : waves(at); },
                                   [](const Index3& at) { return noise(40, 0)(at) == 1 ? -HUGE_VAL : waves(at); },
                                   [](const Index3&) { return nan; }};
  int hits = 0;
  std::uint64_t seed = 60;
  for (const Samples& samples : kinds) {
    hits += agreement_of<double>(samples, ++seed);
    hits += agreement_of<float>(samples, ++seed);
  }
  EXPECT_GT(hits, 8000);
}

TEST(WideMaximum, keeps_small_differences_of_large_values_and_values_of_any_magnitude) {
  const std::vector<Samples> kinds{
      [](const Index3& at) { return 1e9 + waves(at); }, [](const Index3& at) { return 1e-300 * waves(at); },
      [](const Index3& at) { return 1e300 * waves(at); }, [](const Index3& at) { return 1e-312 * noise(100, 0)(at); },
      [](const Index3& at) { return at == Index3(9, 9, 9) ? 1e200 : waves(at); }};
  int hits = 0;
  std::uint64_t seed = 80;
  for (const Samples& samples : kinds) hits += agreement_of<double>(samples, ++seed);
  const std::vector<Samples> of_float{[](const Index3& at) { return 1e-42 * noise(100, 0)(at); },
                                      [](const Index3& at) { return 1e38 * waves(at); },
                                      [](const Index3& at) { return 1e7 + waves(at); }};
  for (const Samples& samples : of_float) hits += agreement_of<float>(samples, ++seed);
  EXPECT_GT(hits, 8000);
}

TEST(WideMaximum, takes_lattices_of_every_small_size) {
  std::uint64_t seed = 100;
  for (const Index3& count : {Index3(2, 2, 2), Index3(2, 3, 5), Index3(5, 5, 5), Index3(6, 4, 130), Index3(65, 2, 9)}) {
    const TracedDataset traced(volume_of<std::uint16_t>(
        count, [](const Index3& at) { return static_cast<std::uint16_t>(noise(1000, 0)(at)); }));
    const Vec3 size(static_cast<double>(count.x - 1), static_cast<double>(count.y - 1),
                    static_cast<double>(count.z - 1));
    EXPECT_GT(expect_agreement(traced, rays_through(size, 1000, ++seed)), 500);
  }
}

/// Squares of 4 x 4 samples end where the lattice does, so its last blocks have no square beside
/// them; or they end a sample earlier or later. The largest values are at the ends.
TEST(WideMaximum, reads_the_last_blocks_of_lattices_that_end_with_a_square) {
  const auto at_ends = [](const Index3& at) {
    return 9000 * waves(at) + 400.0 * static_cast<double>(at.x + at.y + at.z % 17) - 20000;
  };
  int hits = 0;
  std::uint64_t seed = 400;
  for (const Index3& count : {Index3(36, 24, 68), Index3(36, 25, 67), Index3(35, 24, 66), Index3(34, 28, 65)}) {
    const Vec3 size(static_cast<double>(count.x - 1), static_cast<double>(count.y - 1),
                    static_cast<double>(count.z - 1));
    const std::vector<Ray> rays = rays_through(size, 1500, ++seed);
    hits += expect_agreement(TracedDataset(volume_of<std::int16_t>(
                                 count, [&](const Index3& at) { return static_cast<std::int16_t>(at_ends(at)); })),
                             rays);
    hits += expect_agreement(
        TracedDataset(volume_of<std::uint8_t>(
            count, [&](const Index3& at) { return static_cast<std::uint8_t>(at_ends(at) / 300 + 120); })),
        rays);
  }
  EXPECT_GT(hits, 8000);
}

TEST(WideMaximum, reads_every_layout) {
  std::uint64_t seed = 200;
  const auto values = [](const Index3& at) { return static_cast<std::uint16_t>(noise(1000, 0)(at)); };
  std::vector<preprocess::PackVolumeOptions> layouts{{.order = preprocess::SampleOrder::linear}};
  for (const std::int64_t brick_edge : {2, 3, 4, 6, 8}) layouts.push_back({.brick_edge = brick_edge});
  for (const preprocess::PackVolumeOptions& layout : layouts) {
    const TracedDataset traced(volume_of<std::uint16_t>({37, 22, 41}, values), layout);
    EXPECT_GT(expect_agreement(traced, rays_through({36, 21, 40}, 500, ++seed)), 400);
  }
}

// One level of macrocells: there are no nodes to read. This kernel does not support other factors.
TEST(WideMaximum, is_chosen_where_levels_have_factor_4_and_the_way_is_direct) {
  const auto volume = [] {
    return volume_of<float>({30, 25, 37}, [](const Index3& at) { return static_cast<float>(waves(at)); });
  };
  const TracedDataset one_level(volume(), {.macro_level_count = 1});
  EXPECT_GT(expect_agreement(one_level, rays_through({29, 24, 36}, 1000, 7)), 800);
  const TracedDataset other_factor(volume(), {.macro_factor = 3, .macro_level_count = 2});
  const auto kernel = [](const TracedDataset& traced, const Method& method, Machine machine) {
    return render::wide::largest_value_kernel(traced.dataset().implementation(), method, machine);
  };
  EXPECT_EQ(kernel(other_factor, Method{}, Machine::baseline), nullptr);
  EXPECT_EQ(kernel(one_level, {.algorithm = Method::Algorithm::paper}, Machine::baseline), nullptr);
  EXPECT_EQ(kernel(one_level, {.algorithm = Method::Algorithm::certified}, Machine::baseline), nullptr);
  EXPECT_EQ(kernel(one_level, Method{}, Machine::scalar), nullptr);
}

/// Squares of 8 x 8 pixels of one eye, as a picture's tiles request them. There are so many that
/// four and more are searched together, until their frustum is too wide; with pixels that miss and
/// with squares that are cut off.
TEST(WideMaximum, is_the_scalar_kernels_answer_for_squares_of_pixels_searched_together) {
  const TracedDataset traced(volume_of<std::int16_t>(
      {60, 52, 68}, [](const Index3& at) { return static_cast<std::int16_t>(9000 * waves(at) + noise(1000, 0)(at)); }));
  const Vec3 middle(29.5, 25.5, 33.5);
  int hits = 0;
  std::uint64_t seed = 900;
  for (const double pixel : {0.05, 0.3, 1.0, 4.0, 15.0}) {
    Dice dice(++seed);
    std::vector<Ray> rays;
    for (int picture = 0; picture < 3; ++picture) {
      const Vec3 forward = dice.direction(), u = forward.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = forward.cross(u);
      const Vec3 eye = middle - dice.between(40, 300) * forward;
      for (int square = 0; square < 16; ++square)
        for (int y = 0; y < 8; ++y)
          for (int x = 0; x < (square == 13 ? 5 : 8); ++x) {
            const double column = 8 * (square % 4) + x - 15.5, row = 8 * (square / 4) + y - 15.5;
            const Vec3 target = middle + pixel * (column * u + row * v);
            rays.push_back({.origin = eye, .direction = (target - eye).normalized()});
          }
    }
    hits += expect_agreement(traced, rays);
  }
  EXPECT_GT(hits, 5000);
}

TEST(WideMaximum, of_a_ray_does_not_depend_on_the_rays_that_share_its_group) {
  const TracedDataset traced(volume_of<std::uint8_t>(
      {37, 22, 41}, [](const Index3& at) { return static_cast<std::uint8_t>(noise(9, 0)(at)); }));
  const std::vector<Ray> rays = rays_through({36, 21, 40}, 1000, 3);
  std::vector<std::size_t> order(rays.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937_64(4));
  for (const Machine machine : wide_machines()) {
    const std::vector<Hit> together = largest_values(traced, Method{}, machine, rays);
    std::vector<Ray> shuffled;
    for (const std::size_t i : order) shuffled.push_back(rays[i]);
    const std::vector<Hit> apart = largest_values(traced, Method{}, machine, shuffled);
    int different = 0;
    for (std::size_t i = 0; i < order.size(); ++i) different += !same_bits(apart[i], together[order[i]]);
    EXPECT_EQ(different, 0) << name_of(machine);
    for (std::size_t i = 0; i < rays.size(); i += 17)
      EXPECT_TRUE(same_bits(largest_values(traced, Method{}, machine, {rays[i]}).front(), together[i])) << i;
  }
}

TEST(WideMaximum, allocates_nothing_once_it_has_its_memory) {
  const TracedDataset traced(volume_of<std::uint16_t>(
      {37, 22, 41}, [](const Index3& at) { return static_cast<std::uint16_t>(noise(900, 0)(at)); }));
  const render::LoadedDataset& dataset = traced.dataset().implementation();
  for (const Machine machine : wide_machines()) {
    const render::Kernel kernel = render::choose_intersectors(dataset, {}, machine).largest;
    render::RayBatch rays(1024);
    render::HitBatch hits(1024);
    render::KernelScratch scratch;
    for (const Ray& ray : bundles({36, 21, 40}, 1024, 5)) rays.set(rays.count++, ray);
    kernel(dataset, {}, rays, hits, scratch);
    const std::size_t before = allocation_count();
    kernel(dataset, {}, rays, hits, scratch);
    EXPECT_EQ(allocation_count(), before) << name_of(machine);
    EXPECT_GT(scratch.counters.cells_visited, 1024U);
  }
}

}  // namespace
}  // namespace rhoray::tests
