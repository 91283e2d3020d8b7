#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/text.h"
#include "tools/validate/compare.h"
#include "tools/validate/grid_reference.h"
#include "tools/validate/grid_surface.h"
#include "tools/validate/triangle_tree.h"

namespace rhoray::tools::validate {

namespace {

// Rounding changes the value by up to about 1e-12 of the range of a cell's corners. A ray grazes
// the surface where the value changes by less than 1e-3 of that range over a cell's length.
// Elsewhere rounding causes a depth error of 1e-9 cells.
constexpr double rounding_residual = 1e-12;
constexpr double grazing_slope = 1e-3;
constexpr double default_depth_limit = rounding_residual / grazing_slope;
constexpr double another_crossing = 1e-6;  // of a cell: far above what rounding does to a crossing
constexpr double undecided_limit = 0.1;    // of all rays
constexpr double probe_step = 0.25;        // of a cell
constexpr double normal_limit_deg = 1e-4;
constexpr std::size_t most_edge_points = 400'000;

/// Number of facets to suit the number of rays: CGAL's mesher takes far longer for a triangle than
/// a ray takes.
double facets_for(std::uint64_t samples) {
  return std::clamp(0.4 * static_cast<double>(samples), 2'000.0, 40'000.0);
}

class Comparer {
 public:
  Comparer(const GridField& field, const Affine& world_from_frame, const RayQuery& query)
      : field_(field),
        world_from_frame_(world_from_frame),
        box_(field.box_frame()),
        diagonal_(world_from_frame.vector(box_.size()).length()),
        depth_limit_(query.max_depth_error > 0 ? query.max_depth_error : default_depth_limit),
        judge_(field, query.isovalue),
        edge_points_(edge_points(field, query.isovalue, most_edge_points, query.seed)),
        surface_(mesh_surface(field, query.isovalue, edge_points_, {.facet_count = facets_for(query.samples)})),
        tree_(surface_.triangles),
        surface_error_(quantiles_of(surface_.offsets)) {}

  const GridSurface& surface() const { return surface_; }
  const EdgePoints& edges() const { return edge_points_; }
  const Quantiles& surface_error() const { return surface_error_; }
  const GridReference& judge() const { return judge_; }
  const Box3& box() const { return box_; }
  double depth_limit() const { return depth_limit_; }

  /// Length of the ray's direction in cells at t.
  double cells_per_t(const render::Ray& ray, double t) const { return field_.in_cells(ray.direction, ray.at(t)); }

