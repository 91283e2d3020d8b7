#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "tools/python/arrays.h"
#include "tools/python/interruptible.h"
#include "tools/python/module.h"

namespace rhoray::python {

namespace py = pybind11;

namespace {

Vec3 vector_of(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}
py::tuple tuple_of(const Vec3& v) {
  return py::make_tuple(v.x, v.y, v.z);
}

/// A field's facts, as a dict.
py::dict facts_of(const FieldInfo& field, const py::object& owner) {
  py::dict facts;
  facts["name"] = field.name;
  facts["unit"] = field.unit;
  facts["of_cells"] = field.is_of_cells;
  facts["range"] = field.range ? py::object(py::make_tuple(field.range->lo, field.range->hi)) : py::none();
  facts["no_data_count"] = field.no_data_count;
  facts["histogram"] = array_of(std::span<const std::uint64_t>(field.histogram),
                                {static_cast<std::int64_t>(field.histogram.size())}, owner);
  facts["labels"] = field.label_names;
  return facts;
}

py::list fields_of(const py::object& self) {
  py::list list;
  for (const FieldInfo& field : self.cast<const Dataset&>().fields()) list.append(facts_of(field, self));
  return list;
}

struct Field {
  std::string name;
  py::array values;
  std::string unit;
  std::map<int, std::string> labels;
};

std::vector<FieldArray> arrays_of(const std::vector<Field>& fields) {
  std::vector<FieldArray> arrays;
  for (const Field& field : fields)
    arrays.push_back({.name = field.name,
                      .values = view_of(field.values, "'" + field.name + "'"),
                      .unit = field.unit,
                      .label_names = field.labels});
  return arrays;
}

using Progress = std::function<void(std::string, std::uint64_t, std::uint64_t)>;

/// Packs without the GIL.
template <class Pack>
Dataset packed(const std::filesystem::path& file, bool replace, const Progress& progress, const Pack& pack) {
  PackOptions options{.file = file, .replace_existing = replace};
  if (progress)
    options.watch.progress = [&](std::string_view phase, std::uint64_t done, std::uint64_t total) {
      const py::gil_scoped_acquire acquire;
      progress(std::string(phase), done, total);
    };
  std::optional<Dataset> dataset;
  interruptible([&](const std::stop_token& stop) {
    options.watch.stop = stop;
    dataset.emplace(pack(options));
  });
  return std::move(*dataset);
}

Dataset pack_grid(const std::vector<Field>& fields, bool x_first, const std::array<double, 3>& spacing,
                  const std::array<double, 3>& origin, const std::optional<std::array<std::array<double, 3>, 4>>& map,
                  const std::array<std::vector<double>, 3>& positions, const std::string& length_unit,
                  const std::filesystem::path& file, bool replace, const Progress& progress) {
  GridArrays grid{.fields = arrays_of(fields),
                  .spacing = vector_of(spacing),
                  .origin = vector_of(origin),
                  .positions = positions,
                  .length_unit = length_unit};
  if (map)
    grid.world_from_grid =
        Affine{vector_of((*map)[0]), vector_of((*map)[1]), vector_of((*map)[2]), vector_of((*map)[3])};
  return packed(file, replace, progress, [&](const PackOptions& options) {
    return pack(grid, x_first ? AxisOrder::xyz : AxisOrder::zyx, options);
  });
}

Dataset pack_mesh(const py::array& points, const py::array& tetrahedra, const std::vector<Field>& point_fields,
                  const std::vector<Field>& cell_fields, const std::string& length_unit,
                  const std::filesystem::path& file, bool replace, const Progress& progress) {
  const MeshArrays mesh{.points = view_of(points, "points"),
                        .tetrahedra = view_of(tetrahedra, "tetrahedra"),
                        .point_fields = arrays_of(point_fields),
                        .cell_fields = arrays_of(cell_fields),
                        .length_unit = length_unit};
  return packed(file, replace, progress, [&](const PackOptions& options) { return pack(mesh, options); });
}

Dataset pack_surface(const py::array& points, const py::array& triangles, const std::filesystem::path& file,
                     bool replace, const Progress& progress) {
  const SurfaceArrays surface{.points = view_of(points, "points"), .triangles = view_of(triangles, "triangles")};
  return packed(file, replace, progress, [&](const PackOptions& options) { return pack(surface, options); });
}

/// (points, tetrahedra, fields of points, fields of cells), as pack_mesh takes them.
py::tuple unpacked_mesh(const Dataset& data) {
  MeshCopy copy = interruptible([&](const std::stop_token& stop) { return unpack_mesh(data, stop); });
  py::dict of_points, of_cells;
  for (FieldCopy& field : copy.fields) {
    const auto size = static_cast<std::int64_t>(field.values.size());
    py::dict& fields = field.is_of_cells ? of_cells : of_points;
    if (field.is_single_precision)
      fields[py::str(field.name)] = array_of(std::vector<float>(field.values.begin(), field.values.end()), {size});
    else
      fields[py::str(field.name)] = array_of(std::move(field.values), {size});
  }
  const auto points = static_cast<std::int64_t>(copy.points.size());
  const auto tetrahedra = static_cast<std::int64_t>(copy.tetrahedra.size());
  return py::make_tuple(array_of(std::move(copy.points), element_type<double>(), {points, 3}),
                        array_of(std::move(copy.tetrahedra), element_type<std::uint64_t>(), {tetrahedra, 4}), of_points,
                        of_cells);
}

}  // namespace

void define_datasets(py::module_& module) {
  py::class_<Field>(module, "Field").def(py::init<std::string, py::array, std::string, std::map<int, std::string>>());
  py::class_<Dataset>(module, "Dataset")
      .def_static("open",
                  [](const std::filesystem::path& path) {
                    return interruptible([&](const std::stop_token& stop) { return Dataset::open(path, stop); });
                  })
      .def_property_readonly("path",
                             [](const Dataset& data) {
                               const std::string path = data.path().string();
                               return py::reinterpret_steal<py::object>(
                                   PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<Py_ssize_t>(path.size())));
                             })
      .def_property_readonly("kind",
                             [](const Dataset& data) {
                               constexpr const char* kinds[] = {"grid", "tetrahedra", "triangles"};
                               return kinds[static_cast<std::size_t>(data.kind())];
                             })
      .def_property_readonly("bounds",
                             [](const Dataset& data) {
                               const Box3 box = data.bounds();
                               return py::make_tuple(tuple_of(box.min), tuple_of(box.max));
                             })
      .def_property_readonly("length_unit", &Dataset::length_unit)
      .def_property_readonly(
          "notes",
          [](const Dataset& data) { return std::vector<std::string>(data.notes().begin(), data.notes().end()); })
      .def("fields", &fields_of)
      .def("field_name", [](const Dataset& data, const std::string& name) { return data.field(name).name; })
      .def("array_names", &Dataset::array_names)
      .def("array", [](const py::object& self,
                       const std::string& name) { return array_of(self.cast<const Dataset&>().array(name), self); })
      .def("unpack_grid",
           [](const Dataset& data, const std::string& field) {
             GridCopy copy = interruptible([&](const std::stop_token& stop) { return unpack_grid(data, field, stop); });
             return array_of(std::move(copy.samples), copy.type, {copy.shape.begin(), copy.shape.end()});
           })
      .def("unpack_mesh", &unpacked_mesh)
      .def("boundary",
           [](const Dataset& data) {
             return interruptible([&](const std::stop_token& stop) { return data.boundary(stop); });
           })
      .def("boundary",
           [](const Dataset& data, const std::string& field, int label) {
             return interruptible([&](const std::stop_token& stop) { return data.boundary(field, label, stop); });
           })
      .def("damaged_blocks",
           [](const Dataset& data) {
             std::vector<std::pair<std::uint64_t, std::uint64_t>> blocks;
             interruptible([&](const std::stop_token& stop) {
               for (const DamagedBlock& block : data.damaged_blocks(0, stop))
                 blocks.emplace_back(block.first_byte, block.byte_count);
             });
             return blocks;
           })
      .def("save", [](const Dataset& data, const std::filesystem::path& path, bool replace) {
        interruptible([&](const std::stop_token& stop) { data.save(path, replace, stop); });
      });
  module.def("pack_grid", &pack_grid);
  module.def("pack_mesh", &pack_mesh);
  module.def("pack_surface", &pack_surface);
}

}  // namespace rhoray::python
