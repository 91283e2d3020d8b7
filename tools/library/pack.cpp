#include "rhoray/pack.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <set>
#include <system_error>

#include "formats/base/descriptor.h"
#include "formats/base/invertible.h"
#include "formats/base/stopping.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_surface.h"
#include "preprocess/pack_volume.h"
#include "tools/library/arrays.h"
#include "tools/library/conversions.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

namespace {

constexpr const char* source_name = "arrays";

/// Packers have no stop token: their progress function ends them.
Progress progress_of(const PackOptions& options) {
  return [stop = options.watch.stop, progress = inside::inside_of(options.watch).progress](
             std::string_view phase, std::uint64_t done, std::uint64_t total) {
    end_if_stopped(stop);
    if (progress) progress(phase, done, total);
  };
}

/// Runs a packer. What it calls invalid are the caller's arrays.
template <class Act>
decltype(auto) of_arrays(const Act& act) {
  try {
    return act();
  } catch (const rhoray::Error& error) {
    if (error.code() != rhoray::ErrorCode::invalid) throw;
    throw v0_1::Error(v0_1::ErrorCode::usage, error.what());  // its hint is for users of the program
  }
}

Descriptor file_in_memory() {
  Descriptor memory(::memfd_create("rhoray-packed", MFD_CLOEXEC));
  if (memory.number() < 0)
    throw rhoray::Error(rhoray::ErrorCode::resource, concat("memfd_create: ", std::system_category().message(errno)));
  return memory;
}

/// Makes a packed file and opens it.
/// @param write  (destination, progress): packs
template <class Write>
Dataset packed(const PackOptions& options, const Write& write) {
  if (options.memory == Memory::wrap)
    inside::refuse("PackOptions::memory: only the samples of a grid can be wrapped; expected Memory::copy");
  if (options.owner) inside::refuse("PackOptions::owner: found one; expected none with Memory::copy, which copies");
  if (!options.file.empty()) {
    of_arrays([&] { write(formats::Destination(options.file), progress_of(options)); });
    return inside::opened(options.file, inside::inside_of(options.watch));
  }
  Descriptor memory = file_in_memory();
  of_arrays([&] { write(formats::Destination(memory.number()), progress_of(options)); });
  const auto file = formats::PackedFile::from_descriptor(memory.number(), source_name);
  return Dataset(std::make_shared<const Dataset::Implementation>(
      render::Dataset::load(file, {}, formats::Space::unknown, inside::inside_of(options.watch)), std::move(memory)));
}

std::string name_of(std::string_view list, std::size_t index) {
  return concat(list, "[", index, "]");
}

/// Refuses names that are empty or occur twice.
void check_names(std::string_view list, const std::vector<FieldArray>& fields, std::set<std::string>& known) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].name.empty()) inside::refuse(name_of(list, i), ".name: is empty; expected a name");
    if (!known.insert(fields[i].name).second)
      inside::refuse(name_of(list, i), ".name: '", fields[i].name, "' occurs twice; expected different names");
  }
}

void check_shape(std::string_view name, const ArrayView& array, std::span<const std::int64_t> expected) {
  if (!array.is_given())
    inside::refuse(name, ": not given; expected an array of the shape ", inside::text_of(expected));
  if (!std::equal(array.shape().begin(), array.shape().end(), expected.begin(), expected.end()))
    inside::refuse(name, ": an array of the shape ", inside::text_of(array.shape()), "; expected ",
                   inside::text_of(expected));
}

formats::LabelNames label_names(const FieldArray& field) {
  return {field.label_names.begin(), field.label_names.end()};
}

// ---- grids --------------------------------------------------------------------------------------

/// Numbers of samples along x, y and z, and the distances between neighbours in bytes.
struct Lattice {
  std::int64_t count[3], stride[3];
};

Lattice lattice_of(std::string_view name, const ArrayView& values, AxisOrder order) {
  inside::require_enumerator("AxisOrder", order, AxisOrder::xyz);
  if (!values.is_given()) inside::refuse(name, ": not given; expected an array of three axes");
  if (values.shape().size() != 3)
    inside::refuse(name, ": an array of the shape ", inside::text_of(values.shape()), "; expected three axes");
  Lattice lattice{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t from = order == AxisOrder::xyz ? axis : 2 - axis;
    lattice.count[axis] = values.shape()[from], lattice.stride[axis] = values.strides_bytes()[from];
    if (lattice.count[axis] < 2)
      inside::refuse(name, ": ", lattice.count[axis], " samples along ", "xyz"[axis], "; expected at least 2");
  }
  return lattice;
}

