#include "tools/lab/plain_grid.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "formats/brick_grid.h"

namespace rhoray::study {

namespace {

using formats::ElementType;

formats::BrickGrid open_grid(const std::filesystem::path& path) {
  formats::PackedFile file = formats::PackedFile::open(path);
  if (file.description().kind != "grid")
    throw Error(ErrorCode::usage, concat(path.string(), ": found a packed file of kind '", file.description().kind,
                                         "'; expected a grid"));
  formats::BrickGrid grid(std::move(file));
  if (grid.description().layout.is_sparse || grid.description().is_rectilinear())
    throw Error(ErrorCode::usage,
                concat(path.string(), ": found a sparse grid or one whose spacing varies; expected all samples of a ",
                       "grid with even steps"));
  return grid;
}

std::size_t field_of(const formats::BrickGrid& grid, const std::string& name) {
  if (name.empty()) return 0;
  const std::optional<std::size_t> field = grid.find_field(name);
  if (!field) throw Error(ErrorCode::usage, concat(grid.file().name(), ": found no field '", name, "'"));
  return *field;
}

/// Maps the range from 0 up to the type's largest value, or keeps the values where they are floats.
struct Spread {
  double lo, scale;

  double operator()(double value) const { return (value - lo) * scale; }
};

Spread spread_into(ElementType type, const Interval<double>& range) {
  return formats::with_element_type(type, [&]<class T>(T) {
    if constexpr (std::is_floating_point_v<T>)
      return Spread{0, 1};
    else
      return Spread{range.lo, static_cast<double>(std::numeric_limits<T>::max()) / (range.hi - range.lo)};
  });
}

}  // namespace

preprocess::NeutralVolume plain_grid(const std::filesystem::path& packed_file, const std::string& field) {
  const formats::BrickGrid grid = open_grid(packed_file);
  const formats::GridDescription& description = grid.description();
  const std::size_t index = field_of(grid, field);
  preprocess::NeutralVolume plain;
  plain.sample_count = description.layout.sample_count;
  plain.type = description.fields[index].type;
  plain.field_name = description.fields[index].name;
  const Affine& map = description.world_from_grid;
  plain.world_from_grid = {
      {map.x_axis.length(), 0, 0}, {0, map.y_axis.length(), 0}, {0, 0, map.z_axis.length()}, {0, 0, 0}};
  const Index3 n = plain.sample_count;
  formats::with_element_type(plain.type, [&]<class T>(T) {
    if constexpr (sizeof(T) == 8 && std::is_integral_v<T>) {
      throw Error(ErrorCode::internal, "a packed grid holds no 64-bit integers");
    } else {
      plain.owned_samples.resize(static_cast<std::size_t>(volume(n)) * sizeof(T));
      T* const out = reinterpret_cast<T*>(plain.owned_samples.data());
      const std::span<const T> samples = grid.samples<T>(index);
      parallel_for_each(static_cast<std::size_t>(n.z), [&](std::size_t slice) {
        const auto k = static_cast<std::int64_t>(slice);
        for (std::int64_t j = 0; j < n.y; ++j)
          for (std::int64_t i = 0; i < n.x; ++i) out[(k * n.y + j) * n.x + i] = samples[grid.tables().address(i, j, k)];
      });
    }
  });
  plain.samples = plain.owned_samples;
  return plain;
}

Vec3 spacing_of(const preprocess::NeutralVolume& grid) {
  return {grid.world_from_grid.x_axis.x, grid.world_from_grid.y_axis.y, grid.world_from_grid.z_axis.z};
}

preprocess::NeutralVolume converted(const preprocess::NeutralVolume& grid, ElementType type,
                                    const Interval<double>& range) {
  preprocess::NeutralVolume out;
  out.sample_count = grid.sample_count;
  out.type = type;
  out.field_name = grid.field_name;
  out.world_from_grid = grid.world_from_grid;
  const auto count = static_cast<std::size_t>(volume(grid.sample_count));
  const Spread spread = spread_into(type, range);
  formats::with_element_type(grid.type, [&]<class From>(From) {
    formats::with_element_type(type, [&]<class To>(To) {
      out.owned_samples.resize(count * sizeof(To));
      const From* const from = reinterpret_cast<const From*>(grid.samples.data());
      To* const to = reinterpret_cast<To*>(out.owned_samples.data());
      parallel_for_each(static_cast<std::size_t>(grid.sample_count.z), [&](std::size_t k) {
        const std::size_t slice = count / static_cast<std::size_t>(grid.sample_count.z);
        for (std::size_t s = k * slice; s < (k + 1) * slice; ++s) {
          const double value = spread(static_cast<double>(from[s]));
          to[s] = static_cast<To>(std::is_floating_point_v<To> ? value : std::nearbyint(value));
        }
      });
    });
  });
  out.samples = out.owned_samples;
  return out;
}

double converted_isovalue(double isovalue, ElementType type, const Interval<double>& range) {
  return spread_into(type, range)(isovalue);
}

}  // namespace rhoray::study
