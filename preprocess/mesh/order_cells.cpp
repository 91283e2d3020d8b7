#include "preprocess/mesh/order_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "formats/base/parallel.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t grain = 4096;

/// A cell and its centre. The centre is in units of the longest edge of the mesh's box, to 2^-24 of
/// it; the order needs no more precision.
struct Place {
  std::array<float, 3> center;
  std::uint32_t cell;
};

Array<Place> places_of(const CleanMesh& mesh) {
  const Vec3 extent = mesh.box.max - mesh.box.min;
  const double longest = std::max({extent.x, extent.y, extent.z}), scale = longest > 0 ? 0.25 / longest : 0;
  Array<Place> places(mesh.cells.size());
  parallel_for(places.size(), grain, [&](const IndexRange& part) {
    for (std::size_t c = part.begin(); c < part.end(); ++c) {
      const auto& cell = mesh.cells[c];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = [&](std::size_t v) {
          return (mesh.points[cell[v]][axis] - mesh.box.min[static_cast<int>(axis)]) * scale;
        };
        places[c].center[axis] = static_cast<float>((at(0) + at(1)) + (at(2) + at(3)));
      }
      places[c].cell = static_cast<std::uint32_t>(c);
    }
  });
  return places;
}

/// Returns the axis along which the centres extend farthest, or nothing where all are equal.
std::optional<std::size_t> longest_axis(std::span<const Place> places) {
  std::array<float, 3> lo = places.front().center, hi = lo;
  for (const Place& place : places)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], place.center[axis]);
      hi[axis] = std::max(hi[axis], place.center[axis]);
    }
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < 3; ++axis)
    if (hi[axis] - lo[axis] > hi[longest] - lo[longest]) longest = axis;
  if (!(hi[longest] > lo[longest])) return std::nullopt;
  return longest;
}

/// Rank along an axis; equal centres are ranked by cell, so no two ranks are equal.
std::uint64_t rank_of(const Place& place, std::size_t axis) {
  // Numbers of one sign have the order of their bits.
  return std::uint64_t{std::bit_cast<std::uint32_t>(place.center[axis])} << 32 | place.cell;
}

/// Moves the first `count` entries along an axis before the others, as std::nth_element does. It is
/// three times as fast, because entries move without a branch on the comparison.
void put_first(std::span<Place> places, std::size_t count, std::size_t axis) {
  // When pivots divide badly this many times, std::nth_element's guarantee is needed.
  for (auto rounds = 2 * std::bit_width(places.size()); rounds > 0 && places.size() > 16; --rounds) {
    const std::size_t last = places.size() - 1;
    std::array<std::size_t, 3> sample{0, last / 2, last};
    std::sort(sample.begin(), sample.end(),
              [&](std::size_t a, std::size_t b) { return rank_of(places[a], axis) < rank_of(places[b], axis); });
    std::swap(places[sample[1]], places[last]);
    const std::uint64_t pivot = rank_of(places[last], axis);
    std::size_t before = 0;
    for (std::size_t i = 0; i < last; ++i) {
      const Place place = places[i];
      places[i] = places[before];
      places[before] = place;
      before += rank_of(place, axis) < pivot;
    }
    std::swap(places[before], places[last]);
    if (before == count) return;
    if (before > count) {
      places = places.first(before);
    } else {
      places = places.subspan(before + 1);
      count -= before + 1;
    }
  }
  std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count), places.end(),
                   [&](const Place& a, const Place& b) { return rank_of(a, axis) < rank_of(b, axis); });
}

/// Halves the cells across their longest axis, recursively. The first part takes the largest power
/// of two below the count: blocks of any power of two that begin at its multiples are whole parts.
void halve(std::span<Place> places) {
  if (places.size() < 2) return;
  const std::optional<std::size_t> axis = longest_axis(places);
  if (!axis) {
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.cell < b.cell; });
    return;
  }
  const std::size_t half = std::bit_ceil(places.size()) / 2;
  put_first(places, half, *axis);
  const auto first = places.first(half), second = places.subspan(half);
  if (places.size() > grain)
    parallel_invoke([&] { halve(first); }, [&] { halve(second); });
  else
    halve(first), halve(second);
}

/// values[i] becomes the former values[from(i)].
template <class T, class From>
void reorder(Array<T>& values, const From& from) {
  Array<T> reordered(values.size());
  parallel_for(values.size(), grain, [&](const IndexRange& part) {
    for (std::size_t i = part.begin(); i < part.end(); ++i) reordered[i] = values[from(i)];
  });
  values = std::move(reordered);
}

/// Renumbers the points by first use; returns the former index of each.
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
    halve(places);
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
