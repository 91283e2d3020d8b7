#include "tools/lab/closed_scenes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/base/text.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "tools/lab/warped_box.h"

namespace rhoray::study {

namespace {

/// Field of a ball of radius 0.3 with waves, in the unit cube. Positive inside.
double wavy_ball(const Vec3& p) {
  const double waves = 0.05 * std::sin(11 * p.x) * std::sin(9 * p.y + 1) + 0.03 * std::cos(17 * p.z);
  return 0.3 + waves - (p - Vec3(0.5)).length();
}

/// A value in [-1, 1], always the same for the same position.
double noise(const Index3& at) {
  const auto hash = static_cast<std::uint64_t>((at.z * 1009 + at.y) * 1013 + at.x + 1) * 0x9e3779b97f4a7c15U;
  return static_cast<double>((hash ^ hash >> 29) >> 40) * 0x1p-23 - 1;
}

Vec3 in_world(const Placement& placement, const Vec3& unit) {
  return placement.centre + placement.scale * (unit - Vec3(0.5));
}

/// Adds the edges between vertices of a cell, if the surface passes through it.
void add_cell(ClosedScene& scene, std::span<const std::uint32_t> vertices, auto&& is_edge) {
  const auto is_inside = [&](std::uint32_t v) { return scene.values[v] >= scene.isovalue; };
  const auto inside = std::count_if(vertices.begin(), vertices.end(), is_inside);
  if (inside == 0 || inside == static_cast<std::ptrdiff_t>(vertices.size())) return;
  for (std::size_t a = 0; a < vertices.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (is_edge(a, b)) scene.edges.push_back({vertices[b], vertices[a]});
}

ClosedScene mesh_scene(bool whole_values, const Placement& placement, std::int64_t edge,
                       const std::filesystem::path& file) {
  preprocess::NeutralMesh mesh = warped_box(edge);
  constexpr double step = 0x1p-5;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 unit(mesh.points[v][0], mesh.points[v][1], mesh.points[v][2]);
    const double value = wavy_ball(unit);
    mesh.point_fields[0].values[v] =
        whole_values ? step * std::round(value / step) : static_cast<double>(static_cast<float>(value));
    const Vec3 world = in_world(placement, unit);
    mesh.points[v] = {world.x, world.y, world.z};
  }
  preprocess::pack_mesh(mesh, file, {.replace_existing = true});

  ClosedScene scene{.dataset = render::Dataset::load(file)};
  const Affine frame_from_world = render::world_from_ray_frame(scene.dataset).inverse();
  for (const auto& point : mesh.points)
    scene.vertices.push_back(frame_from_world.point(Vec3(point[0], point[1], point[2])));
  scene.values.assign(mesh.point_fields[0].values.begin(), mesh.point_fields[0].values.end());
  for (const auto& cell : mesh.cells) {
    std::array<std::uint32_t, 4> vertices;
    for (std::size_t i = 0; i < 4; ++i) vertices[i] = static_cast<std::uint32_t>(cell[i]);
    add_cell(scene, vertices, [](std::size_t, std::size_t) { return true; });
  }
  scene.cell_edge = placement.scale / static_cast<double>(edge);
  return scene;
}

ClosedScene grid_scene(bool whole_values, const Placement& placement, std::int64_t edge,
                       const std::filesystem::path& file) {
  const std::int64_t count = edge + 1;
  preprocess::NeutralVolume volume;
  volume.sample_count = Index3(count);
  volume.type = whole_values ? formats::ElementType::U8 : formats::ElementType::F32;
  volume.field_name = "value";
  const double spacing = placement.scale / static_cast<double>(edge);
  volume.world_from_grid = {{spacing, 0, 0}, {0, spacing, 0}, {0, 0, spacing}, in_world(placement, Vec3(0))};

  std::vector<Vec3> vertices;
  std::vector<double> values;
  const auto append = [&](auto value) {
    const std::size_t at = volume.owned_samples.size();
    volume.owned_samples.resize(at + sizeof value);
    std::memcpy(volume.owned_samples.data() + at, &value, sizeof value);
    values.push_back(static_cast<double>(value));
  };
  for (Index3 at{0, 0, 0}; at.z < count; ++at.z)
    for (at.y = 0; at.y < count; ++at.y)
      for (at.x = 0; at.x < count; ++at.x) {
        const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
        vertices.push_back(p);
        const double value = wavy_ball(p / static_cast<double>(edge)) + 0.08 * noise(at);
        if (whole_values)
          append(static_cast<std::uint8_t>(std::clamp(std::lround(100 + 40 * value), 0L, 255L)));
        else
          append(static_cast<float>(value));
      }
  volume.samples = volume.owned_samples;
  preprocess::pack_volume(volume, file, {.replace_existing = true});

  ClosedScene scene{.dataset = render::Dataset::load(file)};
  scene.isovalue = whole_values ? 100 : 0;
  scene.vertices = std::move(vertices);
  scene.values = std::move(values);
  for (Index3 cell{0, 0, 0}; cell.z < edge; ++cell.z)
    for (cell.y = 0; cell.y < edge; ++cell.y)
      for (cell.x = 0; cell.x < edge; ++cell.x) {
        std::array<std::uint32_t, 8> corners;
        for (std::size_t c = 0; c < 8; ++c) {
          const auto shift = [&](int axis) { return static_cast<std::int64_t>(c >> axis & 1); };
          corners[c] =
              static_cast<std::uint32_t>(((cell.z + shift(2)) * count + cell.y + shift(1)) * count + cell.x + shift(0));
        }
        add_cell(scene, corners, [](std::size_t a, std::size_t b) { return std::has_single_bit(a ^ b); });
      }
  return scene;
}

template <class T>
const T& any_of(const std::vector<T>& list, Dice& dice) {
  return list[static_cast<std::size_t>(dice.below(static_cast<int>(list.size())))];
}

/// One of the 26 directions to the neighbours in a lattice.
Vec3 lattice_direction(Dice& dice) {
  for (;;) {
    const Vec3 d(dice.below(3) - 1, dice.below(3) - 1, dice.below(3) - 1);
    if (d.length2() > 0) return d;
  }
}

Vec3 direction_of(const ClosedScene& scene, Aim aim, Dice& dice) {
  const int kind = aim == Aim::anywhere ? 7 : dice.below(8);
  if (kind == 0) return lattice_direction(dice);
  if (kind == 1) {
    const auto& [a, b] = any_of(scene.edges, dice);
    return (scene.vertices[b] - scene.vertices[a]).normalized();
  }
  return any_direction(dice);
}

/// A point on an edge: its midpoint, any point, or where the surface passes.
Vec3 place_on(const ClosedScene& scene, const std::array<std::uint32_t, 2>& edge, Dice& dice) {
  const Vec3 a = scene.vertices[edge[0]], b = scene.vertices[edge[1]];
  const double f = scene.values[edge[0]] - scene.isovalue, g = scene.values[edge[1]] - scene.isovalue;
  const int kind = dice.below(3);
  const double share = kind == 0 ? 0.5 : kind == 1 || (f >= 0) == (g >= 0) ? dice.unit() : f / (f - g);
  return a + share * (b - a);
}

}  // namespace

const char* name_of(SceneKind kind) {
  constexpr std::array names{"tets", "tets-whole", "grid", "grid-whole"};
  return names[static_cast<std::size_t>(kind)];
}

const char* name_of(Aim aim) {
  constexpr std::array names{"anywhere", "edges", "vertices"};
  return names[static_cast<std::size_t>(aim)];
}

ClosedScene closed_scene(SceneKind kind, const Placement& placement, std::int64_t edge,
                         const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / concat(name_of(kind), ".rho");
  const bool is_mesh = kind == SceneKind::tets || kind == SceneKind::tets_whole;
  const bool whole_values = kind == SceneKind::tets_whole || kind == SceneKind::grid_whole;
  ClosedScene scene = (is_mesh ? mesh_scene : grid_scene)(whole_values, placement, edge, file);
  Box3 box;
  for (const Vec3& vertex : scene.vertices) box.extendBy(vertex);
  scene.diagonal = box.size().length();
  return scene;
}

Vec3 any_direction(Dice& dice) {
  for (;;) {
    const Vec3 d(dice.between(-1, 1), dice.between(-1, 1), dice.between(-1, 1));
    if (d.length2() > 0.01 && d.length2() <= 1) return d.normalized();
  }
}

Vec3 target_at(const ClosedScene& scene, const std::array<std::uint32_t, 2>& edge, Aim aim, Dice& dice) {
  switch (aim) {
    case Aim::at_edges:
      return place_on(scene, edge, dice);
    case Aim::at_vertices:
      return scene.vertices[edge[dice.coin() ? 1 : 0]];
    case Aim::anywhere:
      break;
  }
  // Near the surface, so that many rays graze it.
  return scene.vertices[edge[0]] + 4 * scene.cell_edge * dice.unit() * any_direction(dice);
}

Vec3 target_of(const ClosedScene& scene, Aim aim, Dice& dice) {
  return target_at(scene, any_of(scene.edges, dice), aim, dice);
}

render::Ray ray_at(const ClosedScene& scene, Aim aim, Dice& dice) {
  const Vec3 target = target_of(scene, aim, dice);
  const Vec3 direction = direction_of(scene, aim, dice);
  const int how_far = dice.below(8);
  const double distance = scene.diagonal * (how_far == 0 ? 1e4 : how_far == 1 ? 50 : 2);
  if (dice.coin()) return {.origin = target - (distance / direction.length()) * direction, .direction = direction};

  const Affine& world_from_frame = render::world_from_ray_frame(scene.dataset);
  const Affine frame_from_world = world_from_frame.inverse();
  const Vec3 direction_world = world_from_frame.vector(direction).normalized();
  const double distance_world = distance * world_from_frame.vector(direction).length() / direction.length();
  const Vec3 origin_world = world_from_frame.point(target) - distance_world * direction_world;
  return {.origin = frame_from_world.point(origin_world), .direction = frame_from_world.vector(direction_world)};
}

}  // namespace rhoray::study
