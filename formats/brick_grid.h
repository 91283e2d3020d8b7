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

namespace rhoray::formats {

/// How far a grid's field lies from the field that it was made from, measured at points between and
/// on the samples and kept for every brick of brick_edge samples: brick (a, b, c) answers for the
/// leaf cells whose first sample lies in it. Arrays "error.<f>.max" and "error.<f>.rms" [bz, by,
/// bx]; 0 where nothing was measured.
struct Certificate {
  ElementType type = ElementType::F32;  ///< of both arrays, F32 or F64
  double max_error = 0;                 ///< largest absolute difference, in the field's unit
  double rms_error = 0;                 ///< root of the mean square, over all points measured
  Vec3 max_at{0, 0, 0};                 ///< where the largest was found, world
  std::uint64_t point_count = 0;        ///< points measured

  /// Share of the source's volume, 0 to 1, that lies in leaf cells with a value: the errors are
  /// those in this part. Counted where the source's field has data; null when the writer did not
  /// tell.
  std::optional<double> coverage = std::nullopt;
  /// The largest max_error that was asked for; null when none was.
  std::optional<double> requested_error = std::nullopt;

  static constexpr double whole_coverage = 1 - 1e-6;  ///< counts as all of the source

  /// False when an error was asked for and max_error is larger, or less than all of the source is
  /// covered.
  bool meets_request() const {
    return !requested_error || (max_error <= *requested_error && coverage.value_or(1) >= whole_coverage);
  }

  friend bool operator==(const Certificate&, const Certificate&) = default;
};

/// Scalar fields on one grid. Sample (i, j, k) stands at world_from_grid.point({x_i, y_j, z_k});
/// between samples a field is trilinear in the cell's own coordinates. Leaf cell (i, j, k) spans
/// samples i..i+1, j..j+1, k..k+1. A cell with a corner that has no data is absent.
struct GridDescription {
  BrickLayout layout;
  Affine world_from_grid;  ///< one grid step to world units; rotated and mirrored axes are kept
  /// x_i, y_j, z_k: finite, rising strictly, sample_count of them; an empty axis stands for 0, 1,
  /// 2, ...
  std::array<std::vector<double>, 3> axes;
  std::string length_unit;  ///< of world coordinates; empty when the source names none
  /// at least one; names differ. A sparse layout holds F32 and F64 only
  std::vector<FieldSummary> fields;
  std::map<std::size_t, Certificate> certificates;  ///< by field; of those that have one
  /// macro.leaf_count = layout.sample_count - 1; for every field
  MacroShape macro;
  Provenance provenance;

  bool is_rectilinear() const { return !axes[0].empty() || !axes[1].empty() || !axes[2].empty(); }

  /// Position of sample `i` on an axis, in the frame of world_from_grid.
  double position(int axis, std::int64_t i) const {
    const std::vector<double>& table = axes[static_cast<std::size_t>(axis)];
    return table.empty() ? static_cast<double>(i) : table[static_cast<std::size_t>(i)];
  }
};

// Names of a grid's arrays. The first field has those of files with one field.
std::string samples_array(std::size_t field);  ///< "samples", "field.1.samples", ...
std::string macro_prefix(std::size_t field);   ///< "macro.", "field.1.macro.", ...
std::string axis_array(int axis);              ///< "axis.0", "axis.1", "axis.2"
/// "error.0.max", "error.0.rms", ...
std::string error_array(std::size_t field, std::string_view quantity);

/// A packed grid, checked and ready for reading. Arrays of field f: samples_array(f) in the
/// layout's shape, macro_prefix(f) + level; for all: "bricks" U32 [bz, by, bx] of a sparse layout,
/// axis_array(a) F64 of each axis that has a table, error_array(f, "max" or "rms") of the fields
/// with a certificate.
class BrickGrid {
 public:
  /// The slot of a brick that is not stored.
  static constexpr std::uint32_t no_brick = 0xffffffff;

  /// Refuses a file of another kind, one whose arrays do not have the shapes that its description
  /// implies, an axis table that does not rise, and a table of bricks that names a slot twice, not
  /// at all, or beyond those there are.
  explicit BrickGrid(PackedFile file);

  const GridDescription& description() const { return description_; }
  const AxisTables& tables() const { return *tables_; }
  const PackedFile& file() const { return file_; }

  /// Position of the field of that name, or nothing.
  std::optional<std::size_t> find_field(std::string_view name) const;

  /// In the layout's shape. T must be the field's type.
  template <class T>
  std::span<const T> samples(std::size_t field = 0) const {
    return file_.array<T>(samples_array(field), description_.layout.shape());
  }
  template <class T>
  MacroLevelsView<T> macro_levels(std::size_t field = 0) const {
    return view_macro_levels<T>(file_, description_.macro, 1, macro_prefix(field));
  }

  /// Of a sparse layout, [bz, by, bx]: where each brick lies among the samples, in bricks, or
  /// no_brick.
  std::span<const std::uint32_t> brick_slots() const { return brick_slots_; }

  /// Of a field with a certificate, [bz, by, bx] of bricks. T must be the certificate's type.
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

/// Samples of a sparse grid's field by position: the address among those that are stored, or
/// nothing.
class SparseAddress {
 public:
  static constexpr std::uint64_t no_sample = std::numeric_limits<std::uint64_t>::max();

  /// @param slots  as BrickGrid::brick_slots; these and the tables must outlive this
  SparseAddress(const BrickLayout& layout, const AxisTables& tables, std::span<const std::uint32_t> slots);

  /// Where the sample lies in the array, or no_sample.
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

/// Declares the arrays of a grid for a writer, in the order in which they should lie in the file.
std::vector<ArraySpec> grid_arrays(const GridDescription& description);
FileDescription describe(const GridDescription& description);

/// Writes the axis tables that grid_arrays has declared; nothing for a grid without.
void write_axes(const GridDescription& description, PackedFileWriter& writer);

/// Reads every sample and every interval and says what does not hold: an interval that lacks a
/// value of its macrocell, a range or a count that is wrong, an error that is negative or larger
/// than its certificate says. Empty when all is well. (`rhoray verify --deep`)
std::vector<std::string> deep_findings(const BrickGrid& grid);

}  // namespace rhoray::formats
