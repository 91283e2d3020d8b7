#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/text.h"
#include "tools/validate/compare.h"
#include "tools/validate/grid_judge.h"
#include "tools/validate/grid_surface.h"
#include "tools/validate/triangle_tree.h"

namespace rhoray::tools::validate {

namespace {

// Roundings move the value by up to about 1e-12 of the range of a cell's corners; where it changes by less than 1e-3 of
// that range in a cell's length, the ray grazes the surface; elsewhere that makes an error in depth of 1e-9 cells.
constexpr double rounding_residual = 1e-12;
constexpr double grazing_slope = 1e-3;
constexpr double default_depth_limit = rounding_residual / grazing_slope;
constexpr double another_crossing = 1e-6;  // of a cell: far beyond what roundings do to one
constexpr double undecided_limit = 0.1;    // of all rays
constexpr double probe_step = 0.25;        // of a cell
constexpr double normal_limit_deg = 1e-4;
constexpr std::size_t most_edge_points = 400'000;

/// A mesh to suit the number of rays: CGAL's mesher takes far longer for a triangle than a ray takes.
double facets_for(std::uint64_t samples) {
  return std::clamp(0.4 * static_cast<double>(samples), 2'000.0, 40'000.0);
}

class Comparer {
 public:
  Comparer(const GridField& field, const Affine& world_from_frame, const Question& question)
      : field_(field),
        world_from_frame_(world_from_frame),
        box_(field.box_frame()),
        diagonal_(world_from_frame.vector(box_.size()).length()),
        depth_limit_(question.max_depth_error > 0 ? question.max_depth_error : default_depth_limit),
        judge_(field, question.isovalue),
        edge_points_(edge_points(field, question.isovalue, most_edge_points, question.seed)),
        surface_(mesh_surface(field, question.isovalue, edge_points_, {.facet_count = facets_for(question.samples)})),
        tree_(surface_.triangles),
        surface_error_(quantiles_of(surface_.offsets)) {}

  const GridSurface& surface() const { return surface_; }
  const EdgePoints& edges() const { return edge_points_; }
  const Quantiles& surface_error() const { return surface_error_; }
  const GridJudge& judge() const { return judge_; }
  const Box3& box() const { return box_; }
  double depth_limit() const { return depth_limit_; }

  /// The length of the ray's direction in cells, where the ray is at t.
  double cells_per_t(const render::Ray& ray, double t) const { return field_.in_cells(ray.direction, ray.at(t)); }

  /// The length of a vector in diagonals of the data's box.
  double in_box(const Vec3& v_frame) const { return world_from_frame_.vector(v_frame).length() / diagonal_; }

  Finding find(const render::Ray& ray, const render::Hit& hit) const {
    Finding finding;
    const std::optional<Interval<double>> inside = inside_box(ray);
    if (!inside) {
      finding.verdict = hit.is_miss() ? Verdict::right : Verdict::false_hit;
      return finding;
    }
    const double per_t = cells_per_t(ray, hit.is_miss() ? inside->lo : hit.t);
    if (!hit.is_miss()) prove(ray, hit, per_t, finding);
    // What the tracer must not have passed over, up to where it says the surface is.
    const double end = hit.is_miss() ? inside->hi : std::min(inside->hi, hit.t - allowed(hit, per_t) / per_t);
    if (const auto passed = passed_over(ray, *inside, end, hit, finding)) {
      finding.verdict = hit.is_miss() ? Verdict::missed : Verdict::elsewhere;
      finding.is_hit = true;
      finding.t_reference = *passed;
    }
    return finding;
  }

 private:
  std::optional<Interval<double>> inside_box(const render::Ray& ray) const {
    Interval<double> t{0, std::numeric_limits<double>::infinity()};
    for (int axis = 0; axis < 3; ++axis) {
      const double low = (box_.min[axis] - ray.origin[axis]) / ray.direction[axis];
      const double high = (box_.max[axis] - ray.origin[axis]) / ray.direction[axis];
      if (ray.direction[axis] == 0) {
        if (ray.origin[axis] < box_.min[axis] || ray.origin[axis] > box_.max[axis]) return std::nullopt;
        continue;
      }
      t.lo = std::max(t.lo, std::min(low, high));
      t.hi = std::min(t.hi, std::max(low, high));
    }
    if (!(t.lo <= t.hi)) return std::nullopt;
    return t;
  }

