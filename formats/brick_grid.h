#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/affine.h"
#include "formats/base/text.h"
#include "formats/brick_layout.h"
#include "formats/field_summary.h"
#include "formats/macro_levels.h"
#include "formats/packed_file.h"
#include "formats/provenance.h"
#include "formats/space.h"

namespace rhoray::formats {

/// Differences between a grid's field and the field that it was made from. They were measured at
/// points between and on the samples, and are stored for every brick of brick_edge samples. Brick
/// (a, b, c) covers the leaf cells whose first sample lies in it. Arrays "error.<f>.max" and
/// "error.<f>.rms" [bz, by, bx]; 0 where nothing was measured.
struct Certificate {
  ElementType type = ElementType::F32;  ///< element type of both arrays, F32 or F64
  double max_error = 0;                 ///< largest absolute difference, in the field's unit
  double rms_error = 0;                 ///< root of the mean square, over all points measured
  Vec3 max_at{0, 0, 0};                 ///< world position of the largest difference
  std::uint64_t point_count = 0;        ///< points measured

  /// Share of the source's volume, 0 to 1, that lies in leaf cells with a value. The errors
  /// describe this part only. Counted where the source's field has data; null: not recorded by the
  /// writer.
  std::optional<double> coverage = std::nullopt;
  /// Largest max_error that the request allowed; null: no limit was requested.
  std::optional<double> requested_error = std::nullopt;

  static constexpr double whole_coverage = 1 - 1e-6;  ///< from here on, coverage counts as complete

  /// False when a limit was requested and max_error exceeds it, or coverage is below
  /// whole_coverage.
  bool meets_request() const {
    return !requested_error || (max_error <= *requested_error && coverage.value_or(1) >= whole_coverage);
  }

  friend bool operator==(const Certificate&, const Certificate&) = default;
};

/// Scalar fields on one grid. Sample (i, j, k) lies at world_from_grid.point({x_i, y_j, z_k}).
/// Between samples a field is trilinear in the cell's own coordinates. Leaf cell (i, j, k) spans
/// samples i..i+1, j..j+1, k..k+1. A cell is absent if one of its corners has no data.
struct GridDescription {
  BrickLayout layout;
  Affine world_from_grid;  ///< grid steps to world units; may rotate and mirror
  /// x_i, y_j, z_k: finite, strictly increasing, sample_count of them. An empty axis means 0, 1, 2,
  /// ...
  std::array<std::vector<double>, 3> axes;
  std::string length_unit;       ///< of world coordinates; empty: not given by the source
  Space space = Space::unknown;  ///< of world coordinates
  /// at least one, with distinct names; a sparse layout holds only F32 and F64
  std::vector<FieldSummary> fields;
  std::map<std::size_t, Certificate> certificates;  ///< key: field index; only fields with one
  /// for every field; macro.leaf_count = layout.sample_count - 1
  MacroShape macro;
  Provenance provenance;

  bool is_rectilinear() const { return !axes[0].empty() || !axes[1].empty() || !axes[2].empty(); }

  /// Coordinate of sample `i` on an axis, in the frame of world_from_grid.
  double position(int axis, std::int64_t i) const {
    const std::vector<double>& table = axes[static_cast<std::size_t>(axis)];
    return table.empty() ? static_cast<double>(i) : table[static_cast<std::size_t>(i)];
  }
};

// Names of a grid's arrays. Field 0 has the same names as in files with one field.
std::string samples_array(std::size_t field);  ///< "samples", "field.1.samples", ...
std::string macro_prefix(std::size_t field);   ///< "macro.", "field.1.macro.", ...
std::string axis_array(int axis);              ///< "axis.0", "axis.1", "axis.2"
/// "error.0.max", "error.0.rms", ...
std::string error_array(std::size_t field, std::string_view quantity);

/// A packed grid, checked and ready for reading. Arrays of field f: samples_array(f) in the
/// layout's shape, macro_prefix(f) + level. Arrays of the grid: "bricks" U32 [bz, by, bx] in a
/// sparse layout, and axis_array(a) F64 for each axis with a table. Fields with a certificate also
/// have error_array(f, "max" or "rms").
class BrickGrid {
 public:
  /// The slot of a brick that is not stored.
  static constexpr std::uint32_t no_brick = 0xffffffff;

  /// Refuses a file of another kind, arrays whose shapes differ from the description, and an axis
  /// table that does not increase. Also refuses a brick table that names a slot twice, skips a
  /// slot, or names a slot beyond the stored ones.
  explicit BrickGrid(PackedFile file);

  const GridDescription& description() const { return description_; }
  const AxisTables& tables() const { return *tables_; }
  const PackedFile& file() const { return file_; }

  /// Index of the field with this name, or nothing.
  std::optional<std::size_t> find_field(std::string_view name) const;

  /// Stored samples, in the layout's shape. T must be the field's type.
  template <class T>
  std::span<const T> samples(std::size_t field = 0) const {
    return file_.array<T>(samples_array(field), description_.layout.shape());
  }
  template <class T>
  MacroLevelsView<T> macro_levels(std::size_t field = 0) const {
    return view_macro_levels<T>(file_, description_.macro, 1, macro_prefix(field));
  }

  /// For a sparse layout: the slot of each brick in the sample array, or no_brick; [bz, by, bx].
  std::span<const std::uint32_t> brick_slots() const { return brick_slots_; }

  /// Errors of a field with a certificate, per brick, [bz, by, bx]. T must be the certificate's
  /// type.
  template <class T>
  std::span<const T> errors(std::size_t field, std::string_view quantity) const {
    return file_.array<T>(error_array(field, quantity), brick_shape());
  }

 private:
  std::vector<std::uint64_t> brick_shape() const;

  PackedFile file_;
  GridDescription description_;
  std::shared_ptr<const AxisTables> tables_;
  std::span<const std::uint32_t> brick_slots_;
};

/// Finds samples of a sparse grid's field: maps (i, j, k) to the address among the stored samples.
class SparseAddress {
 public:
  static constexpr std::uint64_t no_sample = std::numeric_limits<std::uint64_t>::max();

  /// @param slots  BrickGrid::brick_slots; the slots and the tables must outlive this object
  SparseAddress(const BrickLayout& layout, const AxisTables& tables, std::span<const std::uint32_t> slots);

  /// Index of the sample in the array, or no_sample.
  std::uint64_t operator()(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const std::uint64_t full = tables_->address(i, j, k);
    const std::uint32_t slot = slots_[full >> shift_];
    if (slot == BrickGrid::no_brick) return no_sample;
    return (std::uint64_t{slot} << shift_) | (full & mask_);
  }

 private:
  const AxisTables* tables_;
  std::span<const std::uint32_t> slots_;
  int shift_;           ///< n^3 = 2^shift samples in a brick
  std::uint64_t mask_;  ///< n^3 - 1
};

/// Declares the arrays of a grid for a writer, in file order.
std::vector<ArraySpec> grid_arrays(const GridDescription& description);
FileDescription describe(const GridDescription& description);

/// Writes the axis tables that grid_arrays declared; nothing for a grid without tables.
void write_axes(const GridDescription& description, PackedFileWriter& writer);

/// Reads all samples and intervals and reports what is wrong: an interval that misses a value of
/// its macrocell, a wrong range or count, an error that is negative or exceeds its certificate.
/// Empty when all is well. (`rhoray verify --deep`)
std::vector<std::string> deep_findings(const BrickGrid& grid);

}  // namespace rhoray::formats
