#include "data/recipes/torso_ct.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "data/recipes/torso_scene.h"
#include "data/recipes/write_nrrd.h"
#include "formats/base/error.h"
#include "formats/base/parallel.h"

namespace rhoray::recipes {

namespace {

constexpr double air_hu = -1000, fat_hu = -95, muscle_hu = 55, chest_hu = 25, lung_hu = -830, heart_hu = 65,
                 compact_bone_hu = 1150, marrow_hu = 320;
constexpr double fat_mm = 9, compact_bone_mm = 2.2, chest_wall_mm = 6;

/// Share of the body in the value that a scanner measures at p: blurred over two voxels across the
/// surface, which is treated as a plane.
template <class Body>
double share_inside(const Body& body, double value, const Vec3& p, const Vec3& spacing) {
  // The functions of bodies grow about as fast as distance, seldom four times as fast. Farther
  // away, the surface does not cut the voxel.
  const double reach = 4 * std::max({spacing.x, spacing.y, spacing.z});
  if (value > reach) return 0;
  if (value < -reach) return 1;
  constexpr double step = 0.05;
  const Vec3 slope(body(p + Vec3(step, 0, 0)) - body(p - Vec3(step, 0, 0)),
                   body(p + Vec3(0, step, 0)) - body(p - Vec3(0, step, 0)),
                   body(p + Vec3(0, 0, step)) - body(p - Vec3(0, 0, step)));
  const double extent =
      (std::abs(slope.x) * spacing.x + std::abs(slope.y) * spacing.y + std::abs(slope.z) * spacing.z) / (2 * step);
  if (extent == 0) return value < 0 ? 1 : 0;
  const double t = std::clamp(0.5 - value / (2 * extent), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double lungs(const Vec3& p) {
  return p.x > 0 ? torso::left_lung(p) : torso::right_lung(p);
}

/// Hounsfield units at a point where the skin function has the value `skin`.
double tissue_value(const Vec3& p, const Vec3& spacing, double skin) {
  double hu = air_hu;
  const auto paint = [&](double tissue_hu, double value, auto&& body) {
    const double share = share_inside(body, value, p, spacing);
    hu += share * (tissue_hu - hu);
  };
  const auto under_fat = [](const Vec3& q) { return torso::skin(q) + fat_mm; };
  const auto chest = [](const Vec3& q) { return torso::rib_cage(q) + chest_wall_mm; };
  const auto marrow = [](const Vec3& q) { return torso::bone(q) + compact_bone_mm; };
  paint(fat_hu, skin, torso::skin);
  if (skin > 0) return hu;  // tissues under the fat do not extend outside the skin
  paint(muscle_hu, skin + fat_mm, under_fat);
  paint(chest_hu, chest(p), chest);
  paint(heart_hu, torso::heart(p), torso::heart);
  paint(lung_hu, lungs(p), lungs);
  const double bone = torso::bone(p);
  paint(compact_bone_hu, bone, torso::bone);
  paint(marrow_hu, bone + compact_bone_mm, marrow);
  return hu;
}

/// SplitMix64's finaliser: every bit of the result depends on every bit of the counter.
std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace

CtLattice ct_lattice(const Index3& sample_count) {
  const Vec3 extent = torso::frame.size();
  const Vec3 spacing(extent.x / static_cast<double>(sample_count.x), extent.y / static_cast<double>(sample_count.y),
                     extent.z / static_cast<double>(sample_count.z));
  return {sample_count, spacing, torso::frame.min + 0.5 * spacing};
}

double ct_value(const Vec3& p, const Vec3& spacing) {
  const double skin = torso::skin(p);
  const double clear = 4 * std::max({spacing.x, spacing.y, spacing.z});
  return skin > clear ? air_hu : tissue_value(p, spacing, skin);
}

double ct_noise(std::uint64_t sample) {
  constexpr std::uint64_t seed = 0x7068616e746f6d31u;
  const std::uint64_t bits = scramble(sample ^ seed);
  // sum of four uniform variables in 0..1, minus their mean: nearly normal, with variance 4/12
  double sum = -2;
  for (int part = 0; part < 4; ++part) sum += (static_cast<double>((bits >> (16 * part)) & 0xffff) + 0.5) / 65536;
  return 12 * sum / std::sqrt(4.0 / 12);
}

void write_torso_ct(const std::filesystem::path& path, const Index3& sample_count, bool replace_existing) {
  for (const std::int64_t n : {sample_count.x, sample_count.y, sample_count.z})
    if (n < 2 || n > 16384)
      throw Error(ErrorCode::usage, concat("size ", sample_count.x, "x", sample_count.y, "x", sample_count.z,
                                           "; expected 2 to 16384 samples on each axis"));
  const CtLattice lattice = ct_lattice(sample_count);
  const NrrdHeader header{.type = "int16",
                          .sample_count = sample_count,
                          .first_sample = lattice.first_sample,
                          .spacing = lattice.spacing,
                          .in_patient_mm = true,
                          .content = "synthetic CT of a torso (HU)"};
  write_nrrd(path, replace_existing, header, [&](PendingFile& raw) {
    constexpr std::int64_t slab = 16;  // slices in memory at a time
    const std::int64_t nx = sample_count.x, ny = sample_count.y, nz = sample_count.z;
    std::vector<std::int16_t> samples(static_cast<std::size_t>(nx * ny * std::min(slab, nz)));
    for (std::int64_t first = 0; first < nz; first += slab) {
      const std::int64_t rows = ny * std::min(slab, nz - first);
      parallel_for_each(static_cast<std::size_t>(rows), [&](std::size_t row_index) {
        const auto row = static_cast<std::int64_t>(row_index);
        const std::int64_t j = row % ny, k = first + row / ny;
        for (std::int64_t i = 0; i < nx; ++i) {
          const Vec3 p = lattice.first_sample +
                         lattice.spacing * Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          const double hu = ct_value(p, lattice.spacing) + ct_noise(static_cast<std::uint64_t>(i + nx * (j + ny * k)));
          samples[static_cast<std::size_t>(row * nx + i)] = static_cast<std::int16_t>(std::lround(hu));
        }
      });
      raw.append(std::as_bytes(std::span(samples).first(static_cast<std::size_t>(rows * nx))));
    }
  });
}

}  // namespace rhoray::recipes
