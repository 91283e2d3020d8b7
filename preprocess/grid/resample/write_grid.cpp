#include "preprocess/grid/resample/write_grid.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <utility>
#include <variant>

#include "formats/base/parallel.h"
#include "preprocess/grid/resample/neighborhood.h"
#include "preprocess/values/build_levels.h"
#include "preprocess/values/choose_shape.h"
#include "preprocess/values/isosurface_profile.h"
#include "preprocess/values/summarize.h"

namespace rhoray::preprocess {
namespace {

constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);

/// Slots that are written, in order.
std::vector<std::size_t> kept_slots(const BrickSamples& samples) {
  std::vector<std::size_t> kept;
  for (std::size_t slot = 0; slot < samples.inside_counts.size(); ++slot)
    if (samples.inside_counts[slot] > 0 || samples.extended_counts[slot] > 0) kept.push_back(slot);
  return kept;
}

/// Samples beyond the lattice or in missing bricks count as without data; padding does not.
template <class T>
formats::FieldSummary summary_of(const ScalarField& field, const Array<T>& samples, const Index3& sample_count) {
  formats::FieldSummary summary = summarize(std::span<const T>(samples), field.name, field.unit);
  summary.no_data_count = static_cast<std::uint64_t>(volume(sample_count)) - (samples.size() - summary.no_data_count);
  return summary;
}

/// Stores the profile of isosurfaces, from the pairs inside bricks.
template <class T>
void profile_bricks(const Array<T>& samples, const Vec3& spacing, formats::FieldSummary& field) {
  const IsosurfaceProfile none(field);
  if (!none.has_bins()) return;
  constexpr auto edge = static_cast<std::size_t>(SampleLattice::brick_edge);
  constexpr std::array<std::size_t, 3> strides{1, edge, edge * edge};
  const double cell = spacing.x * spacing.y * spacing.z;
  const IsosurfaceProfile sums = parallel_reduce(
      samples.size() / brick_samples, 64, none,
      [&](const IndexRange& part) {
        IsosurfaceProfile profile = none;
        std::array<IsosurfaceProfile::Place, brick_samples> places;
        for (std::size_t slot = part.begin(); slot < part.end(); ++slot) {
          for (std::size_t i = 0; i < brick_samples; ++i) places[i] = none.place(samples[slot * brick_samples + i]);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const double distance = spacing[static_cast<int>(axis)];
            for (std::size_t i = 0; i < brick_samples; ++i)
              if (i / strides[axis] % edge + 1 < edge)
                profile.add(places[i], places[i + strides[axis]], distance, cell / distance);
          }
        }
        return profile;
      },
      [](IsosurfaceProfile a, const IsosurfaceProfile& b) {
        a.add(b);
        return a;
      });
  sums.store((edge - 1.0) / edge, field);
}

/// Builds the macro levels from bricks: a brick of eight samples has two macrocells of four leaf
/// cells on every axis.
template <class T>
Levels<T> macro_levels(const ResampledMesh& grid, std::size_t field, const formats::MacroShape& shape) {
  constexpr std::int64_t per_brick = SampleLattice::brick_edge / 4;
  const Index3 count = shape.count(1);
  Array<T> ranges(static_cast<std::size_t>(2 * volume(count)));
  for (std::size_t m = 0; m < ranges.size(); m += 2) {
    ranges[m] = Interval<T>{}.lo;
    ranges[m + 1] = Interval<T>{}.hi;
  }
  parallel_for(grid.touched.bricks.size(), 64, [&](const IndexRange& part) {
    Neighborhood nearby;
    for (std::size_t slot = part.begin(); slot < part.end(); ++slot) {
      const Index3 brick = grid.touched.at(slot);
      nearby.gather(grid.touched, brick, grid.samples.fields[field]);
      if (nearby.covered_count() == 0) continue;
      for (std::size_t m = 0; m < 8; ++m) {
        const std::size_t x = m % 2, y = m / 2 % 2, z = m / 4;
        Interval<double> range = nearby.is_whole() ? nearby.range_of(4 * x, 4 * y, 4 * z, 5) : Interval<double>{};
        for (std::size_t cell = 0; cell < 64 && !nearby.is_whole(); ++cell) {
          const std::size_t i = 4 * x + cell % 4, j = 4 * y + cell / 4 % 4, k = 4 * z + cell / 16;
          if (!nearby.is_covered(Neighborhood::place(i, j, k))) continue;
          for (const double value : nearby.corners(i, j, k)) range.include(value);
        }
        if (range.is_empty()) continue;
        const Index3 at = brick * per_brick + Index3(Imath::Vec3<std::size_t>(x, y, z));
        const auto place = static_cast<std::size_t>(2 * ((at.z * count.y + at.y) * count.x + at.x));
        ranges[place] = static_cast<T>(range.lo);
        ranges[place + 1] = static_cast<T>(range.hi);
      }
    }
  });
  Levels<T> levels(1, std::move(ranges));
  if (shape.level_count > 1)
    add_levels_above_leaves(levels,
                            {.leaf_count = count, .factor = shape.factor, .level_count = shape.level_count - 1});
  return levels;
}

/// Errors by brick of the whole lattice, 0 where there is no brick.
template <class T>
struct ErrorArrays {
  std::vector<T> max, rms;
};

