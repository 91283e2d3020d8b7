#include "formats/brick_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "formats/base/bytes.h"
#include "formats/base/parallel.h"
#include "formats/details/deep_checks.h"
#include "formats/details/details.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::Json;

constexpr std::string_view grid_kind = "grid";
constexpr std::int64_t largest_brick_edge = 64;
constexpr std::int64_t largest_superbrick_edge = 64;

BrickLayout read_layout(const details::Reader& reader) {
  BrickLayout layout;
  layout.sample_count = reader.index("sample_count", 2, details::largest_axis);
  layout.brick_edge = static_cast<std::int64_t>(reader.count("brick_edge", 1, largest_brick_edge));
  layout.superbrick_edge = reader.index("superbrick_edge", 1, largest_superbrick_edge);
  // Each padded axis is below 2^21, so that three of them fit; with the bytes of a sample they may not.
  const Index3 padded = layout.padded_count();
  if (!checked_product({static_cast<std::uint64_t>(volume(padded)), sizeof(double)}))
    reader.refuse_value("sample_count", "a grid whose size fits 64 bits");
  return layout;
}

Affine read_affine(const details::Reader& reader) {
  const details::Reader axes = reader.object("world_from_grid");
  const Affine affine{axes.vector("x_axis"), axes.vector("y_axis"), axes.vector("z_axis"), axes.vector("origin")};
  const double determinant = affine.determinant();
  if (determinant == 0 || !std::isfinite(determinant))
    reader.refuse_value("world_from_grid", "axes that span a volume");
  return affine;
}

GridDescription read_description(const PackedFile& file) {
  if (file.description().kind != grid_kind)
    refuse(file.name(), "header, __metadata__, kind", concat("'", file.description().kind, "'"), "'grid'");
  const Json json = details::parse(file);
  const details::Reader reader(json, file.name(), "details");
  GridDescription description;
  description.layout = read_layout(reader);
  description.world_from_grid = read_affine(reader);
  description.length_unit = reader.text("length_unit");
  description.field = details::read_field(reader.object("field"));
  description.macro = details::read_macro(reader.object("macro"), description.layout.sample_count - Index3(1, 1, 1));
  description.provenance = details::read_provenance(reader.object("provenance"));
  return description;
}

Json affine_json(const Affine& affine) {
  const std::string_view what = "world_from_grid";
  return {{"x_axis", details::vector_json(affine.x_axis, what)},
          {"y_axis", details::vector_json(affine.y_axis, what)},
          {"z_axis", details::vector_json(affine.z_axis, what)},
          {"origin", details::vector_json(affine.origin, what)}};
}

/// Reads the samples again, by position.
template <class T>
class GridCheck {
 public:
  GridCheck(const BrickGrid& grid, details::Findings& findings)
      : grid_(grid), samples_(grid.samples<T>()), levels_(grid.macro_levels<T>()), findings_(findings) {}

  void run() {
    const std::uint64_t no_data_count = check_field();
    check_padding();
    check_first_level(no_data_count != 0);
    details::check_levels_upward(levels_, "macro levels", findings_);
  }

 private:
  T sample(std::int64_t i, std::int64_t j, std::int64_t k) const { return samples_[grid_.tables().address(i, j, k)]; }
  const BrickLayout& layout() const { return grid_.description().layout; }

  /// Calls act(first, last) on ranges of a z axis, at the same time.
  template <class Act>
  static void over_z(std::int64_t count, Act&& act) {
    for_each_range(static_cast<std::uint64_t>(count), 4, 0, act);
  }

  std::uint64_t check_field() {
    details::FieldTally all(grid_.description().field);
    std::mutex guard;
    over_z(layout().sample_count.z, [&](std::uint64_t first, std::uint64_t last) {
      details::FieldTally part(grid_.description().field);
      details::for_each_cell(layout().sample_count, first, last,
                             [&](std::int64_t i, std::int64_t j, std::int64_t k) { part.take(sample(i, j, k)); });
      const std::lock_guard lock(guard);
      all.take(part);
    });
    all.compare(findings_);
    return all.no_data_count();
  }

  void check_padding() {
    const Index3 count = layout().sample_count, padded = layout().padded_count();
    over_z(padded.z, [&](std::uint64_t first, std::uint64_t last) {
      for (auto k = static_cast<std::int64_t>(first); k < static_cast<std::int64_t>(last); ++k)
        for (std::int64_t j = 0; j < padded.y; ++j)
          for (std::int64_t i = k < count.z && j < count.y ? count.x : 0; i < padded.x; ++i) {
            const T found = sample(i, j, k);
            const T copied = sample(std::min(i, count.x - 1), std::min(j, count.y - 1), std::min(k, count.z - 1));
            if (std::memcmp(&found, &copied, sizeof(T)) == 0) continue;
            findings_.add("padding that is no copy of the last sample", details::linear_order(padded, i, j, k),
                          [&] { return concat("sample (", i, ", ", j, ", ", k, ")"); });
          }
    });
  }

