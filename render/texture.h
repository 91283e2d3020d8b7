#pragma once

#include <filesystem>
#include <memory>

#include "formats/color_grid.h"
#include "formats/packed_file.h"
#include "formats/space.h"

namespace rhoray::render {

/// A packed grid of colours in space that covers surfaces, read from the mapped file. Copies share
/// everything.
class Texture {
 public:
  /// Opens a packed file of colours. Block checksums are left to the caller, as with datasets.
  /// Refuses other files.
  /// @param world  as for Dataset::load
  static Texture load(const std::filesystem::path& path, formats::Space world = formats::Space::unknown);
  /// For a file that is already open.
  static Texture load(const formats::PackedFile& file, formats::Space world = formats::Space::unknown);

  const formats::PackedFile& file() const { return grid_->file(); }
  const formats::ColorGrid& grid() const { return *grid_; }
  const Affine& world_from_texels() const { return world_from_texels_; }

  /// False when a plane separates the texels from the box. Only planes along the axes of the world
  /// and of the texels are tested.
  bool may_overlap(const Box3& box_world) const;
  bool contains(const Box3& box_world) const;

 private:
  Texture(std::shared_ptr<const formats::ColorGrid> grid, const Affine& world_from_texels)
      : grid_(std::move(grid)), world_from_texels_(world_from_texels) {}

  std::shared_ptr<const formats::ColorGrid> grid_;
  Affine world_from_texels_;
};

}  // namespace rhoray::render
