#include "preprocess/mesh/subdivide/polyhedron.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "formats/base/error.h"

namespace rhoray::preprocess {
namespace {

Error refusal(const std::string& found, const std::string& expected) {
  return {ErrorCode::invalid, concat("found ", found, "; expected ", expected)};
}

/// Calls act(corners) for each face of a stream, after checking its counts.
template <class Act>
void for_each_face(std::span<const std::uint64_t> stream, Act&& act) {
  if (stream.empty()) throw refusal("a polyhedron without a face count", "the stream of its faces");
  std::size_t at = 1;
  for (std::uint64_t face = 0; face < stream[0]; ++face) {
    if (at == stream.size()) throw refusal(concat(face, " faces"), concat(stream[0], ", as the polyhedron says"));
    const std::uint64_t count = stream[at++];
    if (count < 3) throw refusal(concat("a face of ", count, " corners"), "at least 3");
    if (count > stream.size() - at)
      throw refusal(concat("a face of ", count, " corners where ", stream.size() - at, " numbers are left"),
                    "as many numbers as corners");
    act(stream.subspan(at, count));
    at += count;
  }
  if (at != stream.size()) throw refusal(concat(stream.size() - at, " numbers after the last face"), "none");
}

/// One side of a triangle, by the ids at its ends.
struct Side {
  std::uint64_t low, high;
  std::uint32_t triangle;
  bool rises;
  bool operator<(const Side& other) const {
    return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
  }
};

std::vector<Side> sides_of(const CutCell& cell) {
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < cell.boundary.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t a = cell.ids[cell.boundary[t][i]], b = cell.ids[cell.boundary[t][(i + 1) % 3]];
      sides.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Two triangles with a common side. They wind alike when they run along it in opposite directions.
struct Neighbours {
  std::uint32_t other;
  bool wind_alike;
};

/// A side where more than two triangles meet, as where a cell touches itself, is ignored.
std::vector<std::vector<Neighbours>> neighbours_of(const CutCell& cell) {
  const std::vector<Side> sides = sides_of(cell);
  std::vector<std::vector<Neighbours>> neighbours(cell.boundary.size());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
    if ((end - begin) % 2 != 0)
      throw refusal(concat("a polyhedron with ", end - begin, end - begin == 1 ? " face" : " faces", " at the edge ",
                           sides[begin].low, "-", sides[begin].high),
                    "two, as around a closed cell");
    if (end - begin != 2) continue;
    const Side &a = sides[begin], &b = sides[begin + 1];
    neighbours[a.triangle].push_back({b.triangle, a.rises != b.rises});
    neighbours[b.triangle].push_back({a.triangle, a.rises != b.rises});
  }
  return neighbours;
}

/// Reverses triangles until all that are connected by sides wind like the first of them.
void wind_alike(CutCell& cell) {
  const auto neighbours = neighbours_of(cell);
  enum class State { unseen, kept, turned };
  std::vector<State> states(cell.boundary.size(), State::unseen);
  std::vector<std::uint32_t> waiting;
  for (std::uint32_t first = 0; first < states.size(); ++first) {
    if (states[first] != State::unseen) continue;
    states[first] = State::kept;
    waiting.assign(1, first);
    while (!waiting.empty()) {
      const std::uint32_t triangle = waiting.back();
      waiting.pop_back();
      for (const Neighbours& next : neighbours[triangle]) {
        if (states[next.other] != State::unseen) continue;
        const bool same = (states[triangle] == State::kept) == next.wind_alike;
        states[next.other] = same ? State::kept : State::turned;
        waiting.push_back(next.other);
      }
    }
  }
  for (std::size_t t = 0; t < states.size(); ++t)
    if (states[t] == State::turned) std::swap(cell.boundary[t][1], cell.boundary[t][2]);
}

}  // namespace

void take_polyhedron(CutCell& cell, std::span<const std::uint64_t> face_stream,
                     std::span<const std::array<double, 3>> points) {
  cell.ids.clear();
  cell.places.clear();
  cell.boundary.clear();
  for_each_face(face_stream, [&](std::span<const std::uint64_t> face) {
    for (const std::uint64_t id : face)
      if (id >= points.size())
        throw refusal(concat("point ", static_cast<std::int64_t>(id)), concat("0 to ", points.size() - 1));
    cell.ids.insert(cell.ids.end(), face.begin(), face.end());
  });
  std::sort(cell.ids.begin(), cell.ids.end());
  cell.ids.erase(std::unique(cell.ids.begin(), cell.ids.end()), cell.ids.end());
  for (const std::uint64_t id : cell.ids) cell.places.push_back(points[id]);

  std::vector<std::uint32_t> corners;
  for_each_face(face_stream, [&](std::span<const std::uint64_t> face) {
    corners.clear();
    for (const std::uint64_t id : face)
      corners.push_back(
          static_cast<std::uint32_t>(std::lower_bound(cell.ids.begin(), cell.ids.end(), id) - cell.ids.begin()));
    add_face(cell, corners);
  });
  wind_alike(cell);
}

}  // namespace rhoray::preprocess
