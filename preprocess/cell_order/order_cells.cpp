#include "preprocess/cell_order/order_cells.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "preprocess/cell_order/hilbert_curve.h"

namespace rhoray::preprocess {
namespace {

using Range = tbb::blocked_range<std::size_t>;
constexpr std::size_t grain = 4096;

struct Place {
  std::uint64_t on_curve;
  std::uint32_t cell;
};

/// Steps of the curve along an axis.
std::uint32_t step_at(double position, double low, double steps_per_length) {
  constexpr double last = 0x1p21 - 1;
  return static_cast<std::uint32_t>(std::clamp((position - low) * steps_per_length, 0.0, last));
}

Array<Place> places_of(const CleanMesh& mesh) {
  const Vec3 extent = mesh.box.max - mesh.box.min;
  const double steps_per_length = 0x1p21 / std::max({extent.x, extent.y, extent.z});
  Array<Place> places(mesh.cells.size());
  tbb::parallel_for(Range(0, places.size(), grain), [&](const Range& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      std::array<std::uint32_t, 3> steps;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& cell = mesh.cells[c];
        const auto at = [&](std::size_t v) { return 0.25 * mesh.points[cell[v]][axis]; };
        steps[axis] =
            step_at((at(0) + at(1)) + (at(2) + at(3)), mesh.box.min[static_cast<int>(axis)], steps_per_length);
      }
      places[c] = {hilbert_position(steps[0], steps[1], steps[2]), static_cast<std::uint32_t>(c)};
    }
  });
  return places;
}

/// By place on the curve, equal ones as they stand: digit after digit, the last one first.
void sort_along_curve(Array<Place>& places) {
  constexpr int digit_bits = 11, digit_count = 6;
  constexpr std::size_t values = std::size_t{1} << digit_bits;
  const auto digit = [](const Place& place, int d) {
    return static_cast<std::size_t>(place.on_curve >> (d * digit_bits)) % values;
  };
  std::array<std::array<std::size_t, values>, digit_count> ends{};
  for (const Place& place : places)
    for (int d = 0; d < digit_count; ++d) ++ends[static_cast<std::size_t>(d)][digit(place, d)];
  Array<Place> sorted(places.size());
  for (int d = 0; d < digit_count; ++d) {
    auto& starts = ends[static_cast<std::size_t>(d)];
    if (starts[digit(places.front(), d)] == places.size()) continue;  // the same everywhere
    std::size_t before = 0;
    for (std::size_t& count : starts) before += std::exchange(count, before);
    for (const Place& place : places) sorted[starts[digit(place, d)]++] = place;
    std::swap(places, sorted);
  }
}

/// values[i] becomes the one that stood at from(i).
template <class T, class From>
void reorder(Array<T>& values, const From& from) {
  Array<T> reordered(values.size());
  tbb::parallel_for(Range(0, values.size(), grain), [&](const Range& part) {
    for (std::size_t i = part.begin(); i < part.end(); ++i) reordered[i] = values[from(i)];
  });
  values = std::move(reordered);
}

/// Renumbers the points by first use; tells where each one stood.
Array<std::uint32_t> number_points(CleanMesh& mesh) {
  constexpr std::uint32_t unnamed = std::numeric_limits<std::uint32_t>::max();
  Array<std::uint32_t> number(mesh.points.size(), unnamed);
  Array<std::uint32_t> old_positions(mesh.points.size());
  std::uint32_t named = 0;
  for (auto& cell : mesh.cells)
    for (std::uint32_t& vertex : cell) {
      std::uint32_t& its_number = number[vertex];
      if (its_number == unnamed) {
        old_positions[named] = vertex;
        its_number = named++;
      }
      vertex = its_number;
    }
  return old_positions;
}

}  // namespace

Array<std::uint32_t> order_cells(CleanMesh& mesh) {
  {
    Array<Place> places = places_of(mesh);
    sort_along_curve(places);
    const auto from = [&](std::size_t cell) { return places[cell].cell; };
    reorder(mesh.cells, from);
    reorder(mesh.source_cells, from);
  }
  Array<std::uint32_t> ranks = number_points(mesh);
  const auto from = [&](std::size_t point) { return ranks[point]; };
  reorder(mesh.points, from);
  reorder(mesh.source_points, from);
  return ranks;
}

}  // namespace rhoray::preprocess
