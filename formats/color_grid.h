#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/base/affine.h"
#include "formats/brick_grid.h"
#include "formats/brick_layout.h"
#include "formats/packed_file.h"
#include "formats/space.h"

namespace rhoray::formats {

/// Colours on one uniform grid: sRGB with 8 bits per channel. The optional fourth channel is alpha,
/// the share of the background that the colour covers. Texel (i, j, k) has its centre at
/// world_from_grid.point({i, j, k}) and covers half a grid step around it.
struct ColorGridDescription {
  BrickLayout layout;  ///< not sparse; an axis may have a single texel
  Affine world_from_grid;
  std::string length_unit;       ///< of world coordinates; empty: not given by the source
  Space space = Space::unknown;  ///< of world coordinates
  int component_count = 3;       ///< 3: red, green, blue; 4: with alpha
  Provenance provenance;

  bool has_alpha() const { return component_count == 4; }
  Box3 box_grid() const;  ///< box that all texels cover, in the grid's frame
  Box3 bounds() const;    ///< bounds of box_grid() in world axes
};

/// A packed grid of colours, checked and ready for reading. Array "texels" U8 in the layout's
/// shape; the components of a texel are adjacent.
class ColorGrid {
 public:
  static constexpr const char* kind = "colors";

  /// Refuses a file of another kind, and texels whose shape differs from the description.
  explicit ColorGrid(PackedFile file);

  const ColorGridDescription& description() const { return description_; }
  const AxisTables& tables() const { return *tables_; }
  const PackedFile& file() const { return file_; }

  /// The first component of texel (i, j, k) has index component_count * tables().address(i, j, k).
  std::span<const std::uint8_t> texels() const { return texels_; }

 private:
  PackedFile file_;
  ColorGridDescription description_;
  std::span<const std::uint8_t> texels_;
  std::shared_ptr<const AxisTables> tables_;
};

std::vector<ArraySpec> color_grid_arrays(const ColorGridDescription& description);
FileDescription describe(const ColorGridDescription& description);

}  // namespace rhoray::formats
