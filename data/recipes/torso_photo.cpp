#include "data/recipes/torso_photo.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "data/recipes/noise.h"
#include "data/recipes/torso_ct.h"
#include "data/recipes/torso_scene.h"
#include "data/recipes/write_nrrd.h"
#include "formats/base/error.h"
#include "formats/base/parallel.h"

namespace rhoray::recipes {

namespace {

double decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// Linear RGB of a colour in 8-bit sRGB.
Vec3 light(int red, int green, int blue) {
  return {decoded(red / 255.0), decoded(green / 255.0), decoded(blue / 255.0)};
}

Vec3 mixed(const Vec3& a, const Vec3& b, double share) {
  return a + std::clamp(share, 0.0, 1.0) * (b - a);
}

/// 0 below a, 1 above b, smooth between; decreasing if b is below a.
double step_between(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// A network of branching lines: 1 on the lines, where one noise is close to 0 and another not low.
double vessels(const Vec3& p, double width_mm, double thickness) {
  const Vec3 q = p / width_mm;
  const double bend = 0.35 * noise(2.1 * q);
  return step_between(thickness, thickness / 3, std::abs(noise(q) + 0.3 * bend)) *
         step_between(-0.35, 0.1, noise(0.7 * q + Vec3(9, 3, 5)));
}

Vec3 skin_light(const Vec3& p) {
  static const Vec3 pale = light(226, 178, 150), rosy = light(205, 138, 116), vein = light(128, 128, 142),
                    mole = light(120, 74, 52);
  Vec3 color = mixed(pale, rosy, 0.45 + 0.5 * layered_noise(p / 40, 3));
  color = mixed(color, vein, 0.3 * vessels(p, 55, 0.06));
  const NoiseCell freckle = noise_cell(p / 28);
  color = mixed(color, mole, freckle.number > 0.93 ? 0.7 * step_between(0.75, 0.95, freckle.from_wall) : 0);
  return (1 + 0.06 * layered_noise(p / 2.5, 2)) * color;
}

Vec3 fat_light(const Vec3& p) {
  static const Vec3 butter = light(236, 196, 104), amber = light(214, 160, 70), septum = light(244, 230, 200);
  const NoiseCell lobule = noise_cell(p / 7 + 0.25 * Vec3(noise(p / 11), noise(p / 13), noise(p / 12)));
  const Vec3 color = mixed(butter, amber, lobule.number);
  return mixed(septum, color, step_between(0.03, 0.16, lobule.from_wall));
}

/// Muscle fibres at a point: coordinates along and across the fibres, mm, the share covered by a
/// pale sinew, and the depth of the groove to the next muscle.
struct Fibres {
  double along = 0, across = 0;
  double sinew = 0, groove = 0;
};

/// Fibres that converge to a point, in the plane of x and z.
Fibres fan(double x, double z, double to_x, double to_z) {
  const double dx = x - to_x, dz = z - to_z;
  return {.along = std::hypot(dx, dz), .across = 130 * std::atan2(dz, -dx)};
}

/// 1 at distance 0, 0 beyond half the width.
double near(double distance_mm, double half_width_mm) {
  return step_between(half_width_mm, 0.2 * half_width_mm, std::abs(distance_mm));
}

/// A triangle wave of period 1 and height 1.
double zigzag(double t) {
  return 2 * std::abs(t - std::floor(t + 0.5));
}

/// Straight abdominal muscles, side by side, divided by sinews.
Fibres belly(double x, double z, double wobble) {
  Fibres fibres{.along = z, .across = x};
  for (const double sinew : {346.0, 296.0, 244.0})
    fibres.sinew = std::max(fibres.sinew, 0.8 * near(z - sinew - 5 * wobble - 4 * zigzag(x / 31), 5));
  fibres.sinew = std::max(fibres.sinew, near(x, 6 + 1.5 * wobble));
  return fibres;
}

Fibres front(double x, double z, double wobble) {
  constexpr double belly_half_width = 68;
  const double chest_border = z - 374 - 0.0023 * x * x + 5 * wobble;
  if (chest_border > 0) {
    Fibres fibres = fan(x, z, 185, 462);
    fibres.sinew = 0.9 * near(x, 11 + 3 * wobble) * step_between(515, 480, z);
    fibres.groove = std::max(near(chest_border, 7), 0.7 * near(z - 452 - 0.1 * x - 4 * wobble, 4));
    return fibres;
  }
  const double side = x - belly_half_width - 6 * std::sin(z / 60) - 2 * wobble;
  if (side < 0) {
    Fibres fibres = belly(x, z, wobble);
    fibres.sinew = std::max(fibres.sinew, 0.6 * near(side, 7));
    fibres.groove = near(chest_border, 7);
    return fibres;
  }
  // The oblique muscle ends in a sawtooth line under the ribs.
  const double teeth = z - 350 - 16 * zigzag(z / 90 + x / 34) - 0.5 * (x - 90) + 3 * wobble;
  Fibres fibres = teeth > 0 ? fan(x, z, 20, 560) : Fibres{.along = 0.8 * z + 0.6 * x, .across = 0.8 * x - 0.6 * z};
  fibres.sinew = std::max(0.6 * near(side, 7), 0.75 * step_between(26, 4, side) * step_between(215, 150, z));
  fibres.groove = std::max(near(chest_border, 7), near(teeth, 5));
  return fibres;
}

Fibres back(double x, double z, double wobble) {
  const double hood = z - 392 - 1.1 * x + 5 * wobble;  // the part between the shoulders
  if (hood > 0) {
    Fibres fibres = fan(x, z, 190, 540);
    fibres.sinew = 0.8 * near(x, 9);
    fibres.groove = near(hood, 6);
    return fibres;
  }
  Fibres fibres = fan(x, z, 175, 455);
  const double diamond = 268 - z - 1.5 * x + 8 * wobble;  // the sheet above the hips
  fibres.sinew = std::max(0.8 * near(x, 7), 0.8 * step_between(-12, 14, diamond));
  fibres.groove = near(hood, 6);
  return fibres;
}

Vec3 muscle_light(const Vec3& p) {
  static const Vec3 dark = light(104, 24, 22), red = light(172, 54, 44), pale = light(206, 128, 106),
                    sinew = light(232, 214, 190), fat = light(222, 176, 110), vein = light(72, 44, 76),
                    artery = light(168, 20, 18);
  const double x = std::abs(p.x), wobble = noise(p / 23) + 0.4 * noise(p / 7);
  const double from_front = std::atan2(x, -(p.y - torso::body_centre.y));
  const double turn = 0.56 * std::numbers::pi + 0.05 * noise(p / 30);
  Fibres fibres = from_front < turn ? front(x, p.z, wobble) : back(x, p.z, wobble);
  fibres.groove = std::max(fibres.groove, near(120 * (from_front - turn), 6));
  // Both sides of the body are similar but not equal.
  const double across = fibres.across + 2 * noise(p / 12) + 5 * noise(p / 45), side = p.x < 0 ? 70 : 0;
  const double thread = noise({across / 2.6, fibres.along / 45, side});
  const double bundle = noise({across / 8, fibres.along / 110, side + 30});
  Vec3 color = mixed(dark, red, 0.6 + 0.5 * thread + 0.35 * bundle + 0.3 * noise(p / 50));
  color = mixed(color, pale, 0.45 * step_between(0.12, 0.0, std::abs(bundle)) * (0.7 + 0.6 * thread));
  color = mixed(color, mixed(dark, fat, 0.5 + 0.9 * noise(p / 18)), 0.75 * fibres.groove);
  color = mixed(color, sinew, fibres.sinew * (0.8 + 0.3 * thread));
  color = mixed(color, vein, 0.8 * vessels(p, 66, 0.027));
  return mixed(color, artery, 0.75 * vessels(p + Vec3(140, 60, 90), 74, 0.018));
}

Vec3 chest_light(const Vec3& p) {
  static const Vec3 flesh = light(198, 112, 88), fat = light(230, 190, 120);
  return mixed(flesh, fat, 0.5 + 0.7 * layered_noise(p / 14, 3));
}

Vec3 heart_light(const Vec3& p) {
  static const Vec3 dark = light(96, 18, 20), red = light(160, 44, 38), fat = light(232, 200, 116),
                    artery = light(196, 40, 30);
  const Vec3 q = p - torso::heart_centre;
  const double along = q.dot(torso::heart_axis());
  const double turn = std::atan2(q.z + 0.3 * along, q.x - 0.2 * along);
  Vec3 color = mixed(dark, red, 0.5 + 0.6 * noise({30 * turn + along / 2, along / 5, q.length() / 4}));
  color = mixed(color, fat, step_between(0.15, 0.4, layered_noise(p / 26, 2) - along / 120));
  return mixed(color, artery, vessels(p, 34, 0.05));
}

Vec3 lung_light(const Vec3& p) {
  static const Vec3 pink = light(222, 158, 150), grey = light(150, 96, 96), vessel = light(110, 26, 40);
  const NoiseCell bubble = noise_cell(p / 4);
  const Vec3 color = mixed(grey, pink, 0.25 + 0.7 * step_between(0.02, 0.3, bubble.from_wall) + 0.2 * noise(p / 30));
  return mixed(color, vessel, vessels(p, 26, 0.05));
}

Vec3 bone_light(const Vec3& p, double depth) {
  static const Vec3 ivory = light(240, 226, 196), tan = light(206, 176, 130), red = light(124, 32, 28),
                    pore = light(120, 60, 48);
  if (depth > 2.2) {
    const double strut = step_between(0.2, 0.05, std::abs(layered_noise(p / 4.5, 2)));
    return mixed(red, ivory, strut);
  }
  Vec3 color = mixed(ivory, tan, 0.35 + 0.6 * layered_noise(p / 16, 3));
  color = mixed(color, pore, 0.6 * vessels(p, 20, 0.035));
  return (1 + 0.07 * noise(p / 1.8)) * color;
}

std::uint8_t byte_of(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * encoded(std::clamp(linear, 0.0, 1.0))));
}

}  // namespace

