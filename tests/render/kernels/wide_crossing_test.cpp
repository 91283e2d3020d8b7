#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "render/kernels/kernels.h"
#include "render/method.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_volume.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;

constexpr Method single = render::method_of(render::Accuracy::single);
constexpr Method judged = render::method_of(render::Accuracy::exact);

std::vector<Machine> wide_machines() {
  std::vector<Machine> machines;
  for (const Machine machine : {Machine::baseline, Machine::avx2, Machine::avx512})
    if (render::has_machine(machine)) machines.push_back(machine);
  return machines;
}

std::vector<Hit> answers(TracedVolume& traced, const Method& method, Machine machine, const std::vector<Ray>& rays,
                         double isovalue) {
  const render::Kernels kernels = render::choose_kernels(traced.volume().implementation(), method, machine);
  std::vector<Hit> hits(rays.size());
  render::ask(kernels.first_crossing, traced.volume().implementation(), {.isovalue = isovalue, .method = method}, rays,
              hits, traced.scratch);
  return hits;
}

/// Squares of 8 x 8 rays from points around and inside a box [0, size] towards points in it.
std::vector<Ray> bundles(const Vec3& size, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const Vec3 target = dice.point({0, 0, 0}, size), towards = dice.direction();
    const double back = dice.between(0.1, 3) * size.length(), spread = dice.between(0.01, 8);
    const Vec3 u = towards.cross(Vec3(0.3, 0.5, 0.8)).normalized(), v = towards.cross(u);
    const bool is_parallel = dice.below(4) == 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec3 shift = spread * ((x - 3.5) / 4 * u + (y - 3.5) / 4 * v), eye = target - back * towards;
        rays.push_back({.origin = is_parallel ? eye + shift : eye,
                        .direction = is_parallel ? towards : (target + shift - eye).normalized()});
      }
  }
  return rays;
}

TEST(WideCrossing, probe) {
  const Index3 samples(37, 22, 41);
  const Vec3 size(36, 21, 40);
  Dice dice(5);
  TracedVolume traced(volume_of<std::uint16_t>(samples, [&](const Index3& i) {
    return static_cast<std::uint16_t>(1000 + 400 * (std::sin(0.4 * static_cast<double>(i.x)) + std::sin(0.5 * static_cast<double>(i.y)) * std::cos(0.3 * static_cast<double>(i.z))) + dice.between(0, 60));
  }));
  for (const auto& rays : {bundles(size, 20000, 1), stressful_rays(size, 20000, 2)})
    for (const double iso : {1000.0, 1100.3, 1300.0}) {
      const auto reference = answers(traced, single, Machine::scalar, rays, iso);
      const auto twofold = answers(traced, Method{}, Machine::scalar, rays, iso);
      for (const Machine machine : wide_machines()) {
        const auto wide = answers(traced, single, machine, rays, iso);
        int missed = 0, invented = 0, both = 0, cells = 0, ref = 0; double worst = 0, worst_gradient = 0;
        for (std::size_t r = 0; r < rays.size(); ++r) {
          if (reference[r].is_miss() != twofold[r].is_miss()) ++ref;
          if (wide[r].is_miss() && !twofold[r].is_miss()) { ++missed; if (missed < 3) std::printf("missed ray %zu o %.17g %.17g %.17g d %.17g %.17g %.17g t %g %g, is %.17g\n", r, rays[r].origin.x, rays[r].origin.y, rays[r].origin.z, rays[r].direction.x, rays[r].direction.y, rays[r].direction.z, rays[r].t_min, rays[r].t_max, twofold[r].t); }
          if (!wide[r].is_miss() && twofold[r].is_miss()) ++invented;
          if (!wide[r].is_miss() && !twofold[r].is_miss()) {
            ++both;
            const double d = std::abs(wide[r].t - twofold[r].t) * rays[r].direction.length();
            if (d > worst) worst = d;
            if (d > 1e-3 && machine == Machine::avx512) { static int shown = 0; if (++shown < 12) { const auto j = answers(traced, judged, machine, {rays[r]}, iso); std::printf("ray %zu o %.17g %.17g %.17g d %.17g %.17g %.17g t %g %g: wide %.17g ref %.17g judge %.17g float %.17g cells %zu %zu\n", r, rays[r].origin.x, rays[r].origin.y, rays[r].origin.z, rays[r].direction.x, rays[r].direction.y, rays[r].direction.z, rays[r].t_min, rays[r].t_max, wide[r].t, twofold[r].t, j[0].t, reference[r].t, (size_t)wide[r].cell, (size_t)twofold[r].cell); } }
            if (wide[r].cell != twofold[r].cell) ++cells;
            else worst_gradient = std::max(worst_gradient, (wide[r].gradient - twofold[r].gradient).length());
          }
        }
        std::printf("%s iso %g: both %d missed %d invented %d ref %d other cell %d worst t %g gradient %g\n", name_of(machine), iso, both, missed, invented, ref, cells, worst, worst_gradient);
      }
    }
}

}  // namespace
}  // namespace rhoray::tests
