#include "render/traverse/lattice_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include "tests/render/support/exact.h"
#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::CellVisit;
using render::clip_to_lattice;
using render::PlaneTimes;
using render::PlaneTimesOf;
using render::Ray;
using render::Segment;
using render::TablePlanes;
using render::WalkLattice;
using render::WholePlanes;

using Fields = std::tuple<std::int64_t, std::int64_t, std::int64_t, double, double, int, int>;

Fields fields(const CellVisit& v) {
  return {v.cell.x, v.cell.y, v.cell.z, v.t_in, v.t_out, v.axis_in, v.axis_out};
}

Vec3 to_vec3(const Index3& i) {
  return {static_cast<double>(i.x), static_cast<double>(i.y), static_cast<double>(i.z)};
}

template <class Planes = WholePlanes>
std::vector<CellVisit> flat_walk(const Ray& ray, const WalkLattice& lattice, const Planes& at = {}) {
  std::vector<CellVisit> visits;
  const PlaneTimesOf<Planes> planes(ray, at);
  if (const auto part = clip_to_lattice(ray, planes, lattice.leaf_count))
    walk_level(ray, planes, lattice, 1, whole_level(lattice, 1), part->t_in, part->t_out, [&](const CellVisit& visit) {
      visits.push_back(visit);
      return true;
    });
  return visits;
}

/// Returns the leaf cells visited when `opens` decides on macrocells.
template <class Opens, class Planes = WholePlanes>
std::vector<CellVisit> hierarchical_walk(const Ray& ray, const WalkLattice& lattice, int levels, Opens opens,
                                         const Planes& at = {}) {
  std::vector<CellVisit> visits;
  const PlaneTimesOf<Planes> planes(ray, at);
  auto leaf = [&](const CellVisit& visit) {
    visits.push_back(visit);
    return true;
  };
  if (const auto part = clip_to_lattice(ray, planes, lattice.leaf_count))
    walk_hierarchy(ray, planes, lattice, levels, whole_level(lattice, lattice.cell_edge(levels)), part->t_in,
                   part->t_out, opens, leaf);
  return visits;
}

std::vector<CellVisit> with_length(std::vector<CellVisit> visits) {
  std::erase_if(visits, [](const CellVisit& v) { return v.has_no_length(); });
  return visits;
}

std::vector<Fields> all_fields(const std::vector<CellVisit>& visits) {
  std::vector<Fields> out;
  for (const CellVisit& v : visits) out.push_back(fields(v));
  return out;
}

/// A different implementation of the traversal: all plane times, sorted by time and then by axis,
/// passed one after the other.
template <class Planes = WholePlanes>
std::vector<CellVisit> walk_by_sorting(const Ray& ray, const Index3& size, const Planes& planes_at = {}) {
  const PlaneTimesOf<Planes> planes(ray, planes_at);
  const std::optional<Segment> part = clip_to_lattice(ray, planes, size);
  if (!part) return {};
  struct Pass {
    double t;
    int axis;
    std::int64_t order;
  };
  std::vector<Pass> passes;
  CellVisit at{.cell = {}, .t_in = part->t_in, .t_out = part->t_in, .axis_in = -1, .axis_out = -1};
  for (int axis = 0; axis < 3; ++axis) {
    const int step = planes.step(axis);
    at.cell[axis] = step > 0 ? 0 : size[axis] - 1;
    if (step == 0)
      for (at.cell[axis] = 0;
           at.cell[axis] < size[axis] - 1 && planes_at.position(axis, at.cell[axis] + 1) <= ray.origin[axis];)
        ++at.cell[axis];
    else
      for (std::int64_t k = 0; k <= size[axis]; ++k) passes.push_back({planes.at(axis, k), axis, step > 0 ? k : -k});
  }
  std::sort(passes.begin(), passes.end(), [](const Pass& a, const Pass& b) {
    return std::tuple(a.t, a.axis, a.order) < std::tuple(b.t, b.axis, b.order);
  });
  const auto enters_box = [&](const Pass& p) { return p.order == (planes.step(p.axis) > 0 ? 0 : -size[p.axis]); };
  const auto leaves_box = [&](const Pass& p) { return p.order == (planes.step(p.axis) > 0 ? size[p.axis] : 0); };
  for (const Pass& pass : passes) {  // those before the start, and at it
    if (pass.t > part->t_in || leaves_box(pass)) continue;
    if (!enters_box(pass)) at.cell[pass.axis] += planes.step(pass.axis);
    if (pass.t == part->t_in) at.axis_in = std::max(at.axis_in, pass.axis);
  }
  std::vector<CellVisit> visits;
  for (const Pass& pass : passes) {
    if (pass.t <= part->t_in && !leaves_box(pass)) continue;
    if (pass.t > part->t_out) break;
    at.t_out = std::max(at.t_in, pass.t);
    at.axis_out = pass.axis;
    visits.push_back(at);
    if (leaves_box(pass)) return visits;
    at.cell[pass.axis] += planes.step(pass.axis);
    at.t_in = at.t_out;
    at.axis_in = pass.axis;
  }
  at.t_out = part->t_out;
  at.axis_out = -1;
  visits.push_back(at);
  return visits;
}

