#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "render/ray_caster.h"
#include "tools/lab/hard_cells.h"

namespace rhoray::study {

/// The data that contain a closed isosurface.
enum class SceneKind {
  tets,        ///< wavy ball in a jittered mesh
  tets_whole,  ///< the same with values in coarse steps: many vertices, edges and faces at the
               ///< isovalue
  grid,        ///< ball with as much noise as waves, in single precision
  grid_whole   ///< the same in bytes; the isovalue is one of the values
};
inline constexpr std::array<SceneKind, 4> scene_kinds{SceneKind::tets, SceneKind::tets_whole, SceneKind::grid,
                                                      SceneKind::grid_whole};
const char* name_of(SceneKind kind);

/// Centre of the box around the surface in the world, and the length of the box's edges.
struct Placement {
  Vec3 centre{0, 0, 0};
  double scale = 1;
};

/// A closed isosurface that stays away from its volume's boundary, where the field is outside. Also
/// the targets at which rays are aimed, in the data's frame.
struct ClosedScene {
  render::Dataset dataset;
  double isovalue = 0;
  std::vector<Vec3> vertices{};  ///< samples or points
  std::vector<double> values{};  ///< values at the vertices
  /// of the cells that the surface passes through
  std::vector<std::array<std::uint32_t, 2>> edges{};
  double cell_edge = 1;  ///< approximate edge of a cell, in the frame
  double diagonal = 1;   ///< of the volume's box, in the frame
};

/// @param edge    cells along the box; at least 4
/// @param folder  for the packed file
ClosedScene closed_scene(SceneKind kind, const Placement& placement, std::int64_t edge,
                         const std::filesystem::path& folder);

enum class Aim { anywhere, at_edges, at_vertices };
inline constexpr std::array<Aim, 3> aims{Aim::anywhere, Aim::at_edges, Aim::at_vertices};
const char* name_of(Aim aim);

/// A point to aim at, in the frame. It is on an edge of a cell that the surface passes through (its
/// midpoint, any point, or where the surface passes), at an end of such an edge, or up to four
/// cells away from one.
Vec3 target_of(const ClosedScene& scene, Aim aim, Dice& dice);
/// A point to aim at for a given edge.
Vec3 target_at(const ClosedScene& scene, const std::array<std::uint32_t, 2>& edge, Aim aim, Dice& dice);

/// A random direction of unit length.
Vec3 any_direction(Dice& dice);

/// A ray of the scene's frame that begins and ends outside of the volume. Half of the rays are made
/// in the world and rounded by the transformation into the frame; the others are aimed in the frame
/// itself. Some run along edges, in faces or along diagonals; some start 10,000 diagonals away.
render::Ray ray_at(const ClosedScene& scene, Aim aim, Dice& dice);

}  // namespace rhoray::study
