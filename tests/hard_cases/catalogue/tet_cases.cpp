// T. Tetrahedra: rays through shared faces, edges and vertices, cells without volume, and meshes
// that are not a partition of space.
#include <array>

#include "tests/hard_cases/catalogue/case_parts.h"

namespace rhoray::tests {
namespace {

using preprocess::NeutralMesh;

/// Points at whole numbers in a box [0, 5]^3; 750 cells.
const BoxMesh whole{.cells = {5, 5, 5}, .box = Box3({0, 0, 0}, {5, 5, 5})};
const Vec3 size(5);

Index3 nearest(const Vec3& p) {
  return {std::llround(p.x), std::llround(p.y), std::llround(p.z)};
}

/// A rough ball of radius 2 about the centre.
double rough_ball(const Vec3& p) {
  return 2 - (p - Vec3(2.5)).length() + 0.3 * noise(nearest(p * 7.0));
}
double whole_numbers(const Vec3& p) {
  return static_cast<double>(whole_noise(nearest(p), 3));
}

/// Whether a point is on the border of the meshes here, which fill a box [0, 5]^3.
bool is_on_border(const Vec3& p) {
  return std::min({p.x, p.y, p.z}) == 0 || std::max({p.x, p.y, p.z}) == 5;
}

/// Rays that meet a mesh in vertices (corners = 1), on edges (2), in faces (3) or inside cells (4).
/// @param exactly  whether to use directions and distances that cause no rounding if the mesh's
///   points are whole numbers
Rays rays_at(const NeutralMesh& mesh, std::size_t corners, bool exactly, std::size_t count, std::uint64_t seed) {
  constexpr std::array<std::array<double, 4>, 4> weights{
      {{1}, {0.5, 0.5}, {0.25, 0.25, 0.5}, {0.25, 0.25, 0.25, 0.25}}};
  Dice dice(seed);
  double extent = 0;
  for (const auto& point : mesh.points) extent = std::max(extent, (to_vec3(point) - to_vec3(mesh.points[0])).length());
  Rays rays;
  while (rays.size() < count) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
    const auto first = static_cast<std::size_t>(dice.below(4));
    Vec3 target(0);
    for (std::size_t i = 0; i < corners; ++i)
      target += weights[corners - 1][i] * to_vec3(mesh.points[cell[(first + i) % 4]]);
    if (is_on_border(target)) continue;
    // Some rays start close by, so that they hit nothing else before.
    const bool close = rays.size() % 2 == 0;
    rays.push_back(exactly ? through(target, direction_in_eighths(dice), close ? 0.25 : 16)
                           : through(target, dice.direction(), close ? 0.05 * extent : 2 * extent));
  }
  return rays;
}

Rays all_rays_at(const NeutralMesh& mesh, std::size_t count, std::uint64_t seed, bool exactly = true) {
  std::vector<Rays> parts;
  for (std::size_t corners = 1; corners <= 4; ++corners)
    parts.push_back(rays_at(mesh, corners, exactly && corners < 4, count / 4, seed + corners));
  return together(parts);
}

/// Rays along edges of cells.
Rays rays_along_edges(const NeutralMesh& mesh, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
    const auto first = static_cast<std::size_t>(dice.below(4));
    const Vec3 a = to_vec3(mesh.points[cell[first]]);
    const Vec3 b = to_vec3(mesh.points[cell[(first + 1 + static_cast<std::size_t>(dice.below(3))) % 4]]);
    if (!is_on_border(0.5 * (a + b))) rays.push_back(through(a, b - a, rays.size() % 2 == 0 ? 0.25 : 16));
  }
  return rays;
}

/// Rays in planes of faces.
Rays rays_in_faces(const NeutralMesh& mesh, std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const auto& cell = mesh.cells[static_cast<std::size_t>(dice.below(static_cast<std::int64_t>(mesh.cells.size())))];
    const auto first = static_cast<std::size_t>(dice.below(4));
    const Vec3 a = to_vec3(mesh.points[cell[first]]), b = to_vec3(mesh.points[cell[(first + 1) % 4]]),
               c = to_vec3(mesh.points[cell[(first + 2) % 4]]);
    const double u = static_cast<double>(dice.below(17) - 8) / 8, v = static_cast<double>(dice.below(17) - 8) / 8;
    const Vec3 direction = u * (b - a) + v * (c - a);
    const Vec3 target = 0.25 * a + 0.25 * b + 0.5 * c;
    if (direction.length() > 0 && !is_on_border(target))
      rays.push_back(through(target, direction, rays.size() % 2 == 0 ? 0.25 : 16));
  }
  return rays;
}