template <class T>
ErrorArrays<T> errors_by_brick(const FieldErrors& errors, const TouchedBricks& touched) {
  ErrorArrays<T> arrays;
  arrays.max.assign(touched.slots.size(), 0);
  arrays.rms.assign(touched.slots.size(), 0);
  for (std::size_t slot = 0; slot < touched.bricks.size(); ++slot) {
    arrays.max[touched.bricks[slot]] = static_cast<T>(errors.max[slot]);
    arrays.rms[touched.bricks[slot]] = static_cast<T>(errors.rms[slot]);
  }
  return arrays;
}

Affine world_from_grid(const SampleLattice& lattice, const CleanMesh& mesh) {
  return {.x_axis = {lattice.spacing.x, 0, 0},
          .y_axis = {0, lattice.spacing.y, 0},
          .z_axis = {0, 0, lattice.spacing.z},
          .origin = mesh.origin + lattice.low};
}

/// Writes consecutive slots in one piece.
template <class T>
void write_bricks(const Array<T>& samples, const std::vector<std::size_t>& kept, const std::string& array,
                  formats::PackedFileWriter& writer, ProgressMeter& meter) {
  constexpr std::size_t piece = (std::size_t{1} << 20) / (brick_samples * sizeof(T));
  parallel_for_each((kept.size() + piece - 1) / piece, [&](std::size_t p) {
    const std::size_t last = std::min((p + 1) * piece, kept.size());
    for (std::size_t first = p * piece; first < last;) {
      std::size_t end = first + 1;
      while (end < last && kept[end] == kept[end - 1] + 1) ++end;
      const std::span<const T> run(samples.data() + kept[first] * brick_samples, (end - first) * brick_samples);
      writer.write(array, first * brick_samples * sizeof(T), std::as_bytes(run));
      meter.add(run.size_bytes());
      first = end;
    }
  });
}

}  // namespace

void write_grid(const ResampledMesh& grid, const CleanMesh& mesh, const std::vector<ScalarField>& fields,
                const std::string& length_unit, std::optional<double> requested_error,
                const std::filesystem::path& path, const ResampleOptions& options, const Progress& progress,
                ResampleReport& report) {
  const std::vector<std::size_t> kept = kept_slots(grid.samples);
  const Index3 count = grid.lattice.count;
  formats::GridDescription& packed = report.description;
  packed.layout = formats::BrickLayout::sparse(count, kept.size(), SampleLattice::brick_edge);
  packed.world_from_grid = world_from_grid(grid.lattice, mesh);
  packed.length_unit = length_unit;
  packed.macro = choose_macro_shape(count - Index3(1, 1, 1), 4, 3);
  packed.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};

  ProgressMeter ranging(progress, "finding value ranges", fields.size());
  std::vector<std::variant<Levels<float>, Levels<double>>> levels;
  std::vector<std::variant<ErrorArrays<float>, ErrorArrays<double>>> errors;
  std::uint64_t bytes = 0;
  for (std::size_t f = 0; f < fields.size(); ++f) {
    std::visit(
        [&]<class T>(const Array<T>& samples) {
          packed.fields.push_back(summary_of(fields[f], samples, count));
          profile_bricks(samples, grid.lattice.spacing, packed.fields.back());
          levels.emplace_back(macro_levels<T>(grid, f, packed.macro));
          bytes += kept.size() * brick_samples * sizeof(T);
        },
        grid.samples.fields[f]);
    const FieldErrors& field = grid.certificates.fields[f];
    if (field.type == formats::ElementType::F32)
      errors.emplace_back(errors_by_brick<float>(field, grid.touched));
    else
      errors.emplace_back(errors_by_brick<double>(field, grid.touched));
    packed.certificates[f] = {
        .type = field.type,
        .max_error = field.max_error,
        .rms_error = field.rms_error,
        .max_at = packed.world_from_grid.point({field.attained_at[0], field.attained_at[1], field.attained_at[2]}),
        .point_count = field.point_count,
        .coverage = field.coverage,
        .requested_error = f == 0 ? requested_error : std::nullopt};
    ranging.add(1);
  }

  formats::PackedFileWriter writer(path, formats::describe(packed), formats::grid_arrays(packed),
                                   {.replace_existing = options.replace_existing});
  std::vector<std::uint32_t> slots(grid.touched.slots.size(), formats::BrickGrid::no_brick);
  for (std::size_t slot = 0; slot < kept.size(); ++slot)
    slots[grid.touched.bricks[kept[slot]]] = static_cast<std::uint32_t>(slot);
  writer.write_all<std::uint32_t>("bricks", slots);
  ProgressMeter writing(progress, "writing samples", bytes);
  for (std::size_t f = 0; f < fields.size(); ++f) {
    std::visit(
        [&]<class T>(const ErrorArrays<T>& arrays) {
          writer.write_all<T>(formats::error_array(f, "max"), arrays.max);
          writer.write_all<T>(formats::error_array(f, "rms"), arrays.rms);
        },
        errors[f]);
    std::visit(
        [&]<class T>(const Levels<T>& of_field) {
          for (std::size_t l = 0; l < of_field.size(); ++l)
            writer.write_all(concat(formats::macro_prefix(f), l + 1), std::span<const T>(of_field[l]));
        },
        levels[f]);
    std::visit([&](const auto& samples) { write_bricks(samples, kept, formats::samples_array(f), writer, writing); },
               grid.samples.fields[f]);
  }
  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = writer.commit();
  sealing.add(1);
}

}  // namespace rhoray::preprocess