  /// The depth error, in cells, that a hit may have: what it states itself, and what roundings make of the comparison.
  double allowed(const render::Hit& hit, double per_t) const {
    return depth_limit_ + (std::isnan(hit.error) ? 0 : hit.error * per_t);
  }

  /// Looks for the crossing that the tracer has reported, and measures.
  void prove(const render::Ray& ray, const render::Hit& hit, double per_t, Finding& finding) const {
    const double finest = std::max(4e-16 * std::abs(hit.t), 1e-15 / per_t);
    const std::optional<double> t = judge_.crossing_near(ray, hit.t, finest, 0.5 / per_t);
    finding.is_hit = t.has_value();
    finding.bound_cells = hit.error * per_t;
    finding.bound_box = hit.error * in_box(ray.direction);
    const Vec3 p = ray.at(hit.t);
    measure_distance(p, hit, finding);
    measure_normal(p, hit, finding);
    const std::optional<Index3> cell = field_.cell_of_id(hit.cell);
    const auto residual = cell ? judge_.residual(ray, hit.t, *cell) : std::nullopt;
    const bool is_level = residual && *residual <= rounding_residual;
    if (t) {
      finding.t_reference = *t;
      finding.depth_cells = std::abs(*t - hit.t) * per_t;
      finding.depth_box = std::abs(*t - hit.t) * in_box(ray.direction);
      // A level point that is not the crossing found: the field meets the isovalue there and turns back.
      const bool only_touches = is_level && finding.depth_cells > another_crossing;
      const bool grazes = only_touches || (is_level && slope(ray, hit, *cell) <= grazing_slope);
      finding.verdict = finding.depth_cells <= allowed(hit, per_t) ? Verdict::right
                        : grazes                                   ? Verdict::grazes
                                                                   : Verdict::elsewhere;
    } else {
      finding.verdict = is_level ? Verdict::grazes : Verdict::false_hit;
    }
    if (finding.verdict == Verdict::grazes) finding.depth_cells = finding.depth_box = not_measured;
  }

  /// How much the field changes along the ray in one cell's length, as a share of the range of the cell's corners.
  double slope(const render::Ray& ray, const render::Hit& hit, const Index3& at) const {
    const GridField::Cell cell = field_.cell(at);
    const Vec3 direction = (ray.direction / field_.widths(at)).normalized();
    const Vec3 local = field_.index_from_frame(ray.at(hit.t)) - to_vec3(at);
    return std::abs(cell.gradient(local).dot(direction)) / cell.range();
  }

  void measure_distance(const Vec3& p, const render::Hit& hit, Finding& finding) const {
    if (tree_.is_empty()) return;
    const Vec3 nearest = tree_.nearest(p);
    finding.distance_cells = (field_.index_from_frame(p) - field_.index_from_frame(nearest)).length();
    finding.distance_box = in_box(p - nearest);
    finding.is_above = (p - nearest).dot(hit.gradient) > 0;
  }

  void measure_normal(const Vec3& p, const render::Hit& hit, Finding& finding) const {
    const std::optional<Index3> at = field_.cell_of_id(hit.cell);
    if (!at) return;
    const Vec3 local = field_.index_from_frame(p) - to_vec3(*at);
    const Vec3 gradient = field_.cell(*at).gradient(local) / field_.widths(*at);
    const bool has_angle = gradient.length() > 0 && hit.gradient.length() > 0;
    if (has_angle)
      finding.normal_deg =
          std::atan2(gradient.cross(hit.gradient).length(), gradient.dot(hit.gradient)) * 180 / std::numbers::pi;
  }

  /// A change of side that is proved and lies before `end`: looked for all along the ray, and closely where it meets
  /// the mesh.
  std::optional<double> passed_over(const render::Ray& ray, const Interval<double>& inside, double end,
                                    const render::Hit& hit, Finding& finding) const {
    if (const auto found = judge_.first_proved(ray, inside.lo, end, probe_step)) return found;
    const auto met = tree_.first_on(ray);
    if (!met || !(met->t < end) || met->t < inside.lo) return std::nullopt;
    const double error = std::isnan(surface_.offsets[met->triangle]) ? 1 : surface_.offsets[met->triangle];
    const double reach_cells = std::max(4 * error, 1e-9), reach = reach_cells / cells_per_t(ray, met->t);
    if (!hit.is_miss() && met->t > hit.t - reach) return std::nullopt;  // the same crossing, as far as the mesh tells
    finding.was_redecided = true;
    const auto found =
        judge_.first_proved(ray, std::max(inside.lo, met->t - reach), std::min(end, met->t + reach), reach_cells / 64);
    if (!found && finding.verdict == Verdict::right) finding.verdict = Verdict::undecided;
    return found;
  }

