#include "render/texture.h"

#include <utility>

#include "formats/base/floating_point.h"

namespace rhoray::render {

namespace {

/// Returns a box around a mapped box.
Box3 around(const Box3& box, const Affine& map) {
  Box3 out;
  if (box.isEmpty()) return out;
  for (int corner = 0; corner < 8; ++corner)
    out.extendBy(map.point(
        {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z}));
  return out;
}

}  // namespace

Texture Texture::load(const std::filesystem::path& path, formats::Space world) {
  const DefaultFloatingPoint default_floating_point;
  return load(formats::PackedFile::open(path), world);
}

Texture Texture::load(const formats::PackedFile& file, formats::Space world) {
  const DefaultFloatingPoint default_floating_point;
  auto grid = std::make_shared<const formats::ColorGrid>(file);
  const formats::ColorGridDescription& texels = grid->description();
  const Affine world_from_texels = formats::in_space(texels.world_from_grid, texels.space, world);
  return Texture(std::move(grid), world_from_texels);
}

bool Texture::may_overlap(const Box3& box_world) const {
  const DefaultFloatingPoint default_floating_point;
  if (box_world.isEmpty()) return false;
  const Box3 texels = grid_->description().box_grid();
  return around(texels, world_from_texels_).intersects(box_world) &&
         texels.intersects(around(box_world, world_from_texels_.inverse()));
}

bool Texture::contains(const Box3& box_world) const {
  const DefaultFloatingPoint default_floating_point;
  const Box3 texels = grid_->description().box_grid(), box = around(box_world, world_from_texels_.inverse());
  return texels.intersects(box.min) && texels.intersects(box.max);
}

}  // namespace rhoray::render