Vec3 tissue_light(const Vec3& p, double reach) {
  static const Vec3 gel = light(24, 52, 92);
  const double skin = torso::skin(p);
  if (skin > reach) return (1 + 0.15 * noise(p / 35)) * gel;
  constexpr double skin_mm = 2.5, fat_mm = 9, chest_wall_mm = 6;
  if (skin > -skin_mm) return skin_light(p);
  const double bone = torso::bone(p);
  if (bone < reach) return bone_light(p, -bone);
  if (std::min(torso::left_lung(p), torso::right_lung(p)) < 0) return lung_light(p);
  if (torso::heart(p) < reach) return heart_light(p);
  if (torso::rib_cage(p) + chest_wall_mm < 0) return chest_light(p);
  return skin + fat_mm < reach ? muscle_light(p) : fat_light(p);
}

std::array<std::uint8_t, 3> tissue_color(const Vec3& p, double reach) {
  const Vec3 linear = tissue_light(p, reach);
  return {byte_of(linear.x), byte_of(linear.y), byte_of(linear.z)};
}

void write_torso_photo(const std::filesystem::path& path, const Index3& texel_count, bool replace_existing) {
  const std::int64_t nx = texel_count.x, ny = texel_count.y, nz = texel_count.z;
  for (const std::int64_t n : {nx, ny, nz})
    if (n < 2 || n > 16384)
      throw Error(ErrorCode::usage, concat("size ", nx, "x", ny, "x", nz, "; expected 2 to 16384 texels on each axis"));
  const CtLattice lattice = ct_lattice(texel_count);
  // Covers the error of surfaces in a CT with voxels of about 2 mm, and the texels around them.
  const double reach = 2.2 + std::max({lattice.spacing.x, lattice.spacing.y, lattice.spacing.z});
  const NrrdHeader header{.type = "uint8",
                          .component_count = 3,
                          .sample_count = texel_count,
                          .first_sample = lattice.first_sample,
                          .spacing = lattice.spacing,
                          .in_patient_mm = true,
                          .content = "synthetic photographs of a torso (sRGB)"};
  write_nrrd(path, replace_existing, header, [&](PendingFile& raw) {
    constexpr std::int64_t slab = 8;  // slices in memory at a time
    using Texel = std::array<std::uint8_t, 3>;
    std::vector<Texel> texels(static_cast<std::size_t>(nx * ny * std::min(slab, nz)));
    for (std::int64_t first = 0; first < nz; first += slab) {
      const std::int64_t rows = ny * std::min(slab, nz - first);
      parallel_for_each(static_cast<std::size_t>(rows), [&](std::size_t row_index) {
        const auto row = static_cast<std::int64_t>(row_index);
        for (std::int64_t i = 0; i < nx; ++i) {
          const Vec3 at(static_cast<double>(i), static_cast<double>(row % ny), static_cast<double>(first + row / ny));
          texels[static_cast<std::size_t>(row * nx + i)] =
              tissue_color(lattice.first_sample + at * lattice.spacing, reach);
        }
      });
      raw.append(std::as_bytes(std::span(texels).first(static_cast<std::size_t>(rows * nx))));
    }
  });
}

}  // namespace rhoray::recipes