/// Why a direct method may err where the values are whole numbers.
constexpr std::string_view ties =
    "where the value in a face is the isovalue itself, or a ray lies in the mesh's border, rounding decides";

HardCase mesh_case(HardCase hard_case) {
  hard_case.asked = Asked::surface_of_mesh;
  return hard_case;
}

/// The mesh with its points transformed by a map.
NeutralMesh moved(NeutralMesh mesh, const Affine& map) {
  for (auto& point : mesh.points) point = to_array(map.point(to_vec3(point)));
  return mesh;
}
Rays moved(Rays rays, const Affine& map) {
  for (render::Ray& ray : rays) ray.origin = map.point(ray.origin), ray.direction = map.vector(ray.direction);
  return rays;
}

/// One mesh beside another, with nothing shared.
NeutralMesh beside(NeutralMesh mesh, const NeutralMesh& other) {
  const std::uint64_t first = mesh.points.size();
  mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
  for (auto cell : other.cells) {
    for (auto& vertex : cell) vertex += first;
    mesh.cells.push_back(cell);
  }
  auto& values = mesh.point_fields[0].values;
  values.insert(values.end(), other.point_fields[0].values.begin(), other.point_fields[0].values.end());
  return mesh;
}

/// Each cell with its own points, at the same positions.
NeutralMesh with_points_apart(const NeutralMesh& mesh) {
  NeutralMesh apart;
  apart.point_fields.emplace_back();
  apart.point_fields[0].name = "value";
  apart.point_fields[0].was_single_precision = false;
  for (auto cell : mesh.cells) {
    for (auto& vertex : cell) {
      apart.points.push_back(mesh.points[vertex]);
      apart.point_fields[0].values.push_back(mesh.point_fields[0].values[vertex]);
      vertex = apart.points.size() - 1;
    }
    apart.cells.push_back(cell);
  }
  return apart;
}

/// Two roofs over a square's diagonals with a flat cell between
/// (tests/hard_cases/slivers_and_flat_tets_test.cpp), many times, with the square's corners lifted
/// by `bump`.
NeutralMesh roofs(double bump) {
  NeutralMesh all;
  for (int n = 0; n < 8; ++n) {
    NeutralMesh mesh;
    const double x = 3 * n, b = -bump;  // with the opposite sign the roofs would overlap
    mesh.points = {{x, 0, b}, {x + 1, 0, -b}, {x + 1, 1, b}, {x, 1, -b}, {x + 0.5, 0.5, -1}, {x + 0.5, 0.5, 1}};
    mesh.cells = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 1, 3, 5}, {1, 2, 3, 5}, {0, 1, 2, 3}};
    mesh.point_fields.emplace_back();
    mesh.point_fields[0].name = "value";
    mesh.point_fields[0].was_single_precision = false;
    mesh.point_fields[0].values = {-0.5, 0.5, -0.5, 0.5, -1, 1};
    all = n == 0 ? mesh : beside(all, mesh);
  }
  return all;
}

Rays rays_at_roofs(std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  Rays rays;
  while (rays.size() < count) {
    const double x = 3 * static_cast<double>(dice.below(8));
    const Vec3 target = as_point({dice.below(65), dice.below(65), 0}) / 64 + Vec3(x, 0, 0);
    Vec3 direction{dice.between(-0.3, 0.3), dice.between(-0.3, 0.3), dice.coin() ? 1.0 : -1.0};
    if (dice.coin()) direction.x = direction.y = 0;
    rays.push_back(through(target, direction, 4));
  }
  return rays;
}

NeutralMesh turned_over(NeutralMesh mesh, std::uint64_t every) {
  for (std::size_t c = 0; c < mesh.cells.size(); c += every) std::swap(mesh.cells[c][0], mesh.cells[c][1]);
  return mesh;
}

/// Layers across z with whole-numbered values.
double in_layers(const Vec3& p) {
  return std::array{0.0, 0.0, 1.0, 1.0, 2.0, 0.0}[static_cast<std::size_t>(std::llround(p.z))];
}

HardCase at_whole_numbers(const std::string& id, const std::string& story, const Field& field,
                          std::vector<double> isovalues, NaiveFailure naive) {
  const NeutralMesh mesh = box_mesh(whole, field);
  return {.id = id,
          .story = story,
          .pack = mesh_of(mesh),
          .isovalues = std::move(isovalues),
          .rays = all_rays_at(mesh, 240, 1),
          .naive = naive,
          .direct_may_fail_by = ties};
}