struct Shape {
  Index3 count;
  std::int64_t factor;
  int levels;
};
const std::vector<Shape> shapes{{{8, 8, 8}, 2, 3}, {{7, 9, 5}, 2, 2},    {{27, 10, 28}, 3, 3}, {{17, 1, 5}, 4, 2},
                                {{1, 1, 1}, 2, 3}, {{64, 63, 65}, 4, 3}, {{26, 24, 31}, 5, 2}, {{2, 50, 2}, 5, 3}};

TEST(WalkLevel, visits_the_cells_between_the_sorted_plane_times) {
  std::size_t cells = 0, without_length = 0;
  for (const Shape& shape : shapes)
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 1500, 21)) {
      const auto walked = flat_walk(ray, {shape.count, shape.factor});
      ASSERT_EQ(all_fields(walked), all_fields(walk_by_sorting(ray, shape.count)))
          << ray.origin << " + t " << ray.direction << ", " << ray.t_min << " to " << ray.t_max;
      cells += walked.size();
      without_length += walked.size() - with_length(walked).size();
    }
  EXPECT_GT(cells, 100000);
  EXPECT_GT(without_length, 3000) << "too few ties are left: are these still the stressful rays?";
}

/// Planes in the box [0, count], with steps from 0.001 to about 1 unit, or at integers.
std::array<std::vector<double>, 3> uneven_planes(const Index3& count, bool whole) {
  Dice dice(77);
  std::array<std::vector<double>, 3> planes;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double>& table = planes[static_cast<std::size_t>(axis)];
    for (std::int64_t k = 0; k <= count[axis]; ++k)
      table.push_back(whole || k == 0 ? static_cast<double>(k)
                                      : table.back() + (dice.coin() ? 1 : std::pow(10, dice.between(-3, 0))));
    const double stretch = static_cast<double>(count[axis]) / table.back();
    for (double& position : table) position *= stretch;
  }
  return planes;
}

TEST(WalkLevel, visits_the_cells_between_the_sorted_times_of_uneven_planes) {
  std::size_t cells = 0;
  for (const Shape& shape : shapes) {
    const auto tables = uneven_planes(shape.count, false);
    const TablePlanes planes(tables);
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 700, 22)) {
      const auto walked = flat_walk(ray, {shape.count, shape.factor}, planes);
      ASSERT_EQ(all_fields(walked), all_fields(walk_by_sorting(ray, shape.count, planes)))
          << ray.origin << " + t " << ray.direction << ", " << ray.t_min << " to " << ray.t_max;
      cells += walked.size();
      const auto opened = hierarchical_walk(
          ray, {shape.count, shape.factor}, shape.levels, [](int, const CellVisit&) { return true; }, planes);
      ASSERT_EQ(all_fields(with_length(opened)), all_fields(with_length(walked)));
    }
  }
  EXPECT_GT(cells, 40000);
}

TEST(WalkLevel, is_the_same_bit_for_bit_where_a_table_says_what_whole_numbers_say) {
  for (const Shape& shape : shapes) {
    const auto tables = uneven_planes(shape.count, true);
    const TablePlanes planes(tables);
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 300, 23)) {
      const WalkLattice lattice{shape.count, shape.factor};
      const auto all = [](int, const CellVisit&) { return true; };
      ASSERT_EQ(all_fields(flat_walk(ray, lattice, planes)), all_fields(flat_walk(ray, lattice)));
      ASSERT_EQ(all_fields(hierarchical_walk(ray, lattice, shape.levels, all, planes)),
                all_fields(hierarchical_walk(ray, lattice, shape.levels, all)));
    }
  }
}

TEST(TablePlanes, in_planes_is_the_last_plane_at_or_below_between_those_that_matter) {
  const std::array<std::vector<double>, 3> tables{{{-3, -1, 0, 0.5, 100}, {0, 1}, {5, 6, 8}}};
  const TablePlanes planes(tables);
  EXPECT_EQ(planes.in_planes(0, -3, 0, 4), 0);
  EXPECT_EQ(planes.in_planes(0, 0.4, 0, 4), 2);
  EXPECT_EQ(planes.in_planes(0, 0.5, 0, 4), 3);
  EXPECT_EQ(planes.in_planes(0, 1e300, 0, 4), 4);
  EXPECT_EQ(planes.in_planes(0, -1e300, 0, 4), 0);
  EXPECT_EQ(planes.in_planes(0, 50, 1, 2), 2);
  EXPECT_EQ(planes.in_planes(0, -2, 2, 4), 2);
  EXPECT_EQ(planes.in_planes(2, 7.9, 0, 2), 1);
  EXPECT_EQ(planes.in_planes(1, std::numeric_limits<double>::quiet_NaN(), 0, 1), 0);
}

