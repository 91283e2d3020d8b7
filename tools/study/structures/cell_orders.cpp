#include "tools/study/structures/cell_orders.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <random>
#include <span>

namespace rhoray::study {
namespace {

std::vector<Vec3> centers_of(const PlainMesh& mesh) {
  std::vector<Vec3> centers;
  for (std::uint32_t cell = 0; cell < mesh.cell_count(); ++cell) centers.push_back(mesh.center(cell));
  return centers;
}

void halve(std::span<std::uint32_t> part, const std::vector<Vec3>& centers) {
  if (part.size() < 2) return;
  Box3 box;
  for (const std::uint32_t cell : part) box.extendBy(centers[cell]);
  const int axis = static_cast<int>(box.majorAxis());
  // Half of the power of two at or above: the first part is a whole subtree.
  const std::size_t half = std::bit_ceil(part.size()) / 2;
  std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(half), part.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
                   });
  halve(part.first(half), centers);
  halve(part.subspan(half), centers);
}

}  // namespace

std::vector<std::uint32_t> as_they_stand(const PlainMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.cell_count());
  std::iota(order.begin(), order.end(), 0U);
  return order;
}

std::vector<std::uint32_t> as_made(const PlainMesh& mesh) {
  std::vector<std::uint32_t> order = as_they_stand(mesh);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return mesh.cell_id(a) < mesh.cell_id(b); });
  return order;
}

std::vector<std::uint32_t> shuffled(const PlainMesh& mesh) {
  std::vector<std::uint32_t> order = as_they_stand(mesh);
  std::mt19937_64 random(3);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

std::vector<std::uint32_t> by_morton(const PlainMesh& mesh) {
  const Box3 bounds = mesh.bounds();
  const double edge = std::max({bounds.size().x, bounds.size().y, bounds.size().z});
  std::vector<std::uint64_t> keys;
  for (const Vec3& center : centers_of(mesh)) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double place = (center[axis] - bounds.min[axis]) / edge * 0x1p21;
      const auto steps = static_cast<std::uint64_t>(std::clamp(place, 0.0, 0x1p21 - 1));
      for (int bit = 0; bit < 21; ++bit) key |= (steps >> bit & 1) << (3 * bit + axis);
    }
    keys.push_back(key);
  }
  std::vector<std::uint32_t> order = as_they_stand(mesh);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return order;
}

std::vector<std::uint32_t> by_halves(const PlainMesh& mesh) {
  std::vector<std::uint32_t> order = as_they_stand(mesh);
  halve(order, centers_of(mesh));
  return order;
}

}  // namespace rhoray::study