/// Whether the samples stand in memory as a packed file is made of them: x fastest, without gaps.
bool is_plain(const Lattice& lattice, const void* first, std::int64_t bytes) {
  const auto [nx, ny, nz] = lattice.count;
  return lattice.stride[0] == bytes && lattice.stride[1] == bytes * nx && lattice.stride[2] == bytes * nx * ny &&
         reinterpret_cast<std::uintptr_t>(first) % static_cast<std::uintptr_t>(bytes) == 0;
}

/// Copies samples of one size, x fastest.
template <class Bits>
void copy_samples(const Lattice& from, const void* first, std::byte* to, const std::stop_token& stop) {
  const auto [nx, ny, nz] = from.count;
  parallel_for(static_cast<std::size_t>(ny * nz), 64, [&, nx = nx, ny = ny](const IndexRange& rows) {
    end_if_stopped(stop);
    for (std::size_t row = rows.begin(); row < rows.end(); ++row) {
      const auto j = static_cast<std::int64_t>(row) % ny, k = static_cast<std::int64_t>(row) / ny;
      const std::byte* source = static_cast<const std::byte*>(first) + j * from.stride[1] + k * from.stride[2];
      std::byte* target = to + static_cast<std::int64_t>(row) * nx * static_cast<std::int64_t>(sizeof(Bits));
      for (std::int64_t i = 0; i < nx; ++i, source += from.stride[0], target += sizeof(Bits)) {
        Bits bits;  // strides need not keep alignment
        std::memcpy(&bits, source, sizeof(Bits));
        std::memcpy(target, &bits, sizeof(Bits));
      }
    }
  });
}

/// Checks where the samples are.
void place(const GridArrays& grid, const Lattice& lattice, preprocess::NeutralVolume& volume) {
  const auto& positions = grid.positions;
  const bool has_positions = std::any_of(positions.begin(), positions.end(), [](const auto& p) { return !p.empty(); });
  if (has_positions && grid.world_from_grid)
    inside::refuse("GridArrays: positions and world_from_grid are both given; expected one of them");
  if (grid.world_from_grid) {
    volume.world_from_grid = inside::inside_of(*grid.world_from_grid);
  } else if (!has_positions) {
    const double spacing[] = {grid.spacing.x, grid.spacing.y, grid.spacing.z};
    for (const double step : spacing)
      if (!(step > 0 && std::isfinite(step)))
        inside::refuse("GridArrays::spacing: (", spacing[0], ", ", spacing[1], ", ", spacing[2],
                       "); expected finite numbers above 0");
    volume.world_from_grid = {
        {spacing[0], 0, 0}, {0, spacing[1], 0}, {0, 0, spacing[2]}, inside::inside_of(grid.origin)};
  }
  const rhoray::Affine& map = volume.world_from_grid;
  for (const rhoray::Vec3& axis : {map.x_axis, map.y_axis, map.z_axis, map.origin})
    if (!inside::is_finite(inside::outside_of(axis)))
      inside::refuse("GridArrays: its position is not finite; expected finite numbers");
  if (!is_invertible(map))
    inside::refuse("GridArrays::", grid.world_from_grid ? "world_from_grid" : "spacing", ": a cell has the volume ",
                   map.determinant(),
                   "; expected independent axes, and a volume and an inverse within the range of doubles");
  if (!has_positions) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& along = positions[axis];
    const std::string name = concat("GridArrays::positions[", axis, "]");
    if (static_cast<std::int64_t>(along.size()) != lattice.count[axis])
      inside::refuse(name, ": ", along.size(), " numbers; expected ", lattice.count[axis]);
    for (std::size_t i = 0; i < along.size(); ++i)
      if (!std::isfinite(along[i]) || (i > 0 && !(along[i] > along[i - 1])))
        inside::refuse(name, ": ", along[i], " at index ", i, "; expected finite, strictly rising numbers");
    volume.axes[axis] = along;
  }
}

