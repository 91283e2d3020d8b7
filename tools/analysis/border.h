#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "formats/tet_mesh.h"
#include "render/load.h"
#include "render/ray_caster.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools {

/// Tests whether positions lie inside a mesh.
class MeshPlaces {
 public:
  explicit MeshPlaces(formats::TetMesh mesh);

  /// @param p  in the mesh's frame: relative to its origin. A position on the border is inside, up
  ///           to a ten-thousandth of a cell.
  bool holds(const Vec3& p) const;

 private:
  Index3 bin_of(const Vec3& p) const;
  std::size_t number(const Index3& bin) const {
    return static_cast<std::size_t>((bin.z * bin_count_.y + bin.y) * bin_count_.x + bin.x);
  }
  template <class Act>
  void for_each_bin(std::uint64_t cell, Act&& act) const;

  formats::TetMesh mesh_;
  Box3 box_;
  Index3 bin_count_;
  std::vector<std::uint64_t> offsets_;  ///< first entry of each bin in cells_
  std::vector<std::uint32_t> cells_;    ///< by bin: cells whose box touches it
};

/// The border between a mesh and a grid that it was resampled to. There the grid has no value
/// inside the mesh, or a value outside it. Such differences are caused by the border, whatever the
/// samples are.
class ResampledBorder {
 public:
  ResampledBorder(const render::Dataset& mesh, const render::Dataset& grid);

  /// True if the hits of a ray differ because one is at a position that only the mesh or only the
  /// grid covers. Their t is a distance in the world.
  /// @param truth  hit on the mesh
  /// @param said   hit on the grid
  bool separates(const render::Ray& ray_of_mesh, const render::Hit& truth, const render::Hit& said) const;

 private:
  MeshPlaces places_;
  validate::GridField grid_;
  Affine world_from_mesh_, grid_from_world_;
};

}  // namespace rhoray::tools
