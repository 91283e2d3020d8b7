#include "preprocess/repair_surface.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/import_mesh.h"
#include "preprocess/inspect_surface.h"
#include "preprocess/tetrahedralize.h"
#include "tests/preprocess/workers/tetgen/surfaces.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

using preprocess::repair_surface;
using testing::AllOf;
using testing::HasSubstr;

double filled_volume(const NeutralSurface& surface) {
  const NeutralMesh mesh = preprocess::tetrahedralize(surface, {.quality = 0, .solids_may_touch = true});
  double sum = 0;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) sum += cell_volume(mesh, cell);
  return sum;
}

TEST(RepairSurface, leaves_a_sound_surface_where_it_is) {
  NeutralSurface sphere;
  add_sphere(sphere, 1, 2);
  const auto repaired = repair_surface(sphere);
  EXPECT_LE(repaired.report.farthest_new_from_old, repaired.report.distance_error);
  EXPECT_LE(repaired.report.farthest_old_from_new, repaired.report.distance_error);
  EXPECT_EQ(repaired.surface.facet_offsets.size(), sphere.facet_offsets.size());
  ASSERT_EQ(repaired.surface.notes.size(), 1u);
  EXPECT_THAT(repaired.surface.notes[0], HasSubstr("to within"));
}

TEST(RepairSurface, fills_a_hole_and_drops_what_is_there_twice_or_flat) {
  NeutralSurface open = box({0, 0, 0}, {1, 1, 2});
  open.facet_corners.resize(30);  // without the side x = 1
  open.facet_offsets.resize(11);
  open.points.push_back({2, 0, 0});
  add_facet(open, {0, 1, 8});
  add_facet(open, {2, 3, 0});
  const auto repaired = repair_surface(open);
  EXPECT_EQ(repaired.report.filled_holes, 1u);
  EXPECT_EQ(repaired.report.dropped_flat, 1u);
  EXPECT_EQ(repaired.report.dropped_twins, 1u);
  EXPECT_NEAR(filled_volume(repaired.surface), 2, 1e-9);
}

/// The points that a facet has in common with the first one.
std::size_t common_with_first(const NeutralSurface& triangles, std::size_t facet) {
  const auto first = triangles.facet_corners.begin();
  const auto corners = first + static_cast<std::ptrdiff_t>(3 * facet);
  return static_cast<std::size_t>(std::count_if(
      corners, corners + 3, [&](std::uint64_t corner) { return std::find(first, first + 3, corner) != first + 3; }));
}

// CGAL crashed when it refined the triangles of holes that touch in a point.
TEST(RepairSurface, fills_holes_that_touch_in_a_point) {
  NeutralSurface sphere;
  add_sphere(sphere, 1, 2);
  std::size_t tried = 0;
  for (std::size_t facet = 1; facet + 1 < sphere.facet_offsets.size(); ++facet) {
    if (common_with_first(sphere, facet) != 1) continue;
    NeutralSurface open;
    open.points = sphere.points;
    for (std::size_t kept = 1; kept + 1 < sphere.facet_offsets.size(); ++kept)
      if (kept != facet)
        add_facet(open, {sphere.facet_corners[3 * kept], sphere.facet_corners[3 * kept + 1],
                         sphere.facet_corners[3 * kept + 2]});
    const auto repaired = repair_surface(open);
    EXPECT_EQ(repaired.report.filled_holes, 2u);
    EXPECT_TRUE(preprocess::find_faults(repaired.surface).empty());
    EXPECT_NEAR(filled_volume(repaired.surface), filled_volume(sphere), 1e-9);
    ++tried;
  }
  EXPECT_GT(tried, 5u);
}

