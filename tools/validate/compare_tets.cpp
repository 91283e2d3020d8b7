#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/base/text.h"
#include "tools/validate/compare.h"
#include "tools/validate/exact_tets.h"
#include "tools/validate/tet_surface.h"
#include "tools/validate/triangle_tree.h"

namespace rhoray::tools::validate {

namespace {

constexpr double default_depth_limit = 1e-9;  // of the box's diagonal
constexpr double normal_limit_deg = 1e-4;
// Of the box's diagonal: how far rounding may move a hit off the surface.
constexpr double surface_slack = 1e-11;
// Of the distance from a ray's origin: about a dozen roundings.
constexpr double rounding_share = 2e-15;

/// Compares the renderer's hits with the reference.
class Comparer {
 public:
  Comparer(const TetField& field, const Affine& world_from_frame, const Box3& data_frame, const RayQuery& query)
      : field_(field),
        world_from_frame_(world_from_frame),
        data_frame_(data_frame),
        diagonal_(world_from_frame.vector(data_frame.size()).length()),
        depth_limit_(query.max_depth_error > 0 ? query.max_depth_error : default_depth_limit),
        surface_(extract_surface(field, query.isovalue)),
        tree_(surface_.triangles),
        judge_(field, surface_.straddling, query.isovalue) {}

  const TetSurface& surface() const { return surface_; }
  double depth_limit() const { return depth_limit_; }
  const ExactTets& judge() const { return judge_; }
  double world_length(const Vec3& v_frame) const { return world_from_frame_.vector(v_frame).length(); }

  Finding find(const render::Ray& ray, const render::Hit& hit) const {
    Finding finding;
    const std::optional<std::uint32_t> hit_cell = hit.is_miss() ? std::nullopt : cell_of(ray, hit);
    std::optional<ExactTets::Crossing> truth = undisputed(ray, hit, hit_cell);
    if (!truth && !(hit.is_miss() && !tree_.first_on(ray))) {
      truth = judge_.first_crossing(ray);
      finding.was_redecided = true;
    }
    finding.verdict = verdict_of(ray, hit, time_of(truth));
    if (finding.verdict != Verdict::right) {
      if (const auto moved = moved_by_rounding(ray, hit)) {
        finding.verdict = Verdict::grazes;
        finding.moved_box = moved->distance / diagonal_;
        truth = moved->crossing;
      }
    }
    finding.is_hit = truth.has_value();
    if (truth) finding.t_reference = truth->t;
    if (!hit.is_miss()) measure_hit(ray, hit, hit_cell, finding);
    return finding;
  }

 private:
  /// The cell that a hit reports. If several cells have that id, it is one that contains the point.
  /// If a ray passes between cells, several contain it; then it is the one whose normal the hit
  /// has.
  std::optional<std::uint32_t> cell_of(const render::Ray& ray, const render::Hit& hit) const {
    constexpr double rounding = 1e-9;  // in barycentric coordinates
    const std::span<const std::uint32_t> cells = field_.cells_of_id(hit.cell);
    if (cells.size() <= 1) return cells.empty() ? std::nullopt : std::optional(cells.front());
    const auto misfit = [&](std::uint32_t number) {
      const TetField::Cell cell = field_.cell(number);
      const double outside = -cell.smallest_coordinate(ray.at(hit.t));
      const double turn = angle_deg(cell.gradient(), hit.gradient);
      return std::pair(outside > rounding ? outside : 0, std::isnan(turn) ? 180 : turn);
    };
    return *std::ranges::min_element(cells, {}, misfit);
  }

  /// The crossing in the cell that both the tracer and the extracted surface report.
  std::optional<ExactTets::Crossing> undisputed(const render::Ray& ray, const render::Hit& hit,
                                                std::optional<std::uint32_t> hit_cell) const {
    const auto met = tree_.first_on(ray);
    if (!hit_cell || !met || surface_.cells[met->triangle] != *hit_cell) return std::nullopt;
    const std::optional<double> t = judge_.crossing_in(ray, *hit_cell);
    // Where the results are far apart, the cell alone does not determine which crossing is the
    // first.
    if (!t || std::abs(*t - hit.t) * world_length(ray.direction) > allowed(ray, hit)) return std::nullopt;
    return ExactTets::Crossing{.t = *t, .cell = *hit_cell};
  }

