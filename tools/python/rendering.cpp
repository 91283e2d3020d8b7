#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

#include "tools/python/arrays.h"
#include "tools/python/interruptible.h"
#include "tools/python/module.h"

namespace rhoray::python {

namespace py = pybind11;

namespace {

/// A finished picture and what is known of it.
struct Rendered {
  Picture picture;
  Scene scene;
  RenderOptions options;
  Statistics statistics;
  std::string document;
  std::vector<std::string> notes;
};

py::dict dict_of(const Statistics& statistics) {
  py::dict dict;
  dict["rays"] = statistics.rays;
  dict["rays_ruled_out"] = statistics.rays_ruled_out;
  dict["shadow_rays"] = statistics.shadow_rays;
  dict["occlusion_rays"] = statistics.occlusion_rays;
  dict["edge_pixels"] = statistics.edge_pixels;
  dict["hits"] = statistics.hits;
  dict["macrocells_visited"] = statistics.macrocells_visited;
  dict["cells_visited"] = statistics.cells_visited;
  dict["rays_exact"] = statistics.rays_exact;
  dict["largest_error"] = statistics.largest_error;
  dict["preparation_s"] = statistics.preparation_s;
  dict["range_proof_s"] = statistics.range_proof_s;
  dict["wall_s"] = statistics.wall_s;
  return dict;
}

py::dict dict_of(const CheckedPixels& pixels) {
  py::dict dict;
  dict["pixels"] = pixels.pixels;
  dict["shown"] = pixels.shown;
  dict["missed"] = pixels.missed;
  dict["false_hits"] = pixels.false_hits;
  dict["beyond_bound"] = pixels.beyond_bound;
  dict["error_of_99"] = pixels.error_of_99;
  dict["largest_error"] = pixels.largest_error;
  return dict;
}

ChannelSet channels_of(const std::vector<std::string>& names) {
  ChannelSet set;
  const std::pair<const char*, bool*> rows[] = {{"depth", &set.depth}, {"normal", &set.normal}, {"cell", &set.cell},
                                                {"value", &set.value}, {"error", &set.error},   {"cost", &set.cost}};
  for (const std::string& name : names) {
    const auto* const row =
        std::find_if(std::begin(rows), std::end(rows), [&](const auto& each) { return name == each.first; });
    if (row == std::end(rows))
      throw Error(ErrorCode::usage, "channels: '" + name + "'; expected depth, normal, cell, value, error or cost");
    *row->second = true;
  }
  return set;
}

/// Renders a document whose data are given by name.
std::unique_ptr<Rendered> render(RenderContext& context, const std::string& json,
                                 const std::map<std::string, Dataset>& data, const std::vector<std::string>& channels) {
  auto out = std::make_unique<Rendered>();
  interruptible([&](const std::stop_token& stop) {
    const SceneDocument document = SceneDocument::parse(json);
    ResolvedScene resolved = resolve(document, [&](const std::filesystem::path& name) {
      const auto known = data.find(name.string());
      if (known == data.end()) throw Error(ErrorCode::usage, "no data named '" + name.string() + "'");
      return known->second;
    });
    out->document = resolved.document.json();
    out->scene = std::move(resolved.scene), out->options = resolved.options, out->notes = std::move(resolved.notes);
    for (const std::string& warning : document.warnings()) out->notes.push_back(warning);
    out->options.channels = channels_of(channels);
    const RenderResult result = context.render(out->scene, out->options, out->picture, stop);
    if (!result.complete) throw Error(ErrorCode::interrupted, "rendering was interrupted");
    out->statistics = result.statistics;
  });
  return out;
}

std::vector<std::int64_t> shape_of(const Rendered& rendered, std::int64_t components) {
  const Rect window = rendered.picture.window();
  std::vector<std::int64_t> shape{window.height, window.width};
  if (components > 1) shape.push_back(components);
  return shape;
}

/// A channel as a view of the picture's memory, or None.
template <class T>
py::object channel(const py::object& self, std::span<const T> (Picture::*of)() const, std::int64_t components) {
  const auto& rendered = self.cast<const Rendered&>();
  const std::span<const T> values = (rendered.picture.*of)();
  if (values.empty()) return py::none();
  return array_of(values, shape_of(rendered, components), self);
}

py::array srgb8(const Rendered& rendered) {
  const int components = rendered.picture.srgb8_channels();
  const Rect window = rendered.picture.window();
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) *
                                  static_cast<std::size_t>(components));
  rendered.picture.to_srgb8(bytes);
  return array_of(std::move(bytes), shape_of(rendered, components));
}

py::dict verify(const Rendered& rendered, std::uint64_t pixels, std::uint64_t seed) {
  SelfCheck check;
  interruptible([&](const std::stop_token& stop) {
    check = self_check(rendered.scene, rendered.picture, {.pixels = pixels, .seed = seed, .watch = stop});
  });
  py::dict dict;
  dict["random"] = dict_of(check.random);
  dict["edges"] = dict_of(check.edges);
  dict["promise"] = check.promise;
  dict["broken"] = check.broken;
  return dict;
}

}  // namespace

void define_rendering(py::module_& module) {
  py::class_<RenderContext>(module, "RenderContext").def(py::init([](unsigned threads) {
    return std::make_unique<RenderContext>(ContextOptions{.threads = threads});
  }));
  py::class_<Rendered>(module, "Rendered")
      .def_property_readonly("size",
                             [](const Rendered& rendered) {
                               return py::make_tuple(rendered.picture.size().width, rendered.picture.size().height);
                             })
      .def_property_readonly("color", [](const py::object& self) { return channel(self, &Picture::color, 4); })
      .def_property_readonly("depth", [](const py::object& self) { return channel(self, &Picture::depth, 1); })
      .def_property_readonly("normal", [](const py::object& self) { return channel(self, &Picture::normal, 3); })
      .def_property_readonly("cell", [](const py::object& self) { return channel(self, &Picture::cell, 1); })
      .def_property_readonly("value", [](const py::object& self) { return channel(self, &Picture::value, 1); })
      .def_property_readonly("error", [](const py::object& self) { return channel(self, &Picture::error, 1); })
      .def_property_readonly("cost", [](const py::object& self) { return channel(self, &Picture::cost, 1); })
      .def_property_readonly("statistics", [](const Rendered& rendered) { return dict_of(rendered.statistics); })
      .def_readonly("notes", &Rendered::notes)
      .def("srgb8", &srgb8)
      .def("verify", &verify)
      .def_readonly("document", &Rendered::document)
      .def(
          "save_png",
          [](const Rendered& rendered, const std::filesystem::path& path, bool replace) {
            rendered.picture.save_png(path, replace);
          },
          py::call_guard<py::gil_scoped_release>());
  module.def("render", &render);
}

}  // namespace rhoray::python