// Facets of more than three corners were cut as fans, which overlap where a facet is not convex.
TEST(RepairSurface, keeps_facets_that_are_not_convex_as_they_are) {
  for (std::ptrdiff_t first = 0; first < 6; ++first) {
    const auto repaired = repair_surface(prism(l_outline(first)));
    EXPECT_EQ(repaired.report.crossing_pairs, 0u) << first;
    EXPECT_LE(repaired.report.farthest_new_from_old, repaired.report.distance_error) << first;
    EXPECT_LE(repaired.report.farthest_old_from_new, repaired.report.distance_error) << first;
    EXPECT_NEAR(filled_volume(repaired.surface), 3, 1e-9) << first;
  }
  const NeutralSurface u = prism({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}});
  EXPECT_NEAR(filled_volume(repair_surface(u).surface), 7, 1e-9);
}

// Every outline became a wall of its own, and the tunnel was closed.
TEST(RepairSurface, keeps_the_openings_of_faces_open) {
  const auto repaired = repair_surface(tunnel());
  EXPECT_EQ(repaired.report.crossing_pairs, 0u);
  EXPECT_NEAR(filled_volume(repaired.surface), 8, 1e-9);
  EXPECT_TRUE(preprocess::find_faults(repaired.surface).empty());
  const double wrapped = filled_volume(repair_surface(tunnel(), {.wrap = 0.05}).surface);
  EXPECT_GT(wrapped, 8);
  EXPECT_LT(wrapped, 8.8);
}

TEST(RepairSurface, keeps_an_outline_without_an_opening_closed) {
  NeutralSurface plates = tunnel();
  plates.openings.clear();
  plates.facet_corners.resize(16);  // bottom and top, of two outlines each
  plates.facet_offsets.resize(5);
  plates.facet_faces.resize(4);
  for (std::uint64_t i = 0; i < 4; ++i) {  // adds the four sides of the box; the tunnel has none
    add_facet(plates, {i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i});
    plates.facet_faces.push_back(2 + i);
  }
  EXPECT_NEAR(filled_volume(repair_surface(plates).surface), 9, 1e-9);
}

TEST(RepairSurface, refuses_a_face_whose_outlines_cross) {
  NeutralSurface crossing = tunnel();
  crossing.points[8] = {-1, 1, 0};  // a corner of the tunnel, now outside of the box
  expect_error(ErrorCode::invalid, "the outlines of facet 0 and of others in the same face cross",
               [&] { repair_surface(crossing); });
}

// CGAL crashed where it cuts facets along their crossings: two of them met in a point of a third.
TEST(RepairSurface, lives_through_facets_that_overlap_and_meet_in_points) {
  std::uint64_t crossing_pairs = 0;
  for (std::ptrdiff_t first = 0; first < 6; ++first)
    crossing_pairs += repair_surface(as_fans(prism(l_outline(first))), {.max_move = 1}).report.crossing_pairs;
  EXPECT_GT(crossing_pairs, 6u) << "do the fans still cross?";
}

TEST(RepairSurface, joins_edges_that_lie_on_each_other) {
  NeutralSurface sphere;
  add_sphere(sphere, 1, 1);
  NeutralSurface torn;  // every facet with points of its own
  for (const std::uint64_t corner : sphere.facet_corners) {
    torn.facet_corners.push_back(torn.points.size());
    torn.points.push_back(sphere.points[corner]);
  }
  torn.facet_offsets = sphere.facet_offsets;
  const auto repaired = repair_surface(torn);
  EXPECT_EQ(repaired.report.merged_points, torn.points.size() - sphere.points.size());
  EXPECT_TRUE(preprocess::find_faults(repaired.surface).empty());
}

TEST(RepairSurface, makes_one_solid_of_bodies_that_cross) {
  NeutralSurface boxes = box({0, 0, 0}, {2, 2, 2});
  add_box(boxes, {1, 1, 1}, {3, 3, 3});
  const auto repaired = repair_surface(boxes);
  EXPECT_EQ(repaired.report.united_parts, 2u);
  EXPECT_GT(repaired.report.crossing_pairs, 0u);
  EXPECT_NEAR(filled_volume(repaired.surface), 15, 1e-9);
  // The corner at (1, 1, 1) went: it lies 1 from the nearest side that is left.
  EXPECT_NEAR(repaired.report.farthest_old_from_new, 1, repaired.report.distance_error);
  EXPECT_LE(repaired.report.farthest_new_from_old, repaired.report.distance_error);
}