  /// Depth error, in world units, that is allowed for a hit: its own bound, and the effect of
  /// rounding on the comparison.
  double allowed(const render::Ray& ray, const render::Hit& hit) const {
    return depth_limit_ * diagonal_ + (std::isnan(hit.error) ? 0 : hit.error * world_length(ray.direction));
  }

  void measure_hit(const render::Ray& ray, const render::Hit& hit, std::optional<std::uint32_t> hit_cell,
                   Finding& finding) const {
    const Vec3 p = ray.at(hit.t);
    const double cell_size = hit_cell ? world_length(diagonal_of(field_.cell(*hit_cell))) : diagonal_;
    if (!tree_.is_empty()) {
      const Vec3 offset = p - tree_.nearest(p);
      finding.distance_box = world_length(offset) / diagonal_;
      finding.distance_cells = world_length(offset) / cell_size;
      finding.is_above = offset.dot(hit.gradient) > 0;
    }
    finding.bound_box = hit.error * world_length(ray.direction) / diagonal_;
    finding.bound_cells = hit.error * world_length(ray.direction) / cell_size;
    if (finding.is_hit) {
      const double depth = std::abs(hit.t - finding.t_reference) * world_length(ray.direction);
      finding.depth_box = depth / diagonal_;
      finding.depth_cells = depth / cell_size;
    }
    if (hit_cell) finding.normal_deg = angle_deg(field_.cell(*hit_cell).gradient(), hit.gradient);
  }

  /// The longest edge, as a vector along an axis of the frame. The frame is at most rotated and
  /// translated against the world.
  static Vec3 diagonal_of(const TetField::Cell& cell) { return {cell.longest_edge(), 0, 0}; }

  Verdict verdict_of(const render::Ray& ray, const render::Hit& hit, const std::optional<double>& truth) const {
    if (!truth) return hit.is_miss() ? Verdict::right : Verdict::false_hit;
    if (hit.is_miss()) return Verdict::missed;
    const double depth = std::abs(hit.t - *truth) * world_length(ray.direction);
    return depth <= allowed(ray, hit) ? Verdict::right : Verdict::elsewhere;
  }

  static std::optional<double> time_of(const std::optional<ExactTets::Crossing>& crossing) {
    return crossing ? std::optional(crossing->t) : std::nullopt;
  }

  struct Moved {
    double distance = 0;
    std::optional<ExactTets::Crossing> crossing;
  };

  bool lies_on_surface(const Vec3& p) const {
    return !tree_.is_empty() && world_length(p - tree_.nearest(p)) <= surface_slack * diagonal_;
  }

  /// True if the extracted surface, hit by a shifted ray, roughly agrees with the tracer.
  bool may_agree(const render::Ray& ray, const Vec3& shift, const render::Hit& hit) const {
    // Of the box's diagonal: where a ray grazes, a small shift moves the crossing far.
    constexpr double roughly = 1e-3;
    const auto met = tree_.first_on({ray.origin + shift, ray.direction});
    if (hit.is_miss() || !met) return hit.is_miss() == !met;
    return std::abs(met->t - hit.t) * world_length(ray.direction) <= roughly * diagonal_;
  }

  /// Finds the smallest parallel shift, among those tried, for which the tracer's hit is exactly
  /// correct. Returns nothing if there is none within the possible rounding. The rounding of the
  /// extracted surface is far smaller than the largest shift. So directions in which that surface
  /// contradicts the tracer are not tried.
  std::optional<Moved> moved_by_rounding(const render::Ray& ray, const render::Hit& hit) const {
    constexpr int directions = 16;
    if (!hit.is_miss() && !lies_on_surface(ray.at(hit.t))) return std::nullopt;
    const Vec3 way = ray.direction.normalized();
    const Vec3 aside = way.cross(std::abs(way.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0)).normalized();
    const Vec3 other = way.cross(aside);
    const double farthest = (data_frame_.center() - ray.origin).length() + data_frame_.size().length() / 2;
    std::vector<Vec3> shifts;
    for (int turn = 0; turn < directions; ++turn) {
      const double angle = 2 * std::numbers::pi * turn / directions;
      const Vec3 shift = rounding_share * farthest * (std::cos(angle) * aside + std::sin(angle) * other);
      if (may_agree(ray, shift, hit) || may_agree(ray, shift / 16, hit)) shifts.push_back(shift);
    }
    for (const double share : {1.0 / 64, 1.0 / 16, 1.0 / 4, 1.0})
      for (const Vec3& shift : shifts) {
        const auto crossing = judge_.first_crossing({ray.origin + share * shift, ray.direction});
        if (verdict_of(ray, hit, time_of(crossing)) == Verdict::right)
          return Moved{share * world_length(shift), crossing};
      }
    return std::nullopt;
  }

