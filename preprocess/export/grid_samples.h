#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/pending_file.h"
#include "formats/base/progress.h"
#include "formats/brick_grid.h"

namespace rhoray::preprocess {

/// One field of a packed grid by sample index, for any layout.
template <class T>
class GridSamples {
 public:
  GridSamples(const formats::BrickGrid& grid, std::size_t field)
      : grid_(grid), field_(field), samples_(grid.samples<T>(field)) {
    if (grid.description().layout.is_sparse)
      sparse_.emplace(grid.description().layout, grid.tables(), grid.brick_slots());
  }

  const formats::FieldSummary& field() const { return grid_.description().fields[field_]; }
  const Index3& sample_count() const { return grid_.description().layout.sample_count; }
  /// NaN where a sparse grid stores nothing.
  T at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    if (!sparse_) return samples_[grid_.tables().address(i, j, k)];
    const std::uint64_t address = (*sparse_)(i, j, k);
    return address == formats::SparseAddress::no_sample ? std::numeric_limits<T>::quiet_NaN() : samples_[address];
  }

  /// Fills `row` with the samples (0, j, k), (1, j, k), ...
  void read_row(std::int64_t j, std::int64_t k, std::span<T> row) const {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = at(static_cast<std::int64_t>(i), j, k);
  }

 private:
  const formats::BrickGrid& grid_;
  std::size_t field_;
  std::span<const T> samples_;
  std::optional<formats::SparseAddress> sparse_;
};

/// A packed grid, and the selected field.
struct OpenedGrid {
  formats::BrickGrid grid;
  std::size_t field = 0;

  const std::string& name() const { return grid.file().name(); }
  const formats::GridDescription& description() const { return grid.description(); }
  const formats::FieldSummary& summary() const { return grid.description().fields[field]; }
};

/// Opens a packed file.
/// @param name  for messages; empty: the path
formats::PackedFile open_packed(const std::filesystem::path& path, const std::string& name);

/// Opens a packed grid. Refuses a file of another kind and a field that it does not have
/// (ErrorCode::usage).
/// @param field  empty = the first
/// @param name   for messages; empty: the path
OpenedGrid open_grid(const std::filesystem::path& path, const std::string& field, const std::string& name = {});

/// Refuses a grid with uneven sample steps (ErrorCode::unsupported), for formats that support only
/// even ones.
void require_even_steps(const OpenedGrid& opened, std::string_view format);

/// Calls act(GridSamples<T>) with the field's type; returns what act returns.
template <class Act>
decltype(auto) with_samples(const OpenedGrid& opened, Act&& act) {
  return formats::with_element_type(opened.summary().type, [&]<class T>(T) -> decltype(auto) {
    return act(GridSamples<T>(opened.grid, opened.field));
  });
}

template <class T>
std::uint64_t sample_bytes(const GridSamples<T>& samples) {
  return static_cast<std::uint64_t>(volume(samples.sample_count())) * sizeof(T);
}

/// Writes all samples, x fastest, from this byte of the file on.
template <class T>
void write_rows(const GridSamples<T>& samples, PendingFile& file, std::uint64_t first_byte, const Progress& progress) {
  const Index3& count = samples.sample_count();
  ProgressMeter meter(progress, "writing samples", sample_bytes(samples));
  std::vector<T> slice(static_cast<std::size_t>(count.x * count.y));
  for (std::int64_t k = 0; k < count.z; ++k) {
    for (std::int64_t j = 0; j < count.y; ++j)
      samples.read_row(
          j, k, std::span(slice).subspan(static_cast<std::size_t>(j * count.x), static_cast<std::size_t>(count.x)));
    const std::span<const std::byte> bytes = std::as_bytes(std::span(slice));
    file.write(first_byte, bytes);
    first_byte += bytes.size();
    meter.add(bytes.size());
  }
}

}  // namespace rhoray::preprocess
