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

Box3 in_texels(const Box3& box_world, const formats::ColorGrid& grid) {
  return around(box_world, grid.description().world_from_grid.inverse());
}

}  // namespace

Texture Texture::load(const std::filesystem::path& path) {
  const DefaultFloatingPoint default_floating_point;
  return load(formats::PackedFile::open(path));
}

Texture Texture::load(const formats::PackedFile& file) {
  const DefaultFloatingPoint default_floating_point;
  return Texture(std::make_shared<const formats::ColorGrid>(file));
}

bool Texture::may_overlap(const Box3& box_world) const {
  const DefaultFloatingPoint default_floating_point;
  if (box_world.isEmpty()) return false;
  const formats::ColorGridDescription& texels = grid_->description();
  return texels.bounds().intersects(box_world) && texels.box_grid().intersects(in_texels(box_world, *grid_));
}

bool Texture::contains(const Box3& box_world) const {
  const DefaultFloatingPoint default_floating_point;
  const Box3 texels = grid_->description().box_grid(), box = in_texels(box_world, *grid_);
  return texels.intersects(box.min) && texels.intersects(box.max);
}

}  // namespace rhoray::render