  const TetField& field_;
  Affine world_from_frame_;
  Box3 data_frame_;
  double diagonal_, depth_limit_;
  TetSurface surface_;
  TriangleTree tree_;
  ExactTets judge_;
};

/// A ray to a point of the surface, along the field's gradient, from just in front of it. It starts
/// so near that the surface is not crossed before. Nothing where that is impossible, as in cells
/// without volume.
std::optional<AimedRay> near_ray(const Comparer& comparer, const TetField& field, const Vec3& target,
                                 std::uint32_t cell_number, bool from_above) {
  const TetField::Cell cell = field.cell(cell_number);
  const Vec3 gradient = cell.gradient();
  if (!(gradient.length() > 0) || !std::isfinite(gradient.length())) return std::nullopt;
  const Vec3 direction = (from_above ? -1.0 : 1.0) * gradient.normalized();
  double before = 0.25 * cell.longest_edge();
  for (int attempt = 0; attempt < 6; ++attempt, before *= 0.1) {
    const render::Ray ray{target - before * direction, direction};
    const auto first = comparer.judge().first_crossing(ray);
    if (first && std::abs(first->t - before) <= 1e-3 * before) return AimedRay{ray, Aim::near};
  }
  return std::nullopt;
}

/// Samples of the surface, corners and centres in turn, each hit from just in front of it, from
/// either side.
std::vector<AimedRay> near_rays(const Comparer& comparer, const TetField& field, std::size_t count, RayMaker& maker) {
  const Triangles& triangles = comparer.surface().triangles;
  std::vector<AimedRay> rays;
  if (triangles.corners.empty()) return rays;
  for (std::size_t s = 0; s < count; ++s) {
    const auto target = maker.point_of(triangles, s % 2 == 0 ? Aim::vertex : Aim::center);
    if (const auto ray = near_ray(comparer, field, target.p, comparer.surface().cells[target.triangle], s % 4 < 2))
      rays.push_back(*ray);
  }
  return rays;
}

}  // namespace

Comparison compare_tets(const TetField& field, const Affine& world_from_frame, const RayQuery& query,
                        const Tracer& tracer, const Thousandths& progress) {
  const Box3 data_frame = field.box();
  const Comparer comparer(field, world_from_frame, data_frame, query);
  const TetSurface& surface = comparer.surface();
  progress(200);
  RayMaker maker(world_from_frame, data_frame, query.seed);
  Rounds rounds =
      shoot(tracer,
            {.far = make_rays(maker, data_frame, surface.triangles, query.samples),
             .near = near_rays(comparer, field, query.samples / 4, maker),
             .camera = query.camera_rays,
             .find = [&](const render::Ray& ray, const render::Hit& hit) { return comparer.find(ray, hit); }},
            progress);
  Report report;
  report.reference =
      "the isosurface extracted from the same tetrahedra with exact constructions; differences are decided exactly";
  report.straddling_cells = surface.straddling.size();
  report.triangles = surface.triangles.corners.size();
  fill(report, rounds,
       {.unit = "box",
        .depth = comparer.depth_limit(),
        .normal_deg = normal_limit_deg,
        .why_none_wrong = "every difference is decided exactly, so none is due to the reference",
        .why_depth = "double precision in the cell, with a margin for grazing rays, and the method's error bound",
        .why_normal = "the gradient of one cell in double precision, with a margin for thin cells"});
  report.measures.push_back(measure("grazing rays moved", "box", rounds.far, &Finding::moved_box));
  return {std::move(report), std::move(rounds.camera)};
}

}  // namespace rhoray::tools::validate
