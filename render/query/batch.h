#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>

#include "render/traverse/ray.h"

/// Rays and their answers in the form that kernels take: each number in an array of its own, so
/// that SIMD kernels load neighbours.
namespace rhoray::render {

/// The answer for one ray.
struct Hit {
  double t = std::numeric_limits<double>::infinity();  ///< infinity: nothing was hit
  double value = 0;                                    ///< field value there
  std::uint64_t cell = 0;                              ///< id of the cell
  /// Index of that tetrahedron; meshes and first_crossing only.
  std::uint32_t tet = 0;
  /// Field gradient there, data frame; first_crossing only.
  Vec3 gradient{0, 0, 0};
  /// Bound on the distance from the exact answer: from t for a crossing, from the value for a
  /// largest value. NaN where the method proves nothing.
  double error = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t root_count = 0;       ///< crossings found on the ray's way through the hit cell
  std::uint32_t iteration_count = 0;  ///< steps of the root's refinement
  std::uint32_t cost = 0;             ///< macrocells and cells visited for this ray, hit or not

  bool is_miss() const { return t == std::numeric_limits<double>::infinity(); }
};

/// An array aligned to cache lines; not initialised.
template <class T>
class LaneArray {
 public:
  LaneArray() = default;
  explicit LaneArray(std::size_t size) : data_(static_cast<T*>(::operator new[](size * sizeof(T), alignment))) {}

  T* data() const { return data_.get(); }
  T& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  static constexpr std::align_val_t alignment{64};
  struct Free {
    void operator()(T* data) const { ::operator delete[](data, alignment); }
  };
  std::unique_ptr<T[], Free> data_;
};

/// Rays in one data's frame. Neighbours in the batch should be neighbours in the picture: SIMD
/// kernels take them in groups of group_size and share what the rays of a group have in common.
class RayBatch {
 public:
  static constexpr std::size_t group_size = 64;  ///< 8 x 8 pixels

  /// The number of rays in the whole groups that hold this many.
  static constexpr std::size_t whole_groups(std::size_t rays) {
    return (rays + group_size - 1) / group_size * group_size;
  }

  RayBatch() = default;
  /// Allocates room for `capacity` rays, rounded up to whole groups.
  explicit RayBatch(std::size_t capacity) {
    capacity = whole_groups(capacity);
    for (std::size_t axis = 0; axis < 3; ++axis)
      origin[axis] = LaneArray<double>(capacity), direction[axis] = LaneArray<double>(capacity);
    t_min = LaneArray<double>(capacity), t_max = LaneArray<double>(capacity);
    start_side = LaneArray<StartSide>(capacity);
  }

  Ray operator[](std::size_t i) const {
    return {.origin = {origin[0][i], origin[1][i], origin[2][i]},
            .direction = {direction[0][i], direction[1][i], direction[2][i]},
            .t_min = t_min[i],
            .t_max = t_max[i],
            .start_side = has_start_sides ? start_side[i] : StartSide::unknown};
  }
  void set(std::size_t i, const Ray& ray) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      origin[axis][i] = ray.origin[static_cast<int>(axis)];
      direction[axis][i] = ray.direction[static_cast<int>(axis)];
    }
    t_min[i] = ray.t_min, t_max[i] = ray.t_max, start_side[i] = ray.start_side;
  }

  std::size_t count = 0;  ///< number of rays to trace
  LaneArray<double> origin[3], direction[3], t_min, t_max;
  bool has_start_sides = false;  ///< false: all start sides are unknown, whatever the array holds
  LaneArray<StartSide> start_side;
};

/// One answer for each ray of a batch.
class HitBatch {
 public:
  HitBatch() = default;
  explicit HitBatch(std::size_t capacity) {
    capacity = RayBatch::whole_groups(capacity);
    t = LaneArray<double>(capacity), value = LaneArray<double>(capacity), error = LaneArray<double>(capacity);
    for (auto& component : gradient) component = LaneArray<double>(capacity);
    cell = LaneArray<std::uint64_t>(capacity);
    for (auto* numbers : {&tet, &root_count, &iteration_count, &cost}) *numbers = LaneArray<std::uint32_t>(capacity);
  }

  Hit operator[](std::size_t i) const {
    return {.t = t[i],
            .value = value[i],
            .cell = cell[i],
            .tet = tet[i],
            .gradient = {gradient[0][i], gradient[1][i], gradient[2][i]},
            .error = error[i],
            .root_count = root_count[i],
            .iteration_count = iteration_count[i],
            .cost = cost[i]};
  }
  void set(std::size_t i, const Hit& hit) {
    t[i] = hit.t, value[i] = hit.value, error[i] = hit.error, cell[i] = hit.cell, tet[i] = hit.tet;
    for (std::size_t axis = 0; axis < 3; ++axis) gradient[axis][i] = hit.gradient[static_cast<int>(axis)];
    root_count[i] = hit.root_count, iteration_count[i] = hit.iteration_count, cost[i] = hit.cost;
  }

  LaneArray<double> t, value, error, gradient[3];
  LaneArray<std::uint64_t> cell;
  LaneArray<std::uint32_t> tet, root_count, iteration_count, cost;
};

}  // namespace rhoray::render