TEST(WalkLevel, goes_through_faces_only_and_covers_the_whole_part_of_the_ray) {
  for (const Shape& shape : shapes)
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 1500, 22)) {
      const auto part = clip_to_lattice(ray, PlaneTimes(ray), shape.count);
      const auto visits = flat_walk(ray, {shape.count, shape.factor});
      ASSERT_EQ(part.has_value(), !visits.empty());
      if (!part) continue;
      EXPECT_EQ(visits.front().t_in, part->t_in);
      EXPECT_EQ(visits.back().t_out, part->t_out);
      EXPECT_LE(visits.size(), static_cast<std::size_t>(shape.count.x + shape.count.y + shape.count.z - 2));
      for (std::size_t v = 0; v < visits.size(); ++v) {
        const CellVisit& at = visits[v];
        EXPECT_LE(at.t_in, at.t_out);
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GE(at.cell[axis], 0);
          ASSERT_LT(at.cell[axis], shape.count[axis]);
        }
        if (v == 0) continue;
        EXPECT_EQ(at.t_in, visits[v - 1].t_out);
        EXPECT_EQ(at.axis_in, visits[v - 1].axis_out);
        const Index3 step = at.cell - visits[v - 1].cell;
        EXPECT_EQ(std::abs(step.x) + std::abs(step.y) + std::abs(step.z), 1);
      }
    }
}

// Exact chords: every cell that contains a noticeable part of the ray is visited, for that part.
TEST(WalkLevel, visits_the_cells_that_exact_arithmetic_finds) {
  const Index3 size(9, 8, 11);
  std::size_t compared = 0, too_short = 0;
  for (const Ray& ray : stressful_rays(to_vec3(size), 700, 23)) {
    if (ray.origin.length() > 1e7) continue;
    const auto part = clip_to_lattice(ray, PlaneTimes(ray), size);
    if (!part) continue;
    std::vector<Rational> times{exact(part->t_in), exact(part->t_out)};
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(ray.direction[axis]) > 6e-309)
        for (int k = 0; k <= size[axis]; ++k) {
          const Rational t = (k - exact(ray.origin[axis])) / exact(ray.direction[axis]);
          if (t > times[0] && t < times[1]) times.push_back(t);
        }
    std::sort(times.begin(), times.end());
    std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::pair<double, double>> walked;
    for (const CellVisit& v : flat_walk(ray, {size, 2})) walked[{v.cell.x, v.cell.y, v.cell.z}] = {v.t_in, v.t_out};
    const double longest = std::max({std::abs(ray.direction.x), std::abs(ray.direction.y), std::abs(ray.direction.z)});
    // The error of a plane time is the rounding of the position, divided by the speed along the
    // slowest axis.
    double slowest = longest;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(ray.direction[axis]) > 1e-9 * longest) slowest = std::min(slowest, std::abs(ray.direction[axis]));
    const double tolerance = 1e-15 * (20 + ray.origin.length()) / slowest;
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
      const Rational length = times[i + 1] - times[i];
      if (length < exact(8 * tolerance)) {
        ++too_short;
        continue;
      }
      const Rational middle = (times[i] + times[i + 1]) / 2;
      std::array<std::int64_t, 3> cell{};
      bool on_plane = false;
      for (int axis = 0; axis < 3; ++axis) {
        const Rational p = exact(ray.origin[axis]) + middle * exact(ray.direction[axis]);
        cell[static_cast<std::size_t>(axis)] =
            std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(rounded(p))), 0, size[axis] - 1);
        on_plane = on_plane || abs(p - exact(std::round(rounded(p)))) < exact(1e-12);
      }
      if (on_plane) continue;  // the ray is in a plane: the cell on either side is correct
      const auto found = walked.find({cell[0], cell[1], cell[2]});
      ASSERT_NE(found, walked.end()) << ray.origin << " + t " << ray.direction;
      EXPECT_NEAR(found->second.first, rounded(times[i]), tolerance);
      EXPECT_NEAR(found->second.second, rounded(times[i + 1]), tolerance);
      ++compared;
    }
  }
  EXPECT_GT(compared, 3000);
  EXPECT_LT(too_short, compared / 4);
}