/// Whether a double holds an integer exactly.
template <class T>
bool fits_double(T value) {
  if constexpr (std::is_integral_v<T> && sizeof(T) == 8) {
    const auto rounded = static_cast<double>(value);
    return rounded < 0x1p63 * (std::is_signed_v<T> ? 1 : 2) && static_cast<T>(rounded) == value;
  }
  return true;
}

/// Refuses samples that no double holds.
void require_doubles(std::string_view name, ElementType type, const preprocess::NeutralVolume& volume,
                     const std::stop_token& stop) {
  formats::with_element_type(inside::inside_of(type), [&]<class T>(T) {
    if constexpr (std::is_integral_v<T> && sizeof(T) == 8)
      for_each_until_stopped(0, volume.samples.size() / sizeof(T), light_piece, stop, [&](std::uint64_t at) {
        T value;
        std::memcpy(&value, volume.samples.data() + at * sizeof(T), sizeof(T));
        if (fits_double(value)) return;
        const auto sample = static_cast<std::int64_t>(at);
        const auto& count = volume.sample_count;
        inside::refuse(name, ": sample (", sample % count.x, ", ", sample / count.x % count.y, ", ",
                       sample / count.x / count.y, ") is ", value, ", which does not fit a double exactly");
      });
  });
}

/// Refuses samples that rays cannot read where they are.
void require_wrappable(const std::string& name, const ArrayView& values, const Lattice& lattice) {
  const auto refuse = [&](const auto&... reason) {
    throw v0_1::Error(v0_1::ErrorCode::usage, concat(name, ": cannot be wrapped: ", reason...),
                      "pack it with Memory::copy");
  };
  if (values.type() == ElementType::U64 || values.type() == ElementType::I64)
    refuse("its 64-bit integers have to be converted to doubles");
  const auto bytes = static_cast<std::int64_t>(formats::element_bytes(inside::inside_of(values.type())));
  if (reinterpret_cast<std::uintptr_t>(values.first()) % static_cast<std::uintptr_t>(bytes) != 0)
    refuse("its first sample is not at a multiple of ", bytes, " bytes");
  if (!is_plain(lattice, values.first(), bytes))
    refuse("its strides along x, y and z are ", lattice.stride[0], ", ", lattice.stride[1], " and ", lattice.stride[2],
           " bytes; expected ", bytes, ", ", bytes * lattice.count[0], " and ",
           bytes * lattice.count[0] * lattice.count[1], ": contiguous, x fastest");
}

preprocess::NeutralVolume volume_of(const GridArrays& grid, std::size_t index, AxisOrder order,
                                    const PackOptions& options) {
  const FieldArray& field = grid.fields[index];
  const std::string name = name_of("GridArrays::fields", index) + ".values";
  const Lattice lattice = lattice_of(name, field.values, order);
  preprocess::NeutralVolume volume;
  volume.sample_count = Index3(lattice.count[0], lattice.count[1], lattice.count[2]);
  volume.type = inside::inside_of(field.values.type());
  if (options.memory == Memory::wrap) require_wrappable(name, field.values, lattice);
  place(grid, lattice, volume);
  const std::size_t bytes = formats::element_bytes(inside::inside_of(field.values.type()));
  const void* const first = field.values.first();
  const std::size_t total = static_cast<std::size_t>(field.values.count()) * bytes;
  if (is_plain(lattice, first, static_cast<std::int64_t>(bytes))) {
    volume.samples = {static_cast<const std::byte*>(first), total};
  } else {
    volume.owned_samples.resize(total);
    std::byte* const to = volume.owned_samples.data();
    if (bytes == 1) copy_samples<std::uint8_t>(lattice, first, to, options.watch.stop);
    if (bytes == 2) copy_samples<std::uint16_t>(lattice, first, to, options.watch.stop);
    if (bytes == 4) copy_samples<std::uint32_t>(lattice, first, to, options.watch.stop);
    if (bytes == 8) copy_samples<std::uint64_t>(lattice, first, to, options.watch.stop);
    volume.samples = volume.owned_samples;
  }
  require_doubles(name, field.values.type(), volume, options.watch.stop);
  volume.length_unit = grid.length_unit;
  volume.field_name = field.name, volume.field_unit = field.unit;
  volume.label_names = label_names(field);
  return volume;
}