TEST(RepairSurface, keeps_bodies_that_touch_in_an_edge_apart) {
  NeutralSurface boxes = box({0, 0, 0}, {1, 1, 1});
  add_box(boxes, {1, 1, 0}, {2, 2, 1});
  EXPECT_FALSE(preprocess::find_faults(boxes).empty()) << "the edge has four facets";
  EXPECT_NEAR(filled_volume(repair_surface(boxes).surface), 2, 1e-9);
}

TEST(RepairSurface, keeps_the_largest_part_only_when_asked_to) {
  NeutralSurface boxes = box({0, 0, 0}, {1, 1, 1});
  add_box(boxes, {3, 0, 0}, {5, 2, 2});
  const auto repaired = repair_surface(boxes, {.largest_part_only = true});
  EXPECT_EQ(repaired.report.dropped_parts, 1u);
  EXPECT_NEAR(filled_volume(repaired.surface), 8, 1e-9);
}

TEST(RepairSurface, wraps_at_the_distance_that_it_names) {
  NeutralSurface open = box({0, 0, 0}, {1, 1, 1});
  open.facet_corners.resize(33);
  open.facet_offsets.pop_back();
  const auto wrapped = repair_surface(open, {.wrap = 0.5});
  EXPECT_TRUE(wrapped.report.wrapped);
  EXPECT_TRUE(preprocess::find_faults(wrapped.surface).empty());
  EXPECT_GT(filled_volume(wrapped.surface), 1);
  EXPECT_GT(wrapped.report.farthest_new_from_old, 0.01);
}

TEST(RepairSurface, refuses_what_has_no_area) {
  NeutralSurface line;
  line.points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  add_facet(line, {0, 1, 2});
  expect_error(ErrorCode::invalid, "no facet has an area", [&] { repair_surface(line); });
}

/// Both workers replaced by a program that ends as told.
TEST(WorkerDeath, is_reported_with_what_it_was_doing) {
  const TemporaryFolder folder;
  const NeutralSurface cube = box({0, 0, 0}, {1, 1, 1});
  for (const char* end : {"SEGV", "ABRT", "KILL", "XCPU"}) {
    for (const char* program : {"rhoray-tetgen-worker", "rhoray-repair-worker"}) {
      write_file(folder / program, std::string("#!/bin/sh\nkill -") + end + " $$\n");
      std::filesystem::permissions(folder / program, std::filesystem::perms::owner_all);
    }
    ::setenv("RHORAY_WORKER_DIR", folder.path().c_str(), 1);
    const auto refusal = [](auto act) -> std::pair<ErrorCode, std::string> {
      try {
        act();
      } catch (const Error& error) {
        return {error.code(), error.what()};
      }
      return {ErrorCode::internal, "no refusal"};
    };
    const bool resource = end == std::string("KILL") || end == std::string("XCPU");
    const auto filling = refusal([&] { preprocess::tetrahedralize(cube); });
    const auto repairing = refusal([&] { repair_surface(cube); });
    ::unsetenv("RHORAY_WORKER_DIR");
    EXPECT_THAT(filling.second, AllOf(HasSubstr("rhoray-tetgen-worker"), HasSubstr("filling a surface"))) << end;
    EXPECT_THAT(repairing.second, AllOf(HasSubstr("rhoray-repair-worker"), HasSubstr("repairing a surface"))) << end;
    EXPECT_EQ(filling.first, resource ? ErrorCode::resource : ErrorCode::invalid) << end;
    EXPECT_EQ(repairing.first, filling.first) << end;
    if (end == std::string("KILL")) {
      EXPECT_THAT(filling.second, HasSubstr("signal 9")) << "no time was used up";
    }
  }
}

