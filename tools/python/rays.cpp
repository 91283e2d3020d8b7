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
  std::unique_ptr<Made> made;
  interruptible([&](const std::stop_token&) { made = std::make_unique<Made>(arguments...); });
  return made;
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

std::size_t count_of(const Rays& rays) {
  return rays.origins.shape().empty() ? 0 : static_cast<std::size_t>(rays.origins.shape()[0]);
}

/// An array of numpy whose memory nobody has filled: the threads that write it also bring its pages.
template <class T>
class Output {
 public:
  explicit Output(std::vector<std::int64_t> shape) : array_(std::move(shape)) {}
  std::span<T> values() { return {array_.mutable_data(), static_cast<std::size_t>(array_.size())}; }
  py::object array() const { return array_; }

 private:
  py::array_t<T> array_;
};

/// Answers, as a dict of arrays.
template <class Ask>
py::dict hits_of(const Rays& rays, bool proves_errors, bool has_gradient, const Ask& ask) {
  const auto rows = static_cast<std::int64_t>(count_of(rays));
  Output<double> t({rows}), value({rows}), error({proves_errors ? rows : 0}), gradient({has_gradient ? rows : 0, 3});
  Output<std::uint64_t> cell({rows});
  Hits hits{.t = t.values(), .error = error.values(), .value = value.values()};
  hits.gradient = gradient.values(), hits.cell = cell.values();
  interruptible([&](const std::stop_token& stop) { ask(hits, stop); });
  py::dict dict;
  dict["t"] = t.array(), dict["value"] = value.array(), dict["cell"] = cell.array();
  dict["error"] = proves_errors ? error.array() : py::none();
  dict["gradient"] = has_gradient ? gradient.array() : py::none();
  return dict;
}

py::array any_hits(const RayCaster& caster, RenderContext& context, const Rays& rays) {
  std::vector<std::uint8_t> is_hit(count_of(rays));
  interruptible([&](const std::stop_token& stop) { caster.any_hits(rays, is_hit, context, stop); });
  const auto rows = static_cast<std::int64_t>(is_hit.size());
  return array_of(std::move(is_hit), {rows});
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

py::tuple sample(const FieldSampler& sampler, const py::array& points) {
  const ArrayView view = view_of(points, "points");
  const std::int64_t rows = view.shape().empty() ? 0 : view.shape()[0];
  Output<double> values({rows});
  Output<std::uint64_t> cells({rows});
  const std::span<double> of_field = values.values();
  const std::span<std::uint64_t> ids = cells.values();
  interruptible([&](const std::stop_token&) { sampler.at(view, of_field, ids); });
  return py::make_tuple(values.array(), cells.array());
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
           [](const RayCaster& caster, RenderContext& context, const std::string& accuracy, const py::array& origins,
              const py::array& directions, const Limits& t_min, const Limits& t_max) {
             const Rays rays = rays_of(origins, directions, t_min, t_max);
             return hits_of(
                 rays, method_named(accuracy).proves_errors(), true,
                 [&](const Hits& hits, const std::stop_token& stop) { caster.first_hits(rays, hits, context, stop); });
           })
      .def("any_hits",
           [](const RayCaster& caster, RenderContext& context, const py::array& origins, const py::array& directions,
              const Limits& t_min,
              const Limits& t_max) { return any_hits(caster, context, rays_of(origins, directions, t_min, t_max)); })
      .def("all_hits", [](const RayCaster& caster, RenderContext& context, const py::array& origins,
                          const py::array& directions, const Limits& t_min, const Limits& t_max, std::size_t max_hits) {
        return all_hits(caster, context, rays_of(origins, directions, t_min, t_max), max_hits);
      });
  py::class_<FieldSampler>(module, "FieldSampler")
      .def(py::init([](const Dataset& data, const std::string& field, const std::string& accuracy) {
        return make<FieldSampler>(data, field, method_named(accuracy));
      }))
      .def("largest_values",
           [](const FieldSampler& sampler, RenderContext& context, const std::string& accuracy,
              const py::array& origins, const py::array& directions, const Limits& t_min, const Limits& t_max) {
             const Rays rays = rays_of(origins, directions, t_min, t_max);
             return hits_of(rays, method_named(accuracy).proves_errors(), false,
                            [&](const Hits& hits, const std::stop_token& stop) {
                              sampler.largest_values(rays, hits, context, stop);
                            });
           })
      .def("sample", &sample);
}

}  // namespace rhoray::python
