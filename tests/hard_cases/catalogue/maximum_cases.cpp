// M. The largest value on a ray: where it is hard to find, and what makes a search stop before it.
#include <array>

#include "tests/hard_cases/catalogue/case_parts.h"

namespace rhoray::tests {
namespace {

const Index3 cube(10, 10, 10);
const Vec3 size(9);

template <class T>
Pack values_of(std::function<double(const Index3&)> value, const preprocess::PackVolumeOptions& options = {}) {
  return grid_of<T>(
      cube, [=](const Index3& at) { return static_cast<T>(value(at)); }, {}, options);
}

HardCase largest(HardCase hard_case) {
  hard_case.asked = Asked::largest_value;
  return hard_case;
}

Rays rays(std::uint64_t seed, std::size_t count = 240) {
  return all_kinds_of_rays(size, count, seed);
}

}  // namespace

std::vector<HardCase> maximum_cases() {
  std::vector<HardCase> cases;
  const auto add = [&](HardCase hard_case) { cases.push_back(largest(std::move(hard_case))); };
  add({.id = "M01",
       .story = "Along a ray the field is a cubic in each cell, and its summit may lie between the faces.",
       .pack = values_of<float>(noise),
       .rays = rays(1),
       .naive = {"paper double", 18}});
  add({.id = "M02",
       .story = "A plateau at the top: the same value all along.",
       .pack = values_of<std::uint8_t>([](const Index3& at) {
         const bool top = std::min({at.x, at.y, at.z}) >= 3 && std::max({at.x, at.y, at.z}) <= 6;
         return static_cast<double>(top ? 200 : whole_noise(at, 200));
       }),
       .rays = rays(2),
       .naive = {"paper double", 19}});
  add({.id = "M03",
       .story = "The same largest value in cells far apart.",
       .pack = values_of<std::uint8_t>(
           [](const Index3& at) { return static_cast<double>((at.x % 3 + at.y % 3 + at.z % 3) * 10); }),
       .rays = rays(3),
       .naive = {"sampled 1", 113}});
  add({.id = "M04",
       .story = "All values are negative: a search that begins at zero finds zero.",
       .pack = values_of<double>([](const Index3& at) { return -100 - noise(at); }),
       .rays = rays(4),
       .naive = {"paper double", 20}});
  add({.id = "M05",
       .story = "Nothing varies: no bound is above what was found, and none is below.",
       .pack = values_of<float>([](const Index3&) { return 0.1; }),
       .rays = rays(5, 120),
       .naive = {.reason = "every way of looking finds the one value there is"},
       .known = [](const render::Ray& ray, double) -> std::optional<double> {
         if (!part_in_box(ray, Vec3(1e-6), size - Vec3(1e-6))) return std::nullopt;
         return static_cast<double>(0.1F);
       }});
  add({.id = "M06",
       .story = "Samples without data among the largest: their cells are absent.",
       .pack = values_of<float>(
           [](const Index3& at) { return whole_noise(at + Index3(300, 0, 0), 9) == 0 ? std::nan("") : noise(at); }),
       .rays = rays(6),
       .naive = {"paper double", 16}});
  add({.id = "M07",
       .story = "The largest values are in the volume's own sides, edges and corners.",
       .pack = values_of<std::uint8_t>([](const Index3& at) {
         int sides = 0;
         for (int a = 0; a < 3; ++a) sides += at[a] == 0 || at[a] == 9;
         return 50 * sides + static_cast<double>(whole_noise(at, 40));
       }),
       .rays = rays(7),
       .naive = {"sampled 1", 58}});
  add({.id = "M08",
       .story = "The largest samples stand where bricks meet.",
       .pack = values_of<float>([](const Index3& at) { return noise(at) + (at.x % 3 == 0 && at.y % 3 == 0 ? 1 : 0); },
                                {.brick_edge = 3}),
       .rays = rays(8),
       .naive = {"sampled 1", 97}});
  add({.id = "M09",
       .story = "Rays in no order, cut to parts of themselves: where the last one had its largest value says little "
                "about this one's.",
       .pack = values_of<float>(noise),
       .rays = stressful_rays(size, 240, 9),
       .naive = {"paper double", 11},
       .direct_may_fail_by = "some rays meet the volume in one point of an edge, or pass it by, as rounding has it"});
  add({.id = "M10",
       .story =
           "Summits in many cells that differ by less than rounding: a bound that is not above its value loses one.",
       .pack =
           values_of<double>([](const Index3& at) { return ((at.x + at.y) % 2 == 0 ? 1.0 : 0.0) + 1e-15 * noise(at); }),
       .rays = rays(10),
       .naive = {"paper double", 13}});
  add({.id = "M11",
       .story = "Rays that miss the volume, end before it, or have no length in it.",
       .pack = values_of<float>(noise),
       .rays =
           [] {
             Rays all;
             for (render::Ray ray : all_kinds_of_rays(Vec3(24), 180, 11)) all.push_back(ray);
             for (render::Ray ray : random_rays(size, 60, 12)) ray.t_max = 1, all.push_back(ray);
             for (render::Ray ray : random_rays(size, 60, 13)) {
               ray.t_min = ray.t_max = 31;
               all.push_back(ray);
             }
             return all;
           }(),
       .naive = {"paper double", 4}});
  add({.id = "M12",
       .story = "Macrocells of two on many levels, and all bounds alike: the queue holds as many entries as it ever "
                "will.",
       .pack = grid_of<std::uint8_t>(
           {33, 33, 33}, [](const Index3& at) { return static_cast<std::uint8_t>((at.x + at.y + at.z) % 2 ? 255 : 0); },
           {}, {.macro_factor = 2, .macro_level_count = 5}),
       .rays = all_kinds_of_rays(Vec3(32), 120, 14),
       .naive = {"sampled 1", 55}});
  add({.id = "M14",
       .story = "One outlier of 1e30 among values of one: bounds that are cut into steps of the range are all alike.",
       .pack = values_of<float>([](const Index3& at) { return at == Index3(4, 5, 6) ? 1e30 : noise(at); }),
       .rays = together({rays(15), aimed_rays(size, 3, 120, 16)}),
       .naive = {"sampled 1", 10}});
  return cases;
}

}  // namespace rhoray::tests