  const GridField& field_;
  Affine world_from_frame_;
  Box3 box_;
  double diagonal_, depth_limit_;
  GridJudge judge_;
  EdgePoints edge_points_;
  GridSurface surface_;
  TriangleTree tree_;
  Quantiles surface_error_;
};

void find_all(const Comparer& comparer, Shots& shots, const Thousandths& progress, std::uint64_t begin,
              std::uint64_t end) {
  for_each_shot(shots.rays.size(), progress, begin, end,
                [&](std::size_t r) { shots.findings[r] = comparer.find(shots.rays[r].ray, shots.hits[r]); });
}

/// Rays at samples of the surface from just before them, and how far before each began, in cells.
struct NearRays {
  std::vector<AimedRay> rays;
  std::vector<double> before;     ///< in t
  std::vector<double> own_error;  ///< of the sample: to the field's crossing along the ray, in cells
};

/// A ray at a point along the field's gradient, beginning so near that nothing comes between.
void add_near_ray(const Comparer& comparer, const GridField& field, const Vec3& target_index, bool from_above,
                  NearRays& near) {
  const auto at = field.cell_at(target_index);
  if (!at) return;
  const GridField::Cell cell = field.cell(*at);
  if (!cell.has_data()) return;
  const Vec3 gradient = cell.gradient(target_index - to_vec3(*at)) / field.widths(*at);
  if (!(gradient.length() > 0)) return;
  const Vec3 direction = (from_above ? -1.0 : 1.0) * gradient.normalized();
  const Vec3 target = field.frame_from_index(target_index);
  const double per_t = field.in_cells(direction, target);
  for (const double cells : {0.25, 0.05, 0.01, 0.002}) {
    const double before = cells / per_t;
    const render::Ray ray{target - before * direction, direction};
    const auto begin = comparer.judge().is_inside(ray, 0), end = comparer.judge().is_inside(ray, 2 * before);
    if (!begin || !end || *begin == *end) continue;
    if (comparer.judge().first_proved(ray, 0, 0.9 * before, cells / 16)) continue;
    const auto crossing = comparer.judge().crossing_near(ray, before, 1e-15 / per_t, before);
    if (!crossing) continue;
    near.rays.push_back({ray, Aim::near});
    near.before.push_back(before);
    near.own_error.push_back(std::abs(*crossing - before) * per_t);
    return;
  }
}

/// In turn: corners and centres of the mesh's triangles, and points on edges of the grid, which lie on the surface.
NearRays near_rays(const Comparer& comparer, const GridField& field, std::size_t count, RayMaker& maker) {
  const Triangles& triangles = comparer.surface().triangles;
  const std::vector<Vec3>& edges = comparer.edges().points_index;
  NearRays near;
  if (triangles.corners.empty() || edges.empty()) return near;
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t triangle = maker.below(triangles.corners.size());
    const Vec3 target = s % 3 == 0   ? edges[maker.below(edges.size())]
                        : s % 3 == 1 ? field.index_from_frame(triangles.corner(triangle, maker.below(3)))
                                     : field.index_from_frame(triangles.center(triangle));
    add_near_ray(comparer, field, target, s % 2 == 0, near);
  }
  return near;
}

/// How far from each sample the tracer found the surface, along the ray.
struct DistancesAlong {
  std::vector<double> cells, box;
};
DistancesAlong distances_along(const Comparer& comparer, const NearRays& near, const Shots& shots) {
  DistancesAlong distances;
  for (std::size_t r = 0; r < near.rays.size(); ++r) {
    const render::Ray& ray = near.rays[r].ray;
    const render::Hit& hit = shots.hits[r];
    if (hit.is_miss()) continue;
    const double t = std::abs(hit.t - near.before[r]);
    distances.cells.push_back(t * comparer.cells_per_t(ray, near.before[r]));
    distances.box.push_back(t * comparer.in_box(ray.direction));
  }
  return distances;
}

void add_measures(const Comparer& comparer, const Shots& far, const Shots& close, const NearRays& near,
                  Report& report) {
  const auto add = [&](const char* name, const char* unit, std::vector<double> values) {
    report.measures.push_back({name, unit, quantiles_of(std::move(values))});
  };
  report.measures.push_back(measure("depth", "cells", far, &Finding::depth_cells));
  report.measures.push_back(measure("depth", "box", far, &Finding::depth_box));
  add_bounds(far, report);
  report.measures.push_back(measure("depth, near rays", "cells", close, &Finding::depth_cells));
  report.measures.push_back(measure("renderer to surface", "cells", far, &Finding::distance_cells));
  report.measures.push_back(measure("renderer to surface", "box", far, &Finding::distance_box));
  const DistancesAlong along = distances_along(comparer, near, close);
  add("surface to renderer", "cells", along.cells);
  add("surface to renderer", "box", along.box);
  add("surface's own error", "cells", near.own_error);
  report.measures.push_back({"mesh to field", "cells", comparer.surface_error()});
  report.measures.push_back(measure("normal", "degrees", far, &Finding::normal_deg));
}

void add_checks(const Comparer& comparer, Report& report) {
  const RayCounts all = report.total();
  const double depth_limit = comparer.depth_limit() + report.largest_bound("cells");
  const char* proved = "only what points of the ray on different sides prove is counted";
  report.checks = {
      {"missed", static_cast<double>(all.missed), 0, proved},
      {"false", static_cast<double>(all.false_hits), 0, "every hit must be proved by points on different sides"},
      {"elsewhere", static_cast<double>(all.elsewhere), 0, proved},
      {"largest depth error, cells", report.largest("depth", "cells"), depth_limit,
       "what roundings make of rays that do not graze the surface, and a bound that the method states"},
      {"largest depth error of near rays, cells", report.largest("depth, near rays", "cells"), depth_limit, "as above"},
      {"undecided, share of rays", static_cast<double>(all.undecided) / static_cast<double>(all.rays), undecided_limit,
       "with more the mesh would not show this surface"},
      {"largest normal error, degrees", report.largest("normal", "degrees"), normal_limit_deg,
       "the gradient of one cell in double precision, with room for where it is small"}};
}

void add_notes(const Comparer& comparer, const Shots& far, Report& report) {
  const GridSurface& surface = comparer.surface();
  const auto away = std::count_if(far.findings.begin(), far.findings.end(), [&](const Finding& finding) {
    return finding.distance_cells > std::max(1.0, surface.triangle_radius);
  });
  if (away > 0)
    report.notes.push_back(concat(
        away,
        " hits lie on parts of the surface that the mesh does not show; the field was asked about them all the same"));
  report.notes.push_back(concat("the mesh's triangles have a radius of about ",
                                std::round(100 * surface.triangle_radius) / 100,
                                " cells; parts of the surface that are smaller may not be in it"));
  if (!surface.is_complete)
    report.notes.push_back("the mesher was stopped before all its triangles were as small as wished");
}

}  // namespace