/// Packs ranges and descriptions without the samples, and opens the result with the caller's
/// samples.
Dataset wrapped(const std::vector<preprocess::NeutralVolume>& volumes, const PackOptions& options) {
  if (!options.file.empty())
    inside::refuse("PackOptions::file: found ", options.file.string(),
                   "; expected none with Memory::wrap, which writes no samples");
  Descriptor memory = file_in_memory();
  const preprocess::PackVolumeReport report = of_arrays([&] {
    return preprocess::pack_grid(
        volumes, formats::Destination(memory.number()),
        {.order = preprocess::SampleOrder::linear, .source_name = source_name, .leaves_out_samples = true},
        progress_of(options));
  });
  std::vector<formats::OutsideArray> samples;
  for (std::size_t f = 0; f < volumes.size(); ++f) samples.push_back({report.left_out[f], volumes[f].samples});
  const auto file = formats::PackedFile::from_descriptor(memory.number(), source_name, samples, options.owner);
  return Dataset(std::make_shared<const Dataset::Implementation>(
      render::Dataset::load(file, {}, formats::Space::unknown, inside::inside_of(options.watch)), std::move(memory),
      inside::Origin{.is_wrapped = true}));
}

// ---- meshes and surfaces ------------------------------------------------------------------------

preprocess::Array<std::array<double, 3>> points_of(std::string_view name, const ArrayView& array,
                                                   const std::stop_token& stop) {
  inside::require_floats(array, name, -1, 3);
  preprocess::Array<std::array<double, 3>> points(static_cast<std::size_t>(array.shape()[0]));
  for_each_until_stopped(0, points.size(), light_piece, stop, [&](std::uint64_t p) {
    const Vec3 point = inside::vector(array, static_cast<std::int64_t>(p));
    if (!inside::is_finite(point))
      inside::refuse(name, ": point ", p, " is (", point.x, ", ", point.y, ", ", point.z, "); expected finite numbers");
    points[p] = {point.x, point.y, point.z};
  });
  return points;
}

/// Calls take(column, index) for every index of an array of the shape [n, columns].
template <class Take>
void for_each_index(std::string_view name, const ArrayView& array, std::int64_t columns, std::size_t point_count,
                    const std::stop_token& stop, const Take& take) {
  if (!array.is_given()) inside::refuse(name, ": not given; expected integers of the shape [n, ", columns, "]");
  if (array.shape().size() != 2 || array.shape()[1] != columns)
    inside::refuse(name, ": an array of the shape ", inside::text_of(array.shape()), "; expected [n, ", columns, "]");
  formats::with_element_type(inside::inside_of(array.type()), [&]<class T>(T) {
    if constexpr (std::is_integral_v<T>) {
      const auto rows = static_cast<std::uint64_t>(array.shape()[0]);
      for_each_until_stopped(0, rows, light_piece, stop, [&](std::uint64_t row) {
        for (std::int64_t column = 0; column < columns; ++column) {
          const T index = inside::element<T>(array, static_cast<std::int64_t>(row), column);
          if (std::cmp_less(index, 0) || std::cmp_greater_equal(index, point_count))
            inside::refuse(name, "[", row, "][", column, "]: found ", index, "; expected an index of ", point_count,
                           " points");
          take(column, static_cast<std::uint64_t>(index));
        }
      });
    } else {
      inside::refuse(name, ": floating-point numbers; expected integers");
    }
  });
}

std::vector<preprocess::NeutralField> fields_of(std::string_view list, const std::vector<FieldArray>& fields,
                                                std::int64_t count, const std::stop_token& stop) {
  std::vector<preprocess::NeutralField> out;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const ArrayView& values = fields[i].values;
    check_shape(name_of(list, i) + ".values", values, std::array{count});
    preprocess::NeutralField& field = out.emplace_back();
    field.name = fields[i].name, field.unit = fields[i].unit;
    field.label_names = label_names(fields[i]);
    field.values.resize(static_cast<std::size_t>(count));
    formats::with_element_type(inside::inside_of(values.type()), [&]<class T>(T) {
      field.was_single_precision = std::is_same_v<T, float> || sizeof(T) <= 2;
      for_each_until_stopped(0, field.values.size(), light_piece, stop, [&](std::uint64_t v) {
        const T value = inside::element<T>(values, static_cast<std::int64_t>(v));
        field.values[v] = static_cast<double>(value);
        if (!fits_double(value))
          inside::refuse(name_of(list, i), ".values[", v, "]: ", value, " does not fit a double exactly");
      });
    });
  }
  return out;
}

}  // namespace