  Finding find(const render::Ray& ray, const render::Hit& hit) const {
    Finding finding;
    const std::optional<Interval<double>> inside = inside_box(ray);
    if (!inside) {
      finding.verdict = hit.is_miss() ? Verdict::right : Verdict::false_hit;
      return finding;
    }
    const double per_t = cells_per_t(ray, hit.is_miss() ? inside->lo : hit.t);
    if (!hit.is_miss()) prove(ray, hit, per_t, finding);
    // The tracer must not have missed a crossing before the position that it reports.
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

  /// Depth error, in cells, that is allowed for a hit: its own bound, and the effect of rounding on
  /// the comparison.
  double allowed(const render::Hit& hit, double per_t) const {
    return depth_limit_ + (std::isnan(hit.error) ? 0 : hit.error * per_t);
  }

  /// Searches for the crossing that the tracer has reported, and measures the errors.
  void prove(const render::Ray& ray, const render::Hit& hit, double per_t, Finding& finding) const {
    const double finest = std::max(4e-16 * std::abs(hit.t), 1e-15 / per_t);
    const std::optional<double> t = judge_.crossing_near(ray, hit.t, finest, 0.5 / per_t);
    finding.is_hit = t.has_value();
    finding.bound_cells = hit.error * per_t;
    finding.bound_box = hit.error * in_box(ray.direction);
    measure_normal(ray.at(hit.t), hit, finding);
    const std::optional<Index3> cell = field_.cell_of_id(hit.cell);
    const auto residual = cell ? judge_.residual(ray, hit.t, *cell) : std::nullopt;
    const bool is_level = residual && *residual <= rounding_residual;
    if (t) {
      finding.t_reference = *t;
      finding.depth_cells = std::abs(*t - hit.t) * per_t;
      finding.depth_box = std::abs(*t - hit.t) * in_box(ray.direction);
      // The point is level but not the crossing found: the field reaches the isovalue there and
      // turns back.
      const bool only_touches = is_level && finding.depth_cells > another_crossing;
      const bool grazes = only_touches || (is_level && slope(ray, hit, *cell) <= grazing_slope);
      finding.verdict = finding.depth_cells <= allowed(hit, per_t) ? Verdict::right
                        : grazes                                   ? Verdict::grazes
                                                                   : Verdict::elsewhere;
    } else {
      finding.verdict = is_level ? Verdict::grazes : Verdict::false_hit;
    }
    measure_distance(ray.at(hit.t), hit, finding);
    if (finding.verdict == Verdict::grazes) finding.depth_cells = finding.depth_box = not_measured;
  }

  /// Length of a vector in diagonals of the data's box.
  double in_box(const Vec3& v_frame) const { return world_from_frame_.vector(v_frame).length() / diagonal_; }

  /// Change of the field along the ray over one cell's length, as a share of the range of the
  /// cell's corners.
  double slope(const render::Ray& ray, const render::Hit& hit, const Index3& at) const {
    const GridField::Cell cell = field_.cell(at);
    const Vec3 direction = (ray.direction / field_.widths(at)).normalized();
    const Vec3 local = field_.index_from_frame(ray.at(hit.t)) - to_vec3(at);
    return std::abs(cell.gradient(local).dot(direction)) / cell.range();
  }

  /// The distance is at most that to a crossing along the gradient, or along the ray.
  void measure_distance(const Vec3& p, const render::Hit& hit, Finding& finding) const {
    if (!tree_.is_empty())
      finding.mesh_cells = (field_.index_from_frame(p) - field_.index_from_frame(tree_.nearest(p))).length();
    finding.distance_cells = finding.depth_cells;
    finding.distance_box = finding.depth_box;
    if (!(hit.gradient.length() > 0)) return;
    const render::Ray across{p, hit.gradient.normalized()};
    const double per_t = cells_per_t(across, 0);
    const auto crossing = judge_.crossing_near(across, 0, 1e-15 / per_t, 0.5 / per_t);
    if (!crossing || std::abs(*crossing) * per_t > finding.distance_cells) return;
    finding.distance_cells = std::abs(*crossing) * per_t;
    finding.distance_box = std::abs(*crossing) * in_box(across.direction);
    finding.is_above = *crossing < 0;
  }

  void measure_normal(const Vec3& p, const render::Hit& hit, Finding& finding) const {
    const std::optional<Index3> at = field_.cell_of_id(hit.cell);
    if (!at) return;
    const Vec3 local = field_.index_from_frame(p) - to_vec3(*at);
    finding.normal_deg = angle_deg(field_.cell(*at).gradient(local) / field_.widths(*at), hit.gradient);
  }

  /// Finds a proved change of side before `end`. It searches along the whole ray, and closely where
  /// the ray meets the mesh.
  std::optional<double> passed_over(const render::Ray& ray, const Interval<double>& inside, double end,
                                    const render::Hit& hit, Finding& finding) const {
    if (const auto found = judge_.first_proved(ray, inside.lo, end, probe_step)) return found;
    const auto met = tree_.first_on(ray);
    if (!met || !(met->t < end) || met->t < inside.lo) return std::nullopt;
    const double error = std::isnan(surface_.offsets[met->triangle]) ? 1 : surface_.offsets[met->triangle];
    const double reach_cells = std::max(4 * error, 1e-9), reach = reach_cells / cells_per_t(ray, met->t);
    // The same crossing, up to the mesh's error.
    if (!hit.is_miss() && met->t > hit.t - reach) return std::nullopt;
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
  GridReference judge_;
  EdgePoints edge_points_;
  GridSurface surface_;
  TriangleTree tree_;
  Quantiles surface_error_;
};

/// A ray to a point along the field's gradient, starting so near that no crossing lies in between.
std::optional<AimedRay> near_ray(const Comparer& comparer, const GridField& field, const Vec3& target_index,
                                 bool from_above) {
  const auto at = field.cell_at(target_index);
  if (!at) return std::nullopt;
  const GridField::Cell cell = field.cell(*at);
  if (!cell.has_data()) return std::nullopt;
  const Vec3 gradient = cell.gradient(target_index - to_vec3(*at)) / field.widths(*at);
  if (!(gradient.length() > 0)) return std::nullopt;
  const Vec3 direction = (from_above ? -1.0 : 1.0) * gradient.normalized();
  const Vec3 target = field.frame_from_index(target_index);
  const double per_t = field.in_cells(direction, target);
  for (const double cells : {0.25, 0.05, 0.01, 0.002}) {
    const double before = cells / per_t;
    const render::Ray ray{target - before * direction, direction};
    const auto begin = comparer.judge().is_inside(ray, 0), end = comparer.judge().is_inside(ray, 2 * before);
    const bool is_between = begin && end && *begin != *end;
    if (is_between && !comparer.judge().first_proved(ray, 0, 0.9 * before, cells / 16)) return AimedRay{ray, Aim::near};
  }
  return std::nullopt;
}

/// Targets are, in turn, points on edges of the grid, which lie on the surface, and corners and
/// centres of the mesh's triangles.
std::vector<AimedRay> near_rays(const Comparer& comparer, const GridField& field, std::size_t count, RayMaker& maker) {
  const Triangles& triangles = comparer.surface().triangles;
  const std::vector<Vec3>& edges = comparer.edges().points_index;
  std::vector<AimedRay> rays;
  if (triangles.corners.empty() || edges.empty()) return rays;
  for (std::size_t s = 0; s < count; ++s) {
    const Vec3 target =
        s % 3 == 0 ? edges[maker.below(edges.size())]
                   : field.index_from_frame(maker.point_of(triangles, s % 3 == 1 ? Aim::vertex : Aim::center).p);
    if (const auto ray = near_ray(comparer, field, target, s % 2 == 0)) rays.push_back(*ray);
  }
  return rays;
}

void add_notes(const Comparer& comparer, const Shots& far, Report& report) {
  const GridSurface& surface = comparer.surface();
  const auto away = std::count_if(far.findings.begin(), far.findings.end(), [&](const Finding& finding) {
    return finding.mesh_cells > std::max(1.0, surface.triangle_radius);
  });
  if (away > 0)
    report.notes.push_back(
        concat(count_text(away, "hit", "hits"),
               " on parts of the surface that the mesh does not contain; they were checked against the field"));
  const auto unproved = std::count_if(far.findings.begin(), far.findings.end(), [&](const Finding& finding) {
    return std::isnan(finding.distance_cells) && !std::isnan(finding.mesh_cells);
  });
  if (unproved > 0)
    report.notes.push_back(concat(count_text(unproved, "hit", "hits"),
                                  " where the field only touches the isovalue in every direction examined: no "
                                  "crossing shows how far they are from the surface"));
  report.notes.push_back(concat("the mesh's triangles have a radius of about ",
                                std::round(100 * surface.triangle_radius) / 100,
                                " cells; smaller parts of the surface may be missing in it"));
  if (!surface.stopped_because.empty())
    report.notes.push_back(
        concat("the mesher stopped before all its triangles were small enough: ", surface.stopped_because));
}

}  // namespace

Comparison compare_grid(const GridField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress) {
  const Comparer comparer(field, world_from_frame, query);
  progress(250);
  RayMaker maker(world_from_frame, comparer.box(), query.seed);
  Rounds rounds =
      shoot(tracer,
            {.far = make_rays(maker, comparer.box(), comparer.surface().triangles, query.samples),
             .near = near_rays(comparer, field, query.samples / 4, maker),
             .camera = query.camera_rays,
             .find = [&](const render::Ray& ray, const render::Hit& hit) { return comparer.find(ray, hit); }},
            progress);
  Report report;
  report.reference = "the trilinear field itself, decided exactly, and the isosurface from CGAL's surface mesher";
  report.straddling_cells = comparer.edges().cell_count;
  report.triangles = comparer.surface().triangles.corners.size();
  fill(report, rounds,
       {.unit = "cells",
        .depth = comparer.depth_limit(),
        .normal_deg = normal_limit_deg,
        .why_none_wrong = "only what exact decisions at points of the ray prove or refute is counted",
        .why_depth = "rounding errors of rays that do not graze the surface, and the method's error bound",
        .why_normal = "the gradient of one cell in double precision, with a margin for small gradients"});
  const RayCounts all = report.total();
  report.checks.push_back({"undecided, share of rays",
                           static_cast<double>(all.undecided) / static_cast<double>(all.rays), undecided_limit,
                           "with more, the mesh would not represent this surface"});
  report.measures.push_back(measure("renderer to mesh", "cells", rounds.far, &Finding::mesh_cells));
  report.measures.push_back({"mesh to field", "cells", comparer.surface_error()});
  add_notes(comparer, rounds.far, report);
  return {std::move(report), std::move(rounds.camera)};
}

}  // namespace rhoray::tools::validate
