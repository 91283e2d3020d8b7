#include "preprocess/grid/resample/leaf_parts.h"

#include <algorithm>

#include "preprocess/grid/resample/faces.h"
#include "preprocess/grid/resample/trilinear_patch.h"

namespace rhoray::preprocess {
namespace {

using Tetrahedron = std::array<Point, 4>;

constexpr auto edge = static_cast<std::size_t>(SampleLattice::brick_edge);

/// Sums the volume behind a surface and its moments, by the divergence theorem along x. Only the
/// surface's projection to the yz plane counts. Of the unit cube's sides, only x = 1 contributes.
class Moments {
 public:
  /// Adds a triangle, counter-clockwise seen from outside.
  void add(const Point& a, const Point& b, const Point& c) {
    const double area_yz = 0.5 * ((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]));
    const auto mean_of_product = [&](std::size_t f, std::size_t g) {
      return (a[f] * a[g] + b[f] * b[g] + c[f] * c[g] + (a[f] + b[f] + c[f]) * (a[g] + b[g] + c[g])) / 12;
    };
    volume_ += area_yz * (a[0] + b[0] + c[0]) / 3;
    moment_[0] += 0.5 * area_yz * mean_of_product(0, 0);
    moment_[1] += area_yz * mean_of_product(0, 1);
    moment_[2] += area_yz * mean_of_product(0, 2);
  }

  /// Adds the part of a triangle in the unit cube.
  void add_clipped(const Point& a, const Point& b, const Point& c) {
    const ClippedTriangle part({PatchPoint{a, 0}, PatchPoint{b, 0}, PatchPoint{c, 0}});
    for (std::size_t n = 2; n < part.size(); ++n) add(part[0].at, part[n - 1].at, part[n].at);
  }

  ClippedVolume result() const {
    constexpr double rounding = 1e-13;
    if (!(volume_ > rounding)) return {};
    ClippedVolume part{.volume = volume_};
    for (std::size_t a = 0; a < 3; ++a) part.center[a] = std::clamp(moment_[a] / volume_, 0.0, 1.0);
    return part;
  }

 private:
  double volume_ = 0;
  Point moment_{};
};

Point at_x1(const Point& a, const Point& b) {
  const double t = (1 - a[0]) / (b[0] - a[0]);
  return {1, a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

/// Adds the intersection of a tetrahedron with the plane x = 1, where it is clipped: a triangle or
/// a quadrilateral.
void add_cut(const Tetrahedron& t, Moments& moments) {
  std::array<std::size_t, 4> order;  // corners that are kept first
  std::size_t kept = 0, beyond = 4;
  for (std::size_t v = 0; v < 4; ++v) order[t[v][0] <= 1 ? kept++ : --beyond] = v;
  if (kept == 0 || kept == 4) return;
  const auto cut = [&](std::size_t a, std::size_t b) { return at_x1(t[order[a]], t[order[b]]); };
  const auto add = [&](const Point& a, const Point& b, const Point& c) {
    const double area_yz = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
    if (area_yz > 0)
      moments.add_clipped(a, b, c);
    else
      moments.add_clipped(a, c, b);
  };
  if (kept == 1) return add(cut(0, 1), cut(0, 2), cut(0, 3));
  if (kept == 3) return add(cut(0, 3), cut(1, 3), cut(2, 3));
  // in order around the quadrilateral
  const Point p = cut(0, 2), q = cut(0, 3), r = cut(1, 3), s = cut(1, 2);
  add(p, q, r);
  add(p, r, s);
}

/// The half spaces of a tetrahedron, which separate it from most boxes. Their rounding affects only
/// the running time.
class HalfSpaces {
 public:
  explicit HalfSpaces(const Tetrahedron& t) {
    for (std::size_t f = 0; f < 4; ++f) {
      const Point& a = t[face_vertices[f][0]];
      // inward
      normals_[f] = cross(minus(t[face_vertices[f][2]], a), minus(t[face_vertices[f][1]], a));
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
  Tetrahedron t;  // in the box's local coordinates, 0 to 1
  bool is_inside = true;
  for (std::size_t v = 0; v < 4; ++v)
    for (std::size_t a = 0; a < 3; ++a) {
      t[v][a] = (tetrahedron[v][a] - low[a]) / (high[a] - low[a]);
      is_inside = is_inside && t[v][a] >= 0 && t[v][a] <= 1;
    }
  ClippedVolume part;
  if (is_inside) {
    part.volume = std::abs(dot(cross(minus(t[1], t[0]), minus(t[2], t[0])), minus(t[3], t[0]))) / 6;
    for (std::size_t a = 0; a < 3; ++a) part.center[a] = 0.25 * ((t[0][a] + t[1][a]) + (t[2][a] + t[3][a]));
  } else {
    Moments moments;
    for (const auto& face : face_vertices) moments.add_clipped(t[face[0]], t[face[1]], t[face[2]]);
    add_cut(t, moments);
    part = moments.result();
  }
  for (std::size_t a = 0; a < 3; ++a) {
    part.volume *= high[a] - low[a];
    part.center[a] = low[a] + part.center[a] * (high[a] - low[a]);
  }
  return part;
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