TEST(RepairSurface, refuses_to_move_the_surface_farther_than_allowed) {
  // A cube whose bottom is drawn up to a point above its top: being rid of the crossings costs that
  // tip.
  NeutralSurface pierced = box({0, 0, 0}, {1, 1, 1});
  const std::uint64_t tip = pierced.points.size();
  pierced.points.push_back({0.5, 0.5, 1.4});
  pierced.facet_corners.erase(pierced.facet_corners.begin(), pierced.facet_corners.begin() + 6);
  pierced.facet_offsets.resize(11);
  for (const auto& [a, b] : {std::pair{0, 2}, {2, 3}, {3, 1}, {1, 0}})
    add_facet(pierced, {static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b), tip});
  try {
    repair_surface(pierced);
    ADD_FAILURE() << "was repaired";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid);
    EXPECT_THAT(error.what(), AllOf(HasSubstr("the repair would move it by"), HasSubstr("expected at most 2 %")));
    EXPECT_THAT(error.hint(), AllOf(HasSubstr("--max-move 0."), HasSubstr("--wrap 0.01")));
  }
  const auto moved = repair_surface(pierced, {.max_move = 1}).report;
  EXPECT_GT(moved.moved, 0.02 * moved.box_diagonal);
}

class SharedFaultySurfaces : public testing::Test {
 protected:
  void SetUp() override {
    const char* shared = std::getenv("RHORAY_SHARED_DATA");
    if (shared == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA does not name the folder of shared data";
    surfaces_ = std::filesystem::path(shared) / "surfaces";
  }
  std::filesystem::path surfaces_;
};

TEST_F(SharedFaultySurfaces, three_nested_heads_become_scalp_skull_and_brain) {
  std::vector<NeutralSurface> heads;
  std::vector<double> enclosed;
  for (const char* name : {"head.tri", "skull.tri", "brain.tri"}) {
    heads.push_back(preprocess::import_surface(surfaces_ / "openmeeg" / name));
    enclosed.push_back(std::abs(enclosed_volume(heads.back(), 0, heads.back().facet_offsets.size() - 1)));
  }
  const NeutralMesh mesh = preprocess::tetrahedralize(preprocess::join(heads), {.quality = 0});
  std::map<double, double> volumes;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell)
    volumes[mesh.cell_fields.at(0).values[cell]] += cell_volume(mesh, cell);
  ASSERT_EQ(volumes.size(), 3u);
  EXPECT_NEAR(volumes.at(1), enclosed[0] - enclosed[1], 1e-7 * enclosed[0]);
  EXPECT_NEAR(volumes.at(2), enclosed[1] - enclosed[2], 1e-7 * enclosed[0]);
  EXPECT_NEAR(volumes.at(3), enclosed[2], 1e-7 * enclosed[0]);
}

TEST_F(SharedFaultySurfaces, the_crown_and_the_aeroplane_are_mended) {
  for (const char* name : {"42400-IDGH.stl", "odedstein/plane_holes.obj", "odedstein/wingnut.obj"}) {
    const auto repaired = repair_surface(preprocess::import_surface(surfaces_ / name));
    EXPECT_GT(filled_volume(repaired.surface), 0) << name;
    EXPECT_LT(repaired.report.farthest_old_from_new, 0.002 * repaired.report.box_diagonal) << name;
    EXPECT_LT(repaired.report.farthest_new_from_old, 0.02 * repaired.report.box_diagonal) << name;
  }
}

// A part of them crosses itself, and being rid of that moves it far.
TEST_F(SharedFaultySurfaces, the_gears_are_not_repaired_silently) {
  try {
    repair_surface(preprocess::import_surface(surfaces_ / "gears.stl"));
    ADD_FAILURE() << "was repaired";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid);
    EXPECT_THAT(error.what(), HasSubstr("the repair would move it by"));
  }
}

}  // namespace
}  // namespace rhoray::tests
