#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"

namespace rhoray::preprocess {

/// An integer that marks the samples of one object, such as an organ in a segmentation.
struct Label {
  int value = 0;
  Index3 first, end;  ///< box around its samples: first <= (i, j, k) < end
};

inline constexpr std::size_t most_labels = 32;  ///< besides 0, the background

/// The labels of a field, ascending, without 0. Nothing for a field that is no segmentation: one of
/// floating-point numbers, of fewer than two or more than most_labels labels, or one in which more
/// than three in ten neighbours along x differ, where one of them is not 0.
std::optional<std::vector<Label>> find_labels(const formats::BrickGrid& grid, std::size_t field);

/// An integer that marks the cells of one region of a mesh, such as an organ or a material.
struct CellLabel {
  int value = 0;
  /// How many labels, each inside the one before, its boundary hides; 0: none.
  unsigned hidden_count = 0;
};

/// The labels of a field of cells, ascending, with 0. Nothing for a field that is no segmentation:
/// one with a value that is not an integer, or with fewer than two or more than most_labels values.
///
/// Labels with a face on the mesh's boundary are outermost. Another label is inside the outermost
/// label with which it shares a point, or else inside one that is inside that one, and so on.
std::optional<std::vector<CellLabel>> find_labels(const formats::TetMesh& mesh, std::size_t cell_field);

/// Packs the indicator of a label into memory: 1 at its samples, 0 at others. Its isosurface at 1/2
/// is the surface of the label. The grid covers the label's box and one sample around it, where
/// there is one; it lies where the samples lie. If the label has a name, it is that of the value 1.
formats::PackedFile pack_indicator(const formats::BrickGrid& grid, std::size_t field, const Label& label);

}  // namespace rhoray::preprocess
