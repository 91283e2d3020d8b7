#pragma once

#include <filesystem>
#include <memory>

#include "formats/color_grid.h"
#include "formats/packed_file.h"

namespace rhoray::render {

/// Colours in space that surfaces are covered with: a packed grid of them, read where it is mapped. Copies share
/// everything.
class Texture {
 public:
  /// Opens a packed file of colours; block checksums are left to the caller, as those of volumes. Refuses other files.
  static Texture load(const std::filesystem::path& path);
  static Texture load(const formats::PackedFile& file);  ///< of a file that is open already

  const formats::PackedFile& file() const { return grid_->file(); }
  const formats::ColorGrid& grid() const { return *grid_; }

  /// False where the texels lie on one side of a plane, and the box on the other; planes along the axes of the world
  /// and of the texels are looked at.
  bool may_overlap(const Box3& box_world) const;
  bool contains(const Box3& box_world) const;

 private:
  explicit Texture(std::shared_ptr<const formats::ColorGrid> grid) : grid_(std::move(grid)) {}
  std::shared_ptr<const formats::ColorGrid> grid_;
};

}  // namespace rhoray::render
