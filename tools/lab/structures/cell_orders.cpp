#include "tools/lab/structures/cell_orders.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <random>

#include "tools/lab/structures/hilbert_curve.h"

namespace rhoray::study {
namespace {

/// Sorts by keys of the cells' centres, given as steps of 2^-21 of the mesh's longest edge.
template <class Key>
std::vector<std::uint32_t> along_curve(const PlainMesh& mesh, Key&& key) {
  const Box3 bounds = mesh.bounds();
  const double edge = std::max({bounds.size().x, bounds.size().y, bounds.size().z});
  std::vector<std::uint64_t> keys;
  for (std::uint32_t cell = 0; cell < mesh.cell_count(); ++cell) {
    std::array<std::uint32_t, 3> steps;
    for (int axis = 0; axis < 3; ++axis)
      steps[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(
          std::clamp((mesh.center(cell)[axis] - bounds.min[axis]) / edge * 0x1p21, 0.0, 0x1p21 - 1));
    keys.push_back(key(steps));
  }
  std::vector<std::uint32_t> order = as_they_stand(mesh);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return order;
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
  return along_curve(mesh, [](const std::array<std::uint32_t, 3>& steps) {
    std::uint64_t key = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t bit = 0; bit < 21; ++bit) key |= std::uint64_t{steps[axis] >> bit & 1} << (3 * bit + axis);
    return key;
  });
}

std::vector<std::uint32_t> by_hilbert(const PlainMesh& mesh) {
  return along_curve(
      mesh, [](const std::array<std::uint32_t, 3>& steps) { return hilbert_position(steps[0], steps[1], steps[2]); });
}

}  // namespace rhoray::study