Comparison compare_grid(const GridField& field, const Affine& world_from_frame, const Question& question,
                        const Tracer& tracer, const Thousandths& progress) {
  const Comparer comparer(field, world_from_frame, question);
  progress(300);
  RayMaker maker(world_from_frame, comparer.box(), question.seed);
  Shots far = shoot(tracer, make_rays(maker, comparer.box(), comparer.surface().triangles, question.samples));
  find_all(comparer, far, progress, 300, 700);
  NearRays near = near_rays(comparer, field, question.samples / 4, maker);
  Shots close = shoot(tracer, near.rays);
  find_all(comparer, close, progress, 750, 850);
  Comparison comparison;
  std::vector<AimedRay> camera;
  for (const render::Ray& ray : question.camera_rays) camera.push_back({ray, Aim::camera});
  comparison.picture = shoot(tracer, std::move(camera));
  find_all(comparer, comparison.picture, progress, 850, 1000);

  Report& report = comparison.report;
  report.reference =
      "the trilinear field itself, decided exactly, and the isosurface that CGAL's surface mesher finds in it";
  report.straddling_cells = comparer.edges().cell_count;
  report.triangles = comparer.surface().triangles.corners.size();
  count(far, report);
  count(close, report);
  count(comparison.picture, report);
  add_measures(comparer, far, close, near, report);
  add_checks(comparer, report);
  add_notes(comparer, far, report);
  return comparison;
}

}  // namespace rhoray::tools::validate
