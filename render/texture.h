#pragma once

#include <filesystem>
#include <memory>

#include "formats/color_grid.h"
#include "formats/packed_file.h"

namespace rhoray::render {

/// A packed grid of colours in space that covers surfaces, read from the mapped file. Copies share
/// everything.
class Texture {
 public:
  /// Opens a packed file of colours. Block checksums are left to the caller, as with datasets.
  /// Refuses other files.
  static Texture load(const std::filesystem::path& path);
  static Texture load(const formats::PackedFile& file);  ///< for a file that is already open

  const formats::PackedFile& file() const { return grid_->file(); }
  const formats::ColorGrid& grid() const { return *grid_; }

  /// False when a plane separates the texels from the box. Only planes along the axes of the world
  /// and of the texels are tested.
  bool may_overlap(const Box3& box_world) const;
  bool contains(const Box3& box_world) const;

 private:
  explicit Texture(std::shared_ptr<const formats::ColorGrid> grid) : grid_(std::move(grid)) {}
  std::shared_ptr<const formats::ColorGrid> grid_;
};

}  // namespace rhoray::render
