#include "preprocess/resample/leaf_parts.h"

#include <algorithm>

#include "preprocess/resample/faces.h"

namespace rhoray::preprocess {
namespace {

using Tetrahedron = std::array<Point, 4>;

constexpr auto edge = static_cast<std::size_t>(SampleLattice::brick_edge);

/// One side of a box: inside is where sign * (coordinate - place) >= 0.
struct Side {
  std::size_t axis;
  double sign, place;

  double height(const Point& p) const { return sign * (p[axis] - place); }
};

Point crossing(const Point& a, const Point& b, double height_a, double height_b, const Side& side) {
  const double t = height_a / (height_a - height_b);
  Point cut;
  for (std::size_t axis = 0; axis < 3; ++axis) cut[axis] = a[axis] + t * (b[axis] - a[axis]);
  cut[side.axis] = side.place;
  return cut;
}

/// Sums up what is left of a tetrahedron behind all six sides.
class Clipping {
 public:
  Clipping(const Point& low, const Point& high)
      : sides_{{{0, 1, low[0]}, {0, -1, high[0]}, {1, 1, low[1]}, {1, -1, high[1]}, {2, 1, low[2]}, {2, -1, high[2]}}} {
  }

  void clip(const Tetrahedron& t, std::size_t first_side) {
    for (std::size_t s = first_side; s < sides_.size(); ++s) {
      const Side& side = sides_[s];
      std::array<double, 4> height;
      std::array<std::size_t, 4> order;  // corners inside first
      std::size_t inside = 0, outside = 4;
      for (std::size_t v = 0; v < 4; ++v) {
        height[v] = side.height(t[v]);
        if (height[v] >= 0)
          order[inside++] = v;
        else
          order[--outside] = v;
      }
      if (inside == 0) return;
      if (inside == 4) continue;
      const auto at = [&](std::size_t n) { return t[order[n]]; };
      const auto cut = [&](std::size_t a, std::size_t b) {
        return crossing(t[order[a]], t[order[b]], height[order[a]], height[order[b]], side);
      };
      if (inside == 1) return clip({at(0), cut(0, 1), cut(0, 2), cut(0, 3)}, s + 1);
      if (inside == 2) return clip_prism({at(0), cut(0, 2), cut(0, 3)}, {at(1), cut(1, 2), cut(1, 3)}, s + 1);
      return clip_prism({cut(0, 3), cut(1, 3), cut(2, 3)}, {at(0), at(1), at(2)}, s + 1);
    }
    add(t);
  }

  ClippedVolume result() const {
    ClippedVolume sum{.volume = volume_};
    for (std::size_t a = 0; a < 3 && volume_ > 0; ++a) sum.center[a] = moment_[a] / volume_;
    return sum;
  }

 private:
  /// Between two triangles; corner n of one is joined with corner n of the other.
  void clip_prism(const std::array<Point, 3>& p, const std::array<Point, 3>& q, std::size_t side) {
    clip({p[0], q[0], q[1], q[2]}, side);
    clip({p[0], p[1], q[1], q[2]}, side);
    clip({p[0], p[1], p[2], q[2]}, side);
  }

  void add(const Tetrahedron& t) {
    const double volume = std::abs(dot(cross(minus(t[1], t[0]), minus(t[2], t[0])), minus(t[3], t[0]))) / 6;
    volume_ += volume;
    for (std::size_t a = 0; a < 3; ++a) moment_[a] += volume * 0.25 * ((t[0][a] + t[1][a]) + (t[2][a] + t[3][a]));
  }

  std::array<Side, 6> sides_;
  double volume_ = 0;
  Point moment_{};
};

/// The half spaces of a tetrahedron, which tell most boxes apart from it. Nothing depends on their rounding but time.
class HalfSpaces {
 public:
  explicit HalfSpaces(const Tetrahedron& t) {
    for (std::size_t f = 0; f < 4; ++f) {
      const Point& a = t[face_vertices[f][0]];
      normals_[f] = cross(minus(t[face_vertices[f][2]], a), minus(t[face_vertices[f][1]], a));  // inward
      const double size = sum_of_magnitudes(normals_[f]);
      offsets_[f] = dot(normals_[f], a) - size * (0.5 + 1e-9 * (16 + sum_of_magnitudes(a)));
    }
  }

  /// True only when the box of edge 1 around the centre has no part of the tetrahedron.
  bool are_clear_of(const Point& center) const {
    for (std::size_t f = 0; f < 4; ++f)
      if (dot(normals_[f], center) < offsets_[f]) return true;
    return false;
  }

 private:
  std::array<Point, 4> normals_;
  std::array<double, 4> offsets_;
};

}  // namespace

ClippedVolume clip_to_box(const Tetrahedron& tetrahedron, const Point& low, const Point& high) {
  Clipping clipping(low, high);
  clipping.clip(tetrahedron, 0);
  return clipping.result();
}

const std::vector<LeafParts::Part>& LeafParts::find(const Point& first, std::span<const std::uint32_t> cells,
                                                    const Leaves& leaves, double margin) {
  parts_.clear();
  if (leaves.none()) return parts_;
  for (const std::uint32_t cell : cells) {
    Tetrahedron corners;
    for (std::size_t v = 0; v < 4; ++v) corners[v] = minus(steps_[mesh_.cells[cell][v]], first);
    add_parts_of(cell, corners, leaves, margin);
  }
  return parts_;
}

void LeafParts::add_parts_of(std::uint32_t cell, const Tetrahedron& corners, const Leaves& leaves, double margin) {
  std::array<std::size_t, 3> begin, end;
  for (std::size_t a = 0; a < 3; ++a) {
    const double lo = smaller(smaller(corners[0][a], corners[1][a]), smaller(corners[2][a], corners[3][a]));
    const double hi = larger(larger(corners[0][a], corners[1][a]), larger(corners[2][a], corners[3][a]));
    if (!(hi > 0 && lo < static_cast<double>(edge))) return;
    begin[a] = static_cast<std::size_t>(larger(lo, 0.0));
    end[a] = static_cast<std::size_t>(smaller(hi, static_cast<double>(edge) - 0.5)) + 1;
  }
  const auto any_wanted = [&] {
    for (std::size_t k = begin[2]; k < end[2]; ++k)
      for (std::size_t j = begin[1]; j < end[1]; ++j)
        for (std::size_t i = begin[0]; i < end[0]; ++i)
          if (leaves[(k * edge + j) * edge + i]) return true;
    return false;
  };
  if (!any_wanted()) return;
  const HalfSpaces half_spaces(corners);
  for (std::size_t k = begin[2]; k < end[2]; ++k)
    for (std::size_t j = begin[1]; j < end[1]; ++j)
      for (std::size_t i = begin[0]; i < end[0]; ++i) {
        const std::size_t leaf = (k * edge + j) * edge + i;
        if (!leaves[leaf]) continue;
        const Point low{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
        if (half_spaces.are_clear_of({low[0] + 0.5, low[1] + 0.5, low[2] + 0.5})) continue;
        const ClippedVolume part = clip_to_box(corners, {low[0] + margin, low[1] + margin, low[2] + margin},
                                               {low[0] + 1 - margin, low[1] + 1 - margin, low[2] + 1 - margin});
        if (part.volume > 0) parts_.push_back({cell, static_cast<std::uint32_t>(leaf), part.volume, part.center});
      }
}

}  // namespace rhoray::preprocess
