#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "formats/base/affine.h"
#include "formats/brick_layout.h"
#include "formats/field_summary.h"
#include "formats/macro_levels.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// Where a packed file came from and what packing did to it.
struct Provenance {
  std::string source_name;      ///< file name without folders
  std::string source_checksum;  ///< XXH3-128 of the source's bytes, hexadecimal; empty when not taken
  std::string command;          ///< the command line that made the file
};

/// A scalar grid: sample (i, j, k) stands at world_from_grid.point({i, j, k}); between samples the field is trilinear.
/// Leaf cell (i, j, k) spans samples i..i+1, j..j+1, k..k+1. A cell with a corner that has no data is absent.
struct GridDescription {
  BrickLayout layout;
  Affine world_from_grid;   ///< one grid step to world units; rotated and mirrored axes are kept
  std::string length_unit;  ///< of world coordinates; empty when the source names none
  FieldSummary field;
  MacroShape macro;  ///< macro.leaf_count = layout.sample_count - 1
  Provenance provenance;
};

/// A packed grid, checked and ready for reading. Arrays: "samples" in the layout's shape, "macro.1", "macro.2", ...
class BrickGrid {
 public:
  /// Refuses a file of another kind, or one whose arrays do not have the shapes that its description implies.
  explicit BrickGrid(PackedFile file);

  const GridDescription& description() const { return description_; }
  const AxisTables& tables() const { return *tables_; }
  const PackedFile& file() const { return file_; }

  /// T must be the type of description().field.type.
  template <class T>
  std::span<const T> samples() const {
    return file_.array<T>("samples", description_.layout.shape());
  }
  template <class T>
  MacroLevelsView<T> macro_levels() const {
    return view_macro_levels<T>(file_, description_.macro, 1, "macro.");
  }

 private:
  PackedFile file_;
  GridDescription description_;
  std::shared_ptr<const AxisTables> tables_;
};

/// Declares the arrays of a grid for a writer, in the order in which they should lie in the file.
std::vector<ArraySpec> grid_arrays(const GridDescription& description);
FileDescription describe(const GridDescription& description);

/// Reads every sample and every interval and says what does not hold: an interval that lacks a value of its macrocell,
/// a range or a count that is wrong. Empty when all is well. (`rhoray verify --deep`)
std::vector<std::string> deep_findings(const BrickGrid& grid);

}  // namespace rhoray::formats
