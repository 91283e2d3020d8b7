#include "preprocess/pack_volume.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/trouble.h"
#include "preprocess/bricks/convert.h"
#include "preprocess/bricks/write_samples.h"
#include "preprocess/inspect/summarize.h"
#include "preprocess/macro_levels/build_levels.h"
#include "preprocess/macro_levels/choose_shape.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

void check_layout(const PackVolumeOptions& options) {
  if (options.brick_edge < 2 || options.brick_edge > 64)
    throw Error(Trouble::usage, concat("brick edge: found ", options.brick_edge, "; expected 2 to 64"));
}

void check_samples(const NeutralVolume& volume, const std::string& source_name) {
  const Index3& n = volume.sample_count;
  constexpr std::int64_t largest_axis = std::int64_t{1} << 20;  // what a reader accepts
  for (const std::int64_t samples : {n.x, n.y, n.z})
    if (samples < 2 || samples > largest_axis)
      throw Error(Trouble::invalid, concat(source_name, ": found ", n.x, " x ", n.y, " x ", n.z,
                                           " samples; expected 2 to ", largest_axis, " on every axis"));
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), formats::element_bytes(volume.type)});
  if (!bytes || *bytes != volume.samples.size())
    throw Error(Trouble::invalid, concat(source_name, ": found ", volume.samples.size(), " bytes of samples; expected ",
                                         n.x, " x ", n.y, " x ", n.z, " of ", formats::element_name(volume.type)));
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_frame(const Affine& world_from_grid, const std::string& source_name) {
  const Affine& map = world_from_grid;
  const double determinant = map.determinant();
  if (!is_finite(map.x_axis) || !is_finite(map.y_axis) || !is_finite(map.z_axis) || !is_finite(map.origin) ||
      !std::isfinite(determinant) || determinant == 0)
    throw Error(Trouble::invalid,
                concat(source_name, ": found grid axes that span a volume of ", determinant,
                       "; expected three independent, finite axes and a finite origin"),
                "give the spacing and the origin yourself");
}

/// A packed grid holds no 64-bit integers.
ElementType stored_type(const NeutralVolume& volume, const PackVolumeOptions& options) {
  const ElementType type = options.type.value_or(volume.type);
  if (type != ElementType::U64 && type != ElementType::I64) return type;
  if (options.type)
    throw Error(Trouble::usage, concat("type: found ", formats::element_name(type),
                                       "; expected U8, I8, U16, I16, U32, I32, F32 or F64"));
  return ElementType::F64;
}

template <class T>
PackVolumeReport pack_samples(const NeutralVolume& volume, const std::filesystem::path& path,
                              const PackVolumeOptions& options, const Progress& progress) {
  const std::span samples(reinterpret_cast<const T*>(volume.samples.data()), volume.samples.size() / sizeof(T));
  PackVolumeReport report;
  formats::GridDescription& grid = report.description;
  grid.layout = options.linear_layout ? formats::BrickLayout::linear(volume.sample_count)
                                      : formats::BrickLayout::bricked(volume.sample_count, options.brick_edge);
  grid.world_from_grid = volume.world_from_grid;
  grid.length_unit = volume.length_unit;
  grid.macro =
      choose_macro_shape(volume.sample_count - Index3(1, 1, 1), options.macro_factor, options.macro_level_count);
  grid.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};

  grid.field = summarize(samples, volume.field_name.empty() ? "value" : volume.field_name, volume.field_unit, progress);
  const Levels<T> levels = build_grid_levels(samples, grid.macro, progress);

  formats::PackedFileWriter writer(path, formats::describe(grid), formats::grid_arrays(grid),
                                   {.replace_existing = options.replace_existing});
  std::uint64_t bytes = sizeof(T);
  for (const std::uint64_t n : grid.layout.shape()) bytes *= n;
  ProgressMeter writing(progress, "writing samples (bytes)", bytes);
  write_samples(samples, grid.layout, writer, writing);
  for (std::size_t l = 0; l < levels.size(); ++l)
    writer.write_all(concat("macro.", l + 1), std::span<const T>(levels[l]));

  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = writer.commit();
  sealing.add(1);
  return report;
}

}  // namespace

PackVolumeReport pack_volume(const NeutralVolume& volume, const std::filesystem::path& path,
                             const PackVolumeOptions& options, const Progress& progress) {
  const std::string source_name = options.source_name.empty() ? "volume" : options.source_name;
  check_layout(options);
  check_samples(volume, source_name);
  check_frame(volume.world_from_grid, source_name);

  // A view of the same samples, until it has to be a converted copy.
  NeutralVolume stored;
  stored.sample_count = volume.sample_count;
  stored.type = volume.type;
  stored.samples = volume.samples;
  stored.world_from_grid = volume.world_from_grid;
  stored.length_unit = volume.length_unit;
  stored.field_name = volume.field_name;
  stored.field_unit = volume.field_unit;
  align_samples(stored);
  convert_samples(stored, stored_type(volume, options), source_name);

  return formats::with_element_type(stored.type, [&]<class T>(T) -> PackVolumeReport {
    if constexpr (sizeof(T) == 8 && std::is_integral_v<T>)
      throw Error(Trouble::internal, "64-bit integers reached the packer of samples");
    else
      return pack_samples<T>(stored, path, options, progress);
  });
}

}  // namespace rhoray::preprocess