TEST(WalkLevel, stops_when_it_is_told_to) {
  const Ray ray{.origin = {-1, 0.5, 0.5}, .direction = {1, 0, 0}};
  const PlaneTimes planes(ray);
  const WalkLattice lattice{{10, 1, 1}, 2};
  int seen = 0;
  EXPECT_FALSE(walk_level(ray, planes, lattice, 1, whole_level(lattice, 1), 1.0, 11.0,
                          [&](const CellVisit&) { return ++seen < 3; }));
  EXPECT_EQ(seen, 3);
}

TEST(WalkLevel, takes_the_last_cell_for_a_ray_in_the_far_face) {
  const auto visits = flat_walk({.origin = {-1, 3, 2}, .direction = {1, -0.0, 0}}, {{4, 3, 2}, 2});
  ASSERT_EQ(visits.size(), 4U);
  for (const CellVisit& v : visits) {
    EXPECT_EQ(v.cell.y, 2);
    EXPECT_EQ(v.cell.z, 1);
  }
}

TEST(WalkHierarchy, with_every_macrocell_open_sees_the_flat_walk_bit_for_bit) {
  std::size_t cells = 0;
  for (const Shape& shape : shapes)
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 1500, 31))
      for (int levels = 1; levels <= shape.levels; ++levels) {
        const WalkLattice lattice{shape.count, shape.factor};
        const auto flat = with_length(flat_walk(ray, lattice));
        const auto seen = hierarchical_walk(ray, lattice, levels, [](int, const CellVisit&) { return true; });
        ASSERT_EQ(all_fields(with_length(seen)), all_fields(flat))
            << ray.origin << " + t " << ray.direction << " on " << levels << " levels of " << shape.factor;
        EXPECT_LE(seen.size(), static_cast<std::size_t>(shape.count.x + shape.count.y + shape.count.z - 2));
        cells += flat.size();
      }
  EXPECT_GT(cells, 100000);
}

TEST(WalkHierarchy, skips_exactly_the_leaf_cells_of_closed_macrocells) {
  std::size_t skipped = 0;
  for (const Shape& shape : shapes)
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 800, 32)) {
      const WalkLattice lattice{shape.count, shape.factor};
      // One in three macrocells is closed, chosen by a hash of its level and position.
      const auto is_open = [&](int level, const Index3& c) {
        const auto hash =
            static_cast<std::uint64_t>(((c.z * 1009 + c.y) * 1013 + c.x) * 17 + level) * 0x9e3779b97f4a7c15U;
        return (hash >> 33) % 3 != 0;
      };
      auto flat = with_length(flat_walk(ray, lattice));
      const std::size_t all = flat.size();
      std::erase_if(flat, [&](const CellVisit& v) {
        for (int level = 1; level <= shape.levels; ++level)
          if (const std::int64_t edge = lattice.cell_edge(level); !is_open(level, v.cell / Index3(edge, edge, edge)))
            return true;
        return false;
      });
      skipped += all - flat.size();
      const auto seen = hierarchical_walk(ray, lattice, shape.levels,
                                          [&](int level, const CellVisit& v) { return is_open(level, v.cell); });
      ASSERT_EQ(all_fields(with_length(seen)), all_fields(flat)) << ray.origin << " + t " << ray.direction;
    }
  EXPECT_GT(skipped, 10000);
}

TEST(WalkHierarchy, visits_fewer_macrocells_than_the_lattice_has_along_three_edges) {
  for (const Shape& shape : shapes)
    for (const Ray& ray : stressful_rays(to_vec3(shape.count), 300, 33)) {
      const WalkLattice lattice{shape.count, shape.factor};
      std::map<int, std::int64_t> visited;
      hierarchical_walk(ray, lattice, shape.levels, [&](int level, const CellVisit&) { return ++visited[level] > 0; });
      for (const auto& [level, count] : visited) {
        const Index3 end = whole_level(lattice, lattice.cell_edge(level)).end;
        EXPECT_LE(count, end.x + end.y + end.z - 2);
      }
    }
}

TEST(CellVisit, reaches_its_ends_exactly) {
  Dice dice(7);
  for (int trial = 0; trial < 10000; ++trial) {
    CellVisit visit;
    visit.t_in = dice.between(-10, 10);
    visit.t_out = visit.t_in + dice.between(0, 1) * dice.one_of(std::array{1.0, 1e-15, 1e3});
    EXPECT_EQ(visit.t_at(0), visit.t_in);
    EXPECT_EQ(visit.t_at(1), visit.t_out);
    const double t = visit.t_at(dice.between(0, 1));
    EXPECT_LE(visit.t_in, t);
    EXPECT_GE(visit.t_out, t);
  }
}

}  // namespace
}  // namespace rhoray::tests
