// D. Values of the data: magnitudes, types and gaps that break a tolerance, a conversion or a sign
// with a third state.
#include <array>

#include "tests/hard_cases/catalogue/case_parts.h"

namespace rhoray::tests {
namespace {

const Index3 cube(10, 10, 10);
const Vec3 size(9);

template <class T>
Pack values_of(std::function<double(const Index3&)> value) {
  return grid_of<T>(cube, [=](const Index3& at) { return static_cast<T>(value(at)); });
}

Rays rays(std::uint64_t seed, std::size_t count = 240) {
  return all_kinds_of_rays(size, count, seed);
}

double with_gaps(const Index3& at, double gap) {
  return whole_noise(at + Index3(500, 0, 0), 9) == 0 ? gap : noise(at);
}

}  // namespace

std::vector<HardCase> value_cases() {
  std::vector<HardCase> cases;
  const auto add = [&](HardCase hard_case) { cases.push_back(std::move(hard_case)); };
  add({.id = "D01",
       .story = "The whole range of 16-bit integers: differences do not fit their type, nor does a changed sign.",
       .pack = values_of<std::int16_t>([](const Index3& at) {
         const auto which = whole_noise(at, 4);
         return which == 0 ? -32768.0 : which == 1 ? 32767.0 : which == 2 ? 0.0 : noise(at) * 65535 - 32768;
       }),
       .isovalues = {-32768, -32767.5, 0, 32767},
       .rays = rays(1, 120),
       .naive = {"paper float", 50}});
  add({.id = "D02",
       .story = "Bytes, and isovalues at the ends of their range and beyond: a threshold of the data's type wraps "
                "round.",
       .pack =
           values_of<std::uint8_t>([](const Index3& at) { return static_cast<double>(whole_noise(at, 3)) * 127.5; }),
       .isovalues = {-1, 0, 0.5, 254.5, 255, 255.5},
       .rays = rays(2, 120),
       .naive = {"paper float", 30}});
  add({.id = "D03",
       .story = "Whole numbers above 2^24: single precision does not tell neighbours apart.",
       .pack = values_of<std::int32_t>(
           [](const Index3& at) { return 16777216.0 * 64 + static_cast<double>(whole_noise(at, 5)); }),
       .isovalues = {16777216.0 * 64 + 2, 16777216.0 * 64 + 2.5},
       .rays = rays(3),
       .naive = {"paper float", 215}});
  add({.id = "D04",
       .story = "Values near the largest that single precision holds: products overflow, and infinity less infinity is "
                "no number.",
       .pack = values_of<float>([](const Index3& at) { return 3.3e38 * (2 * noise(at) - 1); }),
       .isovalues = {0, 1.1e38},
       .rays = rays(4),
       .naive = {"paper float", 215}});
  add({.id = "D05",
       .story = "Values of 1e-30 and denormal ones: any fixed tolerance makes every sample a hit, or none.",
       .pack = values_of<float>([](const Index3& at) { return 1e-30 * noise(at); }),
       .isovalues = {6e-31},
       .rays = rays(5),
       .naive = {"paper double", 107}});
  add({.id = "D05d",
       .story = "As D05, with a handful of units of the smallest positive number there is.",
       .pack = values_of<double>([](const Index3& at) { return 5e-324 * static_cast<double>(whole_noise(at, 7)); }),
       .isovalues = {5e-324 * 3, 5e-324 * 4},
       .rays = rays(6, 120),
       .naive = {"paper double", 108},
       .direct_may_fail_by = ties_at_edges});
  add({.id = "D06",
       .story = "Values from 1e-30 to 1e30 in one cell: a face's value that is computed anew on its other side has "
                "another sign.",
       .pack = values_of<float>([](const Index3& at) {
         const double sign = whole_noise(at, 2) == 0 ? 1 : -1;
         return sign * std::pow(10, std::round(noise(at + Index3(77, 0, 0)) * 60 - 30));
       }),
       .isovalues = {0, 1e-10},
       .rays = rays(7),
       .naive = {"paper float", 200}});
  add({.id = "D07",
       .story = "Samples without data: their cells are absent, a ray goes on behind them, and no surface is drawn "
                "against them.",
       .pack = values_of<float>([](const Index3& at) { return with_gaps(at, std::nan("")); }),
       .isovalues = {0.6},
       .rays = rays(8, 360),
       .naive = {"sampled 1", 122}});
  add({.id = "D08",
       .story = "Infinite samples, of either sign, are no data.",
       .pack = values_of<double>([](const Index3& at) { return with_gaps(at, at.x % 2 == 0 ? no_hit : -no_hit); }),
       .isovalues = {0.6},
       .rays = rays(9, 360),
       .naive = {"sampled 1", 124}});
  add({.id = "D09",
       .story = "Zeros of both signs, and the isovalue zero: both are inside.",
       .pack = values_of<float>([](const Index3& at) {
         return std::array{0.0, -0.0, -1.0, 1.0}[static_cast<std::size_t>(whole_noise(at, 4))];
       }),
       .isovalues = {0, -0.0},
       .rays = rays(10),
       .naive = {"paper float", 124}});
  add({.id = "D10",
       .story = "The isovalue lies half a unit of single precision beside a value of the data: rounded, it is that "
                "value.",
       .pack = values_of<float>([](const Index3& at) { return 1 + static_cast<double>(whole_noise(at, 3)); }),
       .isovalues = {2 + 0x1p-24, 2 - 0x1p-25, 3 - 0x1p-25},
       .rays = rays(11, 120),
       .naive = {"paper float", 74}});
  add({.id = "D11",
       .story = "Values in double precision that single precision makes one.",
       .pack = values_of<double>([](const Index3& at) { return 1 + 1e-9 * noise(at); }),
       .isovalues = {1 + 6e-10},
       .rays = rays(12),
       .naive = {"paper double", 81}});
  add({.id = "D12",
       .story =
           "Blocks of which only one sample reaches the isovalue: a range that is rounded inward passes over them.",
       .pack = values_of<double>([](const Index3& at) { return whole_noise(at, 64) == 0 ? 1 / 3.0 : 0.0; }),
       .isovalues = {1 / 3.0, std::nextafter(1 / 3.0, 0.0)},
       .rays = together({rays(13, 60), aimed_rays(size, 3, 240, 13)}),
       .naive = {"sampled 1", 8}});
  add({.id = "D13",
       .story = "Blocks of samples that are all the isovalue, beside blocks that are below it.",
       .pack = values_of<std::uint8_t>([](const Index3& at) { return at.x / 4 + at.y / 4 + at.z / 4 >= 2 ? 5 : 0; }),
       .isovalues = {5},
       .rays = rays(14),
       .naive = {"paper float", 37}});
  add({.id = "D14",
       .story = "Values one unit of rounding apart: the inverse of a difference is huge.",
       .pack = values_of<float>([](const Index3& at) {
         return whole_noise(at, 2) == 0 ? 1.0 : static_cast<double>(std::nextafter(1.0F, 2.0F));
       }),
       .isovalues = {1 + 0x1p-24, static_cast<double>(std::nextafter(1.0F, 2.0F))},
       .rays = rays(15),
       .naive = {"paper double", 19}});
  return cases;
}

}  // namespace rhoray::tests