HardCase in_whole_numbers(const std::string& id, const std::string& story, Rays rays, NaiveFailure naive) {
  return {.id = id,
          .story = story,
          .pack = mesh_of(box_mesh(whole, whole_numbers)),
          .isovalues = {0.5, 1},
          .rays = std::move(rays),
          .naive = naive,
          .direct_may_fail_by = ties};
}

HardCase plane_across(const std::string& id, const std::string& story, const NeutralMesh& mesh, Rays rays,
                      std::vector<double> isovalues, NaiveFailure naive) {
  return {.id = id,
          .story = story,
          .pack = mesh_of(mesh),
          .isovalues = std::move(isovalues),
          .rays = std::move(rays),
          .naive = naive,
          .known = plane_in_box({0, 0, 1}, size),
          .direct_may_fail_by = ties};
}

}  // namespace

std::vector<HardCase> tet_cases() {
  std::vector<HardCase> cases;
  const auto add = [&](HardCase hard_case) { cases.push_back(mesh_case(std::move(hard_case))); };
  const NeutralMesh numbers = box_mesh(whole, whole_numbers);
  const NeutralMesh jittered =
      box_mesh({.cells = {5, 5, 5}, .box = Box3({0, 0, 0}, {5, 5, 5}), .jitter = 0.15}, rough_ball);

  add(plane_across("T01",
                   "Rays through the inside of faces that lie in the surface: by rounding the crossing is outside both "
                   "cells, or inside both.",
                   box_mesh(whole, linear_field({0, 0, 1})), all_rays_at(numbers, 300, 1, false), {2, 3},
                   {"paper float", 46}));
  add(in_whole_numbers("T02", "Rays through shared edges: none, one or all of the cells around may take them.",
                       together({rays_at(numbers, 2, true, 240, 1), rays_at(numbers, 2, false, 120, 2)}),
                       {"paper float", 49}));
  add(in_whole_numbers("T03", "Rays through vertices, where two dozen cells meet.",
                       together({rays_at(numbers, 1, true, 240, 3), rays_at(numbers, 1, false, 120, 4)}),
                       {"paper float", 37}));
  add(in_whole_numbers("T04", "Rays that hold a whole edge: every function of an edge is zero there.",
                       rays_along_edges(numbers, 300, 5), {"paper float", 65}));
  add(in_whole_numbers("T05", "Rays in planes of faces: the plane's equation divides by zero.",
                       rays_in_faces(numbers, 300, 6), {"paper float", 32}));
  add({.id = "T06",
       .story = "Slivers of a volume of 1e-12 between other cells: what divides by the volume loses the surface.",
       .pack = mesh_of(roofs(1e-12)),
       .rays = rays_at_roofs(300, 7),
       .naive = {"sampled 0.5", 95}});
  {
    const Affine stretch{{1e6, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
    Dice dice(8);
    Rays rays;
    while (rays.size() < 240) {
      const Vec3 vertex = to_vec3(jittered.points[static_cast<std::size_t>(dice.below(216))]);
      const Vec3 target = stretch.point(dice.coin() ? vertex : dice.point({0, 0, 0}, size));
      rays.push_back(through(target, dice.direction(), 10));
    }
    add({.id = "T07",
         .story = "Needles a million times as long as they are thick.",
         .pack = mesh_of(moved(jittered, stretch)),
         .isovalues = {0.4},
         .rays = std::move(rays),
         .naive = {"sampled 0.5", 37}});
  }
  add({.id = "T08",
       .story =
           "Cells of no volume at all, which the surface passes: their neighbours leave it on one side and go on on "
           "the other.",
       .pack = mesh_of(roofs(0)),
       .rays = rays_at_roofs(300, 9),
       .naive = {"paper double", 76}});
  {
    NeutralMesh repeated = numbers;
    for (std::size_t c = 0; c < 100; ++c) {
      auto cell = repeated.cells[c * 7];
      cell[1] = cell[2];
      repeated.cells.push_back(cell);
    }
    add({.id = "T09",
         .story = "Cells that name a vertex twice: they are left out, and change nothing.",
         .pack = mesh_of(repeated),
         .isovalues = {0.5, 1},
         .rays = all_rays_at(numbers, 240, 10),
         .naive = {"paper float", 24},
         .direct_may_fail_by = ties});
  }
  add({.id = "T10",
       .story =
           "Points of their own for every cell, at the same places: what orders edges by numbers of points sees no "
           "shared edge.",
       .pack = mesh_of(with_points_apart(numbers)),
       .isovalues = {0.5, 1},
       .rays = all_rays_at(numbers, 240, 11),
       .naive = {"paper float", 21},
       .direct_may_fail_by = ties});
  add({.id = "T11",
       .story = "All cells are turned over: their volumes are negative.",
       .pack = mesh_of(turned_over(numbers, 1)),
       .isovalues = {0.5, 1},
       .rays = all_rays_at(numbers, 240, 12),
       .naive = {"paper float", 31},
       .direct_may_fail_by = ties});
  add({.id = "T12",
       .story = "Every second cell is turned over.",
       .pack = mesh_of(turned_over(numbers, 2)),
       .isovalues = {0.5, 1},
       .rays = all_rays_at(numbers, 240, 13),
       .naive = {"paper float", 23},
       .direct_may_fail_by = ties});
  add(at_whole_numbers("T13", "The isovalue is that of many vertices: the surface has tips there.", whole_numbers,
                       {1, 2}, {"paper float", 15}));
  add(at_whole_numbers("T14", "Both ends of many edges have the isovalue: the surface holds the edge.",
                       [](const Vec3& p) { return std::llround(p.x + p.y) % 3 == 0 ? 1.0 : whole_numbers(p) / 2; }, {1},
                       {"paper float", 7}));
  add(at_whole_numbers("T15", "Whole faces have the isovalue, between cells on both sides or on one.", in_layers,
                       {1, 2}, {"paper float", 6}));
  add(at_whole_numbers("T16", "Whole cells have the isovalue: no gradient, and a crossing where a ray enters them.",
                       [](const Vec3& p) { return p.z > 1.5 && p.z < 3.5 ? 1.0 : 0.0; }, {1}, {"paper float", 5}));
  {
    Rays level = all_rays_at(numbers, 300, 14);
    for (render::Ray& ray : level) {
      ray.origin += 16.0 * ray.direction;
      ray.direction.z = 0;
      ray.origin -= 16.0 * ray.direction;
    }
    level = only(std::move(level), [](const render::Ray& ray) { return ray.direction.length() > 0; });
    add({.id = "T17",
         .story = "Rays along which the field does not change: no crossing, at no t.",
         .pack = mesh_of(box_mesh(whole, linear_field({0, 0, 1}))),
         .isovalues = {1, 2.25, 3},
         .rays = std::move(level),
         .naive = {.reason =
                       "a slope of exactly zero is a miss to all of them; that nothing else is asked here shows it"},
         .known = never});
  }
  {
    const Affine far{{1e-2, 0, 0}, {0, 1e-2, 0}, {0, 0, 1e-2}, {1e6, -3e6, 2e6}};
    add({.id = "T18",
         .story = "Cells of a hundredth, a million from the origin: single precision has no two points in one of them.",
         .pack = mesh_of(moved(jittered, far)),
         .isovalues = {0.4},
         .rays = moved(all_rays_at(jittered, 240, 15, false), far),
         .naive = {.reason =
                       "points are kept from the middle of the mesh on, and rays are moved there in double precision"},
         .cell_edge = 1e-2});
  }
  {
    const NeutralMesh graded =
        box_mesh({.cells = {8, 8, 8}, .box = Box3({0, 0, 0}, {5, 5, 5}), .grading = 1e4}, rough_ball);
    add({.id = "T19",
         .story = "Volumes that differ by a factor of 1e12 in one mesh: a leaf cell at one end holds whole crowds.",
         .pack = mesh_of(graded),
         .isovalues = {-1.9},
         .rays = all_rays_at(graded, 240, 16, false),
         .naive = {"sampled 0.5", 19}});
  }
  {
    const NeutralMesh coarse = box_mesh({.cells = {3, 3, 2}, .box = Box3({0, 0, 0}, {5, 5, 2})}, whole_numbers);
    const NeutralMesh fine = box_mesh({.cells = {5, 5, 3}, .box = Box3({0, 0, 2}, {5, 5, 5})}, whole_numbers);
    const NeutralMesh hanging = beside(coarse, fine);
    Rays rays = all_rays_at(hanging, 240, 17);
    // Cut each ray to one of the parts, up to the layer of points where the parts meet.
    for (std::size_t n = 0; n < rays.size(); ++n) {
      render::Ray& ray = rays[n];
      if (ray.direction.z == 0) continue;
      const double t = (2 - ray.origin.z) / ray.direction.z;
      if (t < 1)
        ray.t_min = std::max(0.0, std::nextafter(t, no_hit));
      else
        ray.t_max = std::nextafter(t, 0.0);
    }
    add({.id = "T20",
         .story =
             "A coarse part beside a fine one, with points that hang in its faces: the field jumps where they meet, "
             "and nowhere else.",
         .pack = mesh_of(hanging),
         .isovalues = {0.5, 1},
         .rays = std::move(rays),
         .naive = {"paper float", 16},
         .direct_may_fail_by = ties});
  }
  {
    NeutralMesh holed = numbers;
    std::size_t n = 0;
    std::erase_if(holed.cells, [&](const auto&) { return n++ % 5 == 0; });
    holed.point_fields[0].values[43] = std::nan("");
    add({.id = "T22",
         .story = "Holes in the mesh and points without data: nothing is crossed where the mesh begins or ends, and a "
                  "side is not carried over a gap.",
         .pack = mesh_of(holed),
         .isovalues = {0.5, 1},
         .rays = all_rays_at(holed, 240, 20),
         .naive = {"paper float", 29},
         .direct_may_fail_by = ties});
  }
  {
    const Affine away{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {8, 1, 0}};
    const NeutralMesh apart = beside(numbers, moved(jittered, away));
    add({.id = "T23",
         .story = "Two bodies apart: a ray leaves the mesh and comes back.",
         .pack = mesh_of(apart),
         .isovalues = {0.4},
         .rays = together({all_rays_at(apart, 200, 21, false), rays_at(apart, 1, true, 100, 22)}),
         .naive = {"sampled 0.5", 45},
         .direct_may_fail_by = ties});
  }
  add({.id = "T24",
       .story = "Cells that reach over many leaf cells: the crossing that is found first may lie behind another.",
       .pack = mesh_of(numbers, {.structure = preprocess::MeshStructure::leaves, .leaf_cells_per_tetrahedron = 40}),
       .isovalues = {0.5, 1},
       .rays = all_rays_at(numbers, 240, 23),
       .naive = {"paper float", 24},
       .direct_may_fail_by = ties});
  {
    const NeutralMesh fitting = box_mesh({.cells = {4, 4, 4}, .box = Box3({0, 0, 0}, {4, 4, 4})}, whole_numbers);
    add({.id = "T25",
         .story =
             "Cells whose sides lie in the planes of the leaf lattice: one that rounding leaves out of a list is a "
             "hole.",
         .pack = mesh_of(fitting, {.structure = preprocess::MeshStructure::leaves, .leaf_cell_count = 64}),
         .isovalues = {0.5, 1},
         .rays = all_rays_at(fitting, 240, 24),
         .naive = {"paper float", 25},
         .direct_may_fail_by = ties});
  }
  {
    NeutralMesh bad = numbers;
    bad.points[40][1] = std::nan("");
    bad.points[90][2] = no_hit;
    bad.point_fields[0].values[100] = no_hit;
    add({.id = "T26",
         .story = "Points that are nowhere, and values that are none: their cells are left out, and all others stay.",
         .pack = mesh_of(bad),
         .isovalues = {0.5, 1},
         .rays = all_rays_at(numbers, 240, 25),
         .naive = {"paper float", 26},
         .direct_may_fail_by = ties});
  }
  {
    std::vector<Rays> parts;
    for (std::size_t corners = 1; corners <= 3; ++corners)
      parts.push_back(rays_at(numbers, corners, true, 100, 26 + corners));
    Rays from_inside = together(parts);
    // Move the origins to the points at which the rays were aimed, exactly.
    for (std::size_t n = 0; n < from_inside.size(); ++n)
      from_inside[n].origin = from_inside[n].at(n % 2 == 0 ? 0.25 : 16);
    add(in_whole_numbers("T28", "The eye is inside a cell, in a face, on an edge or on a vertex.",
                         std::move(from_inside), {"paper float", 50}));
  }
  add({.id = "T32",
       .story = "Samples at even steps: what lies between two of them is lost, and a step back from a border finds a "
                "place that is none.",
       .pack = mesh_of(box_mesh(whole, whole_numbers)),
       .isovalues = {1.9},
       .rays = all_rays_at(numbers, 240, 27, false),
       .naive = {"sampled 0.5", 28}});
  return cases;
}

}  // namespace rhoray::tests
