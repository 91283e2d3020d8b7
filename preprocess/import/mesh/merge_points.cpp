#include "preprocess/import/mesh/merge_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "formats/base/checks.h"
#include "formats/base/text.h"

namespace rhoray::preprocess {
namespace {

using Point = std::array<double, 3>;

constexpr std::uint64_t none = ~std::uint64_t{0};

std::uint64_t hash_of(const Point& point) {
  std::uint64_t hash = 0;
  for (const double coordinate : point) {
    // -0 becomes 0
    hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate + 0.0)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 32;
  }
  return hash;
}

bool is_finite(const Point& point) {
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

/// For each point, the first one at the same position. A point that is not finite matches only
/// itself.
Array<std::uint64_t> first_at_place(const Array<Point>& points) {
  Array<std::uint64_t> first(points.size());
  Array<std::uint64_t> slots(std::bit_ceil(2 * points.size() + 1), none);  // at least half empty
  const std::uint64_t mask = slots.size() - 1;
  for (std::uint64_t i = 0; i < points.size(); ++i) {
    first[i] = i;
    if (!is_finite(points[i])) continue;
    std::uint64_t slot = hash_of(points[i]) & mask;
    while (slots[slot] != none && points[slots[slot]] != points[i]) slot = (slot + 1) & mask;
    if (slots[slot] == none) slots[slot] = i;
    first[i] = slots[slot];
  }
  return first;
}

bool has_same_values(const NeutralField& field, std::uint64_t a, std::uint64_t b) {
  const auto count = static_cast<std::size_t>(field.component_count);
  return std::memcmp(&field.values[a * count], &field.values[b * count], count * sizeof(double)) == 0;
}

/// How much a field differs between merged points.
struct Difference {
  std::uint64_t count = 0;
  double largest = 0;

  void include(const NeutralField& field, std::uint64_t a, std::uint64_t b) {
    if (has_same_values(field, a, b)) return;
    ++count;
    const auto components = static_cast<std::size_t>(field.component_count);
    for (std::size_t c = 0; c < components; ++c) {
      const double distance = std::abs(field.values[a * components + c] - field.values[b * components + c]);
      if (distance > largest || distance != distance) largest = distance;
    }
  }
};

class Merging {
 public:
  Merging(CellMesh& mesh, std::span<const std::uint64_t> piece_offsets)
      : mesh_(mesh),
        piece_offsets_(piece_offsets),
        first_(first_at_place(mesh.points)),
        next_here_(mesh.points.size(), none),
        differences_(mesh.point_fields.size()) {}

  void run() {
    find_crowded_places();
    decide();
    if (merged_count_ > 0) {
      renumber_cells();
      shorten();
    }
    tell();
  }

 private:
  template <class Act>
  void for_each_point(Act&& act) {
    for (std::uint64_t piece = 0; piece + 1 < piece_offsets_.size(); ++piece)
      for (std::uint64_t i = piece_offsets_[piece]; i < piece_offsets_[piece + 1]; ++i) act(i, piece);
  }

  /// Finds positions where one piece has several points: there, the values decide which points
  /// belong together.
  void find_crowded_places() {
    is_crowded_.assign(mesh_.points.size(), 0);
    Array<std::uint64_t> latest_piece(mesh_.points.size(), none);
    for_each_point([&](std::uint64_t i, std::uint64_t piece) {
      std::uint64_t& latest = latest_piece[first_[i]];
      if (latest == piece) is_crowded_[first_[i]] = 1;
      latest = piece;
    });
  }

  /// Sets `stands_for_`: for each point the one that replaces it, itself or an earlier one.
  void decide() {
    stands_for_.resize(mesh_.points.size());
    for_each_point([&](std::uint64_t i, std::uint64_t piece) {
      const std::uint64_t partner = is_crowded_[first_[i]] != 0 ? partner_at_crowded_place(i, piece) : first_[i];
      stands_for_[i] = partner;
      if (partner == i) return;
      ++merged_count_;
      for (std::size_t f = 0; f < differences_.size(); ++f) differences_[f].include(mesh_.point_fields[f], partner, i);
    });
  }

  /// The first point at this position that has equal values and no point of this piece yet;
  /// otherwise the point itself, which is then added to them.
  std::uint64_t partner_at_crowded_place(std::uint64_t i, std::uint64_t piece) {
    Place& place = places_[first_[i]];
    if (std::exchange(place.piece, piece) != piece) place.taken_count = 0;
    ++place.taken_count;
    const auto [found, is_new] = groups_.try_emplace(i, Group{.piece = piece, .next = none, .last = i});
    Group& group = found->second;
    if (std::exchange(group.piece, piece) != piece) group.next = found->first;
    if (group.next != none) return std::exchange(group.next, next_here_[group.next]);
    if (!is_new) next_here_[std::exchange(group.last, i)] = i;
    if (++place.kept_count > place.taken_count) ++left_apart_count_;
    return i;
  }

  /// Changes `stands_for_` to the new number of each point.
  void renumber_cells() {
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < stands_for_.size(); ++i)
      stands_for_[i] = stands_for_[i] == i ? next++ : stands_for_[stands_for_[i]];
    for (std::uint64_t cell = 0; cell < mesh_.kinds.size(); ++cell) {
      const auto nodes =
          std::span(mesh_.cell_nodes)
              .subspan(mesh_.cell_offsets[cell], mesh_.cell_offsets[cell + 1] - mesh_.cell_offsets[cell]);
      if (mesh_.kinds[cell] == CellKind::polyhedron)
        renumber_faces(nodes);
      else
        for (std::uint64_t& node : nodes) node = stands_for_[node];
    }
  }

  void renumber_faces(std::span<std::uint64_t> stream) {
    for (std::size_t at = 1; at < stream.size();) {
      const std::size_t end = at + 1 + stream[at];
      RHORAY_CHECK(end <= stream.size());
      for (++at; at < end; ++at) stream[at] = stands_for_[stream[at]];
    }
  }

  /// New numbers increase from one first point to the next, so each point moves down in place.
  void shorten() {
    std::uint64_t count = 0;
    for (std::uint64_t i = 0; i < stands_for_.size(); ++i) {
      if (stands_for_[i] != count) continue;
      mesh_.points[count] = mesh_.points[i];
      for (NeutralField& field : mesh_.point_fields) {
        const auto components = static_cast<std::size_t>(field.component_count);
        std::copy_n(field.values.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                    field.values.begin() + static_cast<std::ptrdiff_t>(count * components));
      }
      ++count;
    }
    mesh_.points.resize(count);
    for (NeutralField& field : mesh_.point_fields)
      field.values.resize(count * static_cast<std::size_t>(field.component_count));
  }

  void tell() {
    if (merged_count_ > 0)
      mesh_.notes.push_back(concat(count_text(merged_count_, "point", "points"),
                                   " merged with points at the same position in earlier pieces"));
    for (std::size_t f = 0; f < differences_.size(); ++f)
      if (differences_[f].count > 0)
        mesh_.notes.push_back(concat("field '", mesh_.point_fields[f].name, "' differs at ", differences_[f].count,
                                     " of the merged points, by up to ", differences_[f].largest,
                                     "; the first piece's values are kept"));
    if (left_apart_count_ > 0)
      mesh_.notes.push_back(concat(count_text(left_apart_count_, "point", "points"),
                                   " not merged with points at the same position in other pieces, because a piece has "
                                   "several there and their values differ"));
  }

  /// A position where a piece has several points.
  struct Place {
    std::uint64_t kept_count = 0;
    std::uint64_t piece = none;     ///< the latest piece with a point here
    std::uint64_t taken_count = 0;  ///< of the kept points, those that have a point of this piece
  };

  /// The kept points with the same position and values, a chain in next_here_. Its key is the first
  /// of them.
  struct Group {
    std::uint64_t piece = none;  ///< the latest piece with a point here
    std::uint64_t next = none;   ///< the first that has no point of this piece yet
    std::uint64_t last = none;
  };

  struct HashOfPoint {
    const Merging& merging;
    std::size_t operator()(std::uint64_t i) const {
      std::size_t hash = merging.first_[i];
      for (const NeutralField& field : merging.mesh_.point_fields) {
        const auto bytes = static_cast<std::size_t>(field.component_count) * sizeof(double);
        const auto* values = reinterpret_cast<const char*>(field.values.data()) + i * bytes;
        hash = hash * 0x9E3779B97F4A7C15U ^ std::hash<std::string_view>()({values, bytes});
      }
      return hash;
    }
  };
  struct SamePoint {
    const Merging& merging;
    bool operator()(std::uint64_t a, std::uint64_t b) const {
      const auto agrees = [&](const NeutralField& field) { return has_same_values(field, a, b); };
      return merging.first_[a] == merging.first_[b] &&
             std::all_of(merging.mesh_.point_fields.begin(), merging.mesh_.point_fields.end(), agrees);
    }
  };

  CellMesh& mesh_;
  std::span<const std::uint64_t> piece_offsets_;
  Array<std::uint64_t> first_;
  Array<std::uint64_t> next_here_;  ///< chains of points kept at crowded positions
  std::unordered_map<std::uint64_t, Place> places_;
  std::unordered_map<std::uint64_t, Group, HashOfPoint, SamePoint> groups_{0, HashOfPoint{*this}, SamePoint{*this}};
  Array<std::uint8_t> is_crowded_;  ///< set for the first point at a position
  Array<std::uint64_t> stands_for_;
  std::vector<Difference> differences_;
  std::uint64_t merged_count_ = 0, left_apart_count_ = 0;
};

}  // namespace

void merge_coincident_points(CellMesh& mesh, std::span<const std::uint64_t> piece_offsets) {
  RHORAY_CHECK(!piece_offsets.empty() && piece_offsets.front() == 0 && piece_offsets.back() == mesh.points.size());
  RHORAY_CHECK(std::is_sorted(piece_offsets.begin(), piece_offsets.end()));
  if (piece_offsets.size() > 2) Merging(mesh, piece_offsets).run();
}

}  // namespace rhoray::preprocess
