#include "tools/validate/grid_surface.h"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh_default_criteria_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/assertions.h>
#include <CGAL/make_surface_mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>

namespace rhoray::tools::validate {

namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;
using Point = Traits::Point_3;
using Function = std::function<double(Point)>;
using Surface = CGAL::Implicit_surface_3<Traits, Function>;

struct OutOfEvaluations {};

/// The field, extended beyond the grid by its values at the border. So the surface continues beyond
/// the border and is not closed there by walls.
double extended(const GridField& field, double isovalue, double without_data, const Vec3& p_index) {
  Vec3 inside = p_index;
  for (int axis = 0; axis < 3; ++axis)
    inside[axis] = std::clamp(inside[axis], 0.0, static_cast<double>(field.sample_count()[axis] - 1));
  const auto value = field.value(inside);
  return value ? *value - isovalue : without_data;
}

Vec3 vec(const Point& p) {
  return {p.x(), p.y(), p.z()};
}

/// One seed from every block of cells that contains one.
std::vector<Point> spread(const std::vector<Vec3>& points, double block_edge) {
  std::set<std::array<std::int64_t, 3>> taken;
  std::vector<Point> chosen;
  for (const Vec3& p : points) {
    const auto block = [&](double x) { return static_cast<std::int64_t>(std::floor(x / block_edge)); };
    if (taken.insert({block(p.x), block(p.y), block(p.z)}).second) chosen.emplace_back(p.x, p.y, p.z);
  }
  return chosen;
}

/// Sorts vertices and triangles by their coordinates, not by memory address.
Triangles triangles_of(Complex& complex, const GridField& field) {
  std::map<std::array<double, 3>, std::uint32_t> numbers;
  const auto place_of = [](const Complex::Vertex_handle& vertex) {
    const Point& p = vertex->point();
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  for (auto vertex = complex.vertices_begin(); vertex != complex.vertices_end(); ++vertex)
    numbers.emplace(place_of(vertex), 0);
  Triangles out;
  for (auto& [place, number] : numbers) {
    number = static_cast<std::uint32_t>(out.points.size());
    out.points.emplace_back(place[0], place[1], place[2]);
  }
  for (auto facet = complex.facets_begin(); facet != complex.facets_end(); ++facet) {
    const auto& [cell, opposite] = *facet;
    std::array<std::uint32_t, 3> corners{};
    for (int c = 0; c < 3; ++c)
      corners[static_cast<std::size_t>(c)] =
          numbers.at(place_of(cell->vertex(Triangulation::vertex_triple_index(opposite, c))));
    const Vec3 center = (out.points[corners[0]] + out.points[corners[1]] + out.points[corners[2]]) / 3.0;
    std::sort(corners.begin(), corners.end());
    if (field.value(center)) out.corners.push_back(corners);
  }
  std::sort(out.corners.begin(), out.corners.end());
  return out;
}

double largest_offset(const GridField& field, double isovalue, const Triangles& triangles, std::size_t t) {
  const Vec3 center = triangles.center(t), normal = triangles.normal(t).normalized();
  double largest = 0;
  for (std::size_t place = 0; place < 4; ++place) {
    const Vec3 p = place == 0 ? center : (center + triangles.corner(t, place - 1)) / 2.0;
    const double offset = offset_along(field, isovalue, p, normal, 2);
    if (!(offset <= largest)) largest = offset;  // written so that a NaN stays
    if (std::isnan(largest)) break;
  }
  return largest;
}

}  // namespace

double offset_along(const GridField& field, double isovalue, const Vec3& p_index, const Vec3& direction,
                    double farthest) {
  const auto is_inside = [&](double s) -> std::optional<bool> {
    const auto value = field.value(p_index + s * direction);
    return value ? std::optional(*value >= isovalue) : std::nullopt;
  };
  const auto start = is_inside(0);
  if (!start) return std::nan("");
  double last = 0;
  for (double reach = 1e-12; reach <= farthest; reach = std::min(2 * reach, reach + 0.02)) {
    for (const double s : {reach, -reach}) {
      const auto side = is_inside(s);
      if (!side || *side == *start) continue;
      double near = std::copysign(last, s), far = s;
      for (int halving = 0; halving < 40; ++halving) {
        const double middle = (near + far) / 2;
        const auto there = is_inside(middle);
        (there && *there == *start ? near : far) = middle;
      }
      return std::abs(far);
    }
    last = reach;
  }
  return std::nan("");
}

EdgePoints edge_points(const GridField& field, double isovalue, std::size_t most, std::uint64_t seed) {
  EdgePoints found;
  std::mt19937_64 random(seed);
  const Index3 count = field.sample_count();
  const auto keep = [&](const Vec3& p) {  // reservoir sampling: each has the same probability
    ++found.edge_count;
    if (found.points_index.size() < most)
      found.points_index.push_back(p);
    else if (const std::uint64_t at = random() % found.edge_count; at < most)
      found.points_index[at] = p;
  };
  for (std::int64_t k = 0; k < count.z; ++k)
    for (std::int64_t j = 0; j < count.y; ++j)
      for (std::int64_t i = 0; i < count.x; ++i) {
        const double here = field.sample(i, j, k);
        if (!std::isfinite(here)) continue;
        const Index3 at(i, j, k);
        for (int axis = 0; axis < 3; ++axis) {
          Index3 next = at;
          if (++next[axis] == count[axis]) continue;
          const double there = field.sample(next.x, next.y, next.z);
          if (!std::isfinite(there) || (here >= isovalue) == (there >= isovalue)) continue;
          Vec3 p = to_vec3(at);
          p[axis] += (isovalue - here) / (there - here);
          keep(p);
        }
        if (i + 1 == count.x || j + 1 == count.y || k + 1 == count.z) continue;
        const GridField::Cell cell = field.cell(at);
        const auto [lo, hi] = std::minmax_element(cell.corner.begin(), cell.corner.end());
        found.cell_count += cell.has_data() && *lo < isovalue && *hi >= isovalue;
      }
  return found;
}

GridSurface mesh_surface(const GridField& field, double isovalue, const EdgePoints& seeds, const SurfaceSpec& spec) {
  GridSurface surface;
  if (seeds.points_index.empty()) return surface;
  // A plane of area A meets 1.5 A edges of the unit lattice on average; a triangle covers about the
  // square of its radius.
  const double area = static_cast<double>(seeds.edge_count) / 1.5;
  const double radius = std::sqrt(area / spec.facet_count) * 1.3;
  surface.triangle_radius = radius;

  const Vec3 size = to_vec3(field.sample_count() - Index3(1));
  const Vec3 middle = size / 2.0;
  const double bounding_radius = 1.1 * middle.length() + 1;
  // The mesher needs a negative value at the centre of its sphere.
  const double sign = extended(field, isovalue, 1, middle) < 0 ? 1 : -1;
  std::uint64_t evaluations = 0;
  const Function function = [&](const Point& p) {
    if (++evaluations > spec.most_evaluations) throw OutOfEvaluations{};
    const double value = sign * extended(field, isovalue, sign, vec(p));
    return value == 0 ? -1e-300 : value;
  };
  const Surface implicit(
      function, Traits::Sphere_3(Point(middle.x, middle.y, middle.z), bounding_radius * bounding_radius), 1e-9);
  CGAL::get_default_random() = CGAL::Random(1);  // otherwise it is seeded with the time
  Triangulation triangulation;
  Complex complex(triangulation);
  const std::vector<Point> start = spread(seeds.points_index, 2 * radius);
  triangulation.insert(start.begin(), start.end());
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(20, radius, 0.1 * radius);
  try {
    CGAL::make_surface_mesh(complex, implicit, criteria, CGAL::Non_manifold_tag(), 0);
  } catch (const OutOfEvaluations&) {
    surface.stopped_because = "it had evaluated the field as often as it may";
  } catch (const CGAL::Failure_exception&) {
    // Seen where all seeds lie in one plane.
    surface.stopped_because = "CGAL found an error of its own";
  }
  surface.triangles = triangles_of(complex, field);
  for (std::size_t t = 0; spec.measures_offsets && t < surface.triangles.corners.size(); ++t)
    surface.offsets.push_back(largest_offset(field, isovalue, surface.triangles, t));
  for (Vec3& p : surface.triangles.points) p = field.frame_from_index(p);
  return surface;
}

}  // namespace rhoray::tools::validate
