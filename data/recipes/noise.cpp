#include "data/recipes/noise.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace rhoray::recipes {

namespace {

/// Pseudo-random bits of a point with integer coordinates.
std::uint32_t bits_of(std::int32_t x, std::int32_t y, std::int32_t z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343U ^ static_cast<std::uint32_t>(y) * 0xd8163841U ^
                    static_cast<std::uint32_t>(z) * 0xcb1ab31fU;
  h ^= h >> 15, h *= 0x2c1b3c6dU, h ^= h >> 12, h *= 0x297a2d39U, h ^= h >> 15;
  return h;
}

/// Dot product of an offset with one of the twelve directions to the edges of a cube.
double slope(std::uint32_t bits, double x, double y, double z) {
  const std::uint32_t edge = bits % 12;
  const double u = edge < 8 ? x : y, v = edge < 4 ? y : z;
  return ((bits & 16) != 0 ? -u : u) + ((bits & 32) != 0 ? -v : v);
}

double eased(double t) {
  return t * t * t * (t * (6 * t - 15) + 10);
}

}  // namespace

double noise(const Vec3& p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy), iz = static_cast<std::int32_t>(fz);
  const double x = p.x - fx, y = p.y - fy, z = p.z - fz, wx = eased(x), wy = eased(y), wz = eased(z);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int cx = corner & 1, cy = corner >> 1 & 1, cz = corner >> 2;
    const double weight = (cx != 0 ? wx : 1 - wx) * (cy != 0 ? wy : 1 - wy) * (cz != 0 ? wz : 1 - wz);
    sum += weight * slope(bits_of(ix + cx, iy + cy, iz + cz), x - cx, y - cy, z - cz);
  }
  return sum;
}

double layered_noise(const Vec3& p, int layers) {
  double sum = 0, strength = 1;
  Vec3 at = p;
  for (int layer = 0; layer < layers; ++layer) {
    sum += strength * noise(at);
    strength /= 2;
    // so that the integer points of octaves do not coincide
    at = 2.03 * at + Vec3(17.1, 5.7, 11.3);
  }
  return sum;
}

NoiseCell noise_cell(const Vec3& p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const auto ix = static_cast<std::int32_t>(fx), iy = static_cast<std::int32_t>(fy), iz = static_cast<std::int32_t>(fz);
  double nearest = 1e9, next = 1e9;
  NoiseCell cell;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint32_t bits = bits_of(ix + dx, iy + dy, iz + dz);
        const auto share = [&](int shift) { return static_cast<double>(bits >> shift & 1023) / 1023; };
        const Vec3 middle(fx + dx + share(0), fy + dy + share(10), fz + dz + share(20));
        const double distance = (middle - p).length();
        if (distance < nearest) {
          next = nearest;
          nearest = distance;
          cell.number = share(5);
        } else if (distance < next) {
          next = distance;
        }
      }
  cell.from_wall = next - nearest;
  return cell;
}

}  // namespace rhoray::recipes
