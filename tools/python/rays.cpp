#include <pybind11/stl.h>

#include "tools/python/arrays.h"
#include "tools/python/interruptible.h"
#include "tools/python/module.h"

namespace rhoray::python {

namespace py = pybind11;

namespace {

/// A caster or sampler, made without the GIL.
template <class Made, class... Arguments>
std::unique_ptr<Made> make(const Arguments&... arguments) {
  return interruptible([&](const std::stop_token& stop) { return std::make_unique<Made>(arguments..., stop); });
}

Method method_named(const std::string& accuracy) {
  const std::pair<const char*, Accuracy> rows[] = {{"preview", Accuracy::preview},
                                                   {"float", Accuracy::float32},
                                                   {"double", Accuracy::float64},
                                                   {"certified", Accuracy::certified},
                                                   {"exact", Accuracy::exact}};
  for (const auto& [name, level] : rows)
    if (accuracy == name) return level;
  throw Error(ErrorCode::usage, "accuracy: '" + accuracy + "'; expected preview, float, double, certified or exact");
}

Rays rays_of(const py::array& origins, const py::array& directions, const std::optional<py::array>& t_min,
             const std::optional<py::array>& t_max) {
  Rays rays{.origins = view_of(origins, "origins"), .directions = view_of(directions, "directions")};
  if (t_min) rays.t_min = view_of(*t_min, "t_min");
  if (t_max) rays.t_max = view_of(*t_max, "t_max");
  return rays;
}

/// The memory of an array that Python has made or checked (_rays.py); None: no memory.
template <class T>
std::span<T> room_in(const py::object& numbers) {
  if (numbers.is_none()) return {};
  auto array = numbers.cast<py::array>();
  return {static_cast<T*>(array.mutable_data()), static_cast<std::size_t>(array.size())};
}

/// The memory of a rhoray.Hits.
Hits room_in_hits(const py::object& hits) {
  return {.t = room_in<double>(hits.attr("t")),
          .error = room_in<double>(hits.attr("error")),
          .value = room_in<double>(hits.attr("value")),
          .gradient = room_in<double>(hits.attr("gradient")),
          .cell = room_in<std::uint64_t>(hits.attr("cell"))};
}

py::dict all_hits(const RayCaster& caster, RenderContext& context, const Rays& rays, std::size_t max_hits) {
  AllHits hits;
  interruptible([&](const std::stop_token& stop) { caster.all_hits(rays, hits, context, max_hits, stop); });
  const auto crossings = static_cast<std::int64_t>(hits.t.size());
  const auto rows = static_cast<std::int64_t>(hits.truncated.size());
  py::dict dict;
  dict["first"] = array_of(std::move(hits.first), {rows + 1});
  dict["t"] = array_of(std::move(hits.t), {crossings});
  dict["error"] = array_of(std::move(hits.error), {crossings});
  dict["cell"] = array_of(std::move(hits.cell), {crossings});
  dict["enters"] = array_of(std::move(hits.enters), {crossings});
  dict["truncated"] = array_of(std::move(hits.truncated), {rows});
  return dict;
}

}  // namespace

void define_rays(py::module_& module) {
  using Limits = std::optional<py::array>;
  py::class_<RayCaster>(module, "RayCaster")
      .def(py::init([](const Dataset& data, std::optional<double> isovalue, const std::string& accuracy,
                       const std::string& field) {
        using Surface = std::variant<Isosurface, Triangles>;
        const Surface surface = isovalue ? Surface(Isosurface{*isovalue}) : Surface(Triangles{});
        return make<RayCaster>(data, surface, method_named(accuracy), field);
      }))
      .def("first_hits",
           [](const RayCaster& caster, RenderContext& context, const py::array& origins, const py::array& directions,
              const Limits& t_min, const Limits& t_max, const py::object& out) {
             const Rays rays = rays_of(origins, directions, t_min, t_max);
             const Hits hits = room_in_hits(out);
             interruptible([&](const std::stop_token& stop) { caster.first_hits(rays, hits, context, stop); });
           })
      .def("any_hits",
           [](const RayCaster& caster, RenderContext& context, const py::array& origins, const py::array& directions,
              const Limits& t_min, const Limits& t_max, const py::object& out) {
             const Rays rays = rays_of(origins, directions, t_min, t_max);
             const std::span<std::uint8_t> is_hit = room_in<std::uint8_t>(out);
             interruptible([&](const std::stop_token& stop) { caster.any_hits(rays, is_hit, context, stop); });
           })
      .def("all_hits", [](const RayCaster& caster, RenderContext& context, const py::array& origins,
                          const py::array& directions, const Limits& t_min, const Limits& t_max, std::size_t max_hits) {
        return all_hits(caster, context, rays_of(origins, directions, t_min, t_max), max_hits);
      });
  py::class_<FieldSampler>(module, "FieldSampler")
      .def(py::init([](const Dataset& data, const std::string& field, const std::string& accuracy) {
        return make<FieldSampler>(data, field, method_named(accuracy));
      }))
      .def("largest_values",
           [](const FieldSampler& sampler, RenderContext& context, const py::array& origins,
              const py::array& directions, const Limits& t_min, const Limits& t_max, const py::object& out) {
             const Rays rays = rays_of(origins, directions, t_min, t_max);
             const Hits hits = room_in_hits(out);
             interruptible([&](const std::stop_token& stop) { sampler.largest_values(rays, hits, context, stop); });
           })
      .def("sample",
           [](const FieldSampler& sampler, const py::array& points, const py::object& values, const py::object& cells) {
             const ArrayView view = view_of(points, "points");
             const std::span<double> of_field = room_in<double>(values);
             const std::span<std::uint64_t> ids = room_in<std::uint64_t>(cells);
             interruptible([&](const std::stop_token& stop) { sampler.at(view, of_field, ids, stop); });
           });
}

}  // namespace rhoray::python