Dataset pack(const GridArrays& grid, AxisOrder order, const PackOptions& options) {
  return inside::guarded([&] {
    inside::require_enumerator("PackOptions::memory", options.memory, Memory::wrap);
    if (grid.fields.empty()) inside::refuse("GridArrays::fields: found none; expected at least one");
    std::set<std::string> names;
    check_names("GridArrays::fields", grid.fields, names);
    for (std::size_t i = 1; i < grid.fields.size(); ++i)
      check_shape(name_of("GridArrays::fields", i) + ".values", grid.fields[i].values, grid.fields[0].values.shape());
    std::vector<preprocess::NeutralVolume> volumes;
    volumes.reserve(grid.fields.size());  // a volume's span is of its own samples
    for (std::size_t i = 0; i < grid.fields.size(); ++i) {
      end_if_stopped(options.watch.stop);
      volumes.push_back(volume_of(grid, i, order, options));
    }
    if (options.memory == Memory::wrap) return wrapped(volumes, options);
    return packed(options, [&](const formats::Destination& destination, const Progress& progress) {
      preprocess::pack_grid(volumes, destination,
                            {.source_name = source_name, .replace_existing = options.replace_existing}, progress);
    });
  });
}

Dataset pack(const MeshArrays& arrays, const PackOptions& options) {
  return inside::guarded([&] {
    end_if_stopped(options.watch.stop);
    preprocess::NeutralMesh mesh;
    mesh.points = points_of("MeshArrays::points", arrays.points, options.watch.stop);
    for_each_index("MeshArrays::tetrahedra", arrays.tetrahedra, 4, mesh.points.size(), options.watch.stop,
                   [&](std::int64_t column, std::uint64_t index) {
                     if (column == 0) mesh.cells.emplace_back();
                     mesh.cells.back()[static_cast<std::size_t>(column)] = index;
                   });
    if (mesh.cells.empty()) inside::refuse("MeshArrays::tetrahedra: found none; expected at least one");
    std::set<std::string> names;
    check_names("MeshArrays::point_fields", arrays.point_fields, names);
    check_names("MeshArrays::cell_fields", arrays.cell_fields, names);
    mesh.point_fields = fields_of("MeshArrays::point_fields", arrays.point_fields,
                                  static_cast<std::int64_t>(mesh.points.size()), options.watch.stop);
    mesh.cell_fields = fields_of("MeshArrays::cell_fields", arrays.cell_fields,
                                 static_cast<std::int64_t>(mesh.cells.size()), options.watch.stop);
    mesh.length_unit = arrays.length_unit;
    return packed(options, [&](const formats::Destination& destination, const Progress& progress) {
      preprocess::PackMeshOptions pack{.source_name = source_name, .replace_existing = options.replace_existing};
      preprocess::give_fields(mesh, pack.cells_to_points);
      preprocess::pack_mesh(mesh, destination, pack, progress);
    });
  });
}

Dataset pack(const SurfaceArrays& arrays, const PackOptions& options) {
  return inside::guarded([&] {
    end_if_stopped(options.watch.stop);
    preprocess::NeutralSurface surface;
    surface.points = points_of("SurfaceArrays::points", arrays.points, options.watch.stop);
    for_each_index("SurfaceArrays::triangles", arrays.triangles, 3, surface.points.size(), options.watch.stop,
                   [&](std::int64_t column, std::uint64_t index) {
                     surface.facet_corners.push_back(index);
                     if (column == 2) surface.facet_offsets.push_back(surface.facet_corners.size());
                   });
    if (surface.facet_corners.empty()) inside::refuse("SurfaceArrays::triangles: found none; expected at least one");
    return packed(options, [&](const formats::Destination& destination, const Progress& progress) {
      preprocess::pack_surface(surface, destination,
                               {.source_name = source_name, .replace_existing = options.replace_existing}, progress);
    });
  });
}

}  // namespace rhoray::v0_1