  /// All values that interpolation reaches in the leaf cells from low to high.
  Interval<T> needed(const Index3& low, const Index3& high, bool some_absent) const {
    return some_absent ? needed_by_cells(low, high) : needed_by_samples(low, high);
  }

  /// Where no sample lacks data, every corner counts.
  Interval<T> needed_by_samples(const Index3& low, const Index3& high) const {
    Interval<T> interval;
    for (std::int64_t k = low.z; k <= high.z; ++k)
      for (std::int64_t j = low.y; j <= high.y; ++j)
        for (std::int64_t i = low.x; i <= high.x; ++i) interval.include(sample(i, j, k));
    return interval;
  }

  Interval<T> needed_by_cells(const Index3& low, const Index3& high) const {
    Interval<T> interval;
    for (std::int64_t k = low.z; k < high.z; ++k)
      for (std::int64_t j = low.y; j < high.y; ++j)
        for (std::int64_t i = low.x; i < high.x; ++i) {
          Interval<T> cell;
          bool present = true;
          for (std::int64_t corner = 0; corner < 8; ++corner) {
            const T value = sample(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
            present = present && details::is_value(value);
            cell.include(value);
          }
          if (present) interval.include(cell);
        }
    return interval;
  }

  void check_first_level(bool some_absent) {
    const MacroShape& shape = levels_.shape;
    const Index3 count = shape.count(1), leaves = shape.leaf_count;
    over_z(count.z, [&](std::uint64_t first, std::uint64_t last) {
      details::for_each_cell(count, first, last, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        const Index3 low = Index3(i, j, k) * shape.factor;
        const Index3 high(std::min(low.x + shape.factor, leaves.x), std::min(low.y + shape.factor, leaves.y),
                          std::min(low.z + shape.factor, leaves.z));
        const Interval<T> wanted = needed(low, high, some_absent), stored = levels_.range(1, i, j, k);
        const bool holds = wanted.is_empty() ? stored.is_empty() : stored.lo <= wanted.lo && wanted.hi <= stored.hi;
        if (holds) return;
        findings_.add("an interval that lacks a value of its macrocell", details::linear_order(count, i, j, k), [&] {
          return concat(details::cell_text(1, {i, j, k}), " has ", details::interval_text(stored),
                        ", its samples need ", details::interval_text(wanted));
        });
      });
    });
  }

  const BrickGrid& grid_;
  std::span<const T> samples_;
  MacroLevelsView<T> levels_;
  details::Findings& findings_;
};

}  // namespace

BrickGrid::BrickGrid(PackedFile file) : file_(std::move(file)), description_(read_description(file_)) {
  with_element_type(description_.field.type, [this](auto zero) {
    using T = decltype(zero);
    samples<T>();
    macro_levels<T>();
  });
  // Only now: the tables are no larger than the array whose size has just been checked.
  tables_ = std::make_shared<const AxisTables>(description_.layout);
}

std::vector<ArraySpec> grid_arrays(const GridDescription& description) {
  std::vector<ArraySpec> arrays = macro_arrays(description.macro, 1, description.field.type, "macro.");
  arrays.push_back(
      {.name = "samples", .type = description.field.type, .shape = description.layout.shape(), .alignment = 4096});
  return arrays;
}

FileDescription describe(const GridDescription& description) {
  const BrickLayout& layout = description.layout;
  const Json json{{"sample_count", details::index_json(layout.sample_count)},
                  {"brick_edge", layout.brick_edge},
                  {"superbrick_edge", details::index_json(layout.superbrick_edge)},
                  {"world_from_grid", affine_json(description.world_from_grid)},
                  {"length_unit", description.length_unit},
                  {"field", details::field_json(description.field)},
                  {"macro", details::macro_json(description.macro)},
                  {"provenance", details::provenance_json(description.provenance)}};
  return {.kind = std::string(grid_kind), .required = {}, .details = details::dump(json)};
}

std::vector<std::string> deep_findings(const BrickGrid& grid) {
  details::Findings findings;
  with_element_type(grid.description().field.type, [&](auto zero) { GridCheck<decltype(zero)>(grid, findings).run(); });
  return findings.sentences();
}

}  // namespace rhoray::formats
