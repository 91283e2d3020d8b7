// Fuzzes with packed files that are sealed but not sound. What the readers of the library accept is
// examined, rendered and exported. RHORAY_MACHINE selects the instruction set of the rendering
// kernels: scalar or baseline.
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>

#include "formats/base/checks.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/export_grid.h"
#include "preprocess/export_tets.h"
#include "preprocess/subdivide.h"
#include "preprocess/unpack_mesh.h"
#include "render/render.h"
#include "tests/fuzz/guarded.h"
#include "tests/fuzz/harness.h"
#include "tests/fuzz/packed_mutator.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rhoray;
using render::Method;

/// Calls act(). Refusals must be well formed; any other exception ends the program.
template <class Act>
void attempt(Act&& act) {
  try {
    act();
  } catch (const Error& error) {
    tests::check_refusal(error);
  }
}

/// The value at a fraction of a field's range; 0 for a field without values.
double value_at(const formats::FieldSummary& field, double share) {
  return field.range.is_empty() ? 0 : (1 - share) * field.range.lo + share * field.range.hi;
}

Interval<double> window_of(const formats::FieldSummary& field) {
  if (field.range.is_empty() || !(field.range.lo < field.range.hi)) return {0, 1};
  return field.range;
}

/// Renders one file in several ways.
class Pictures {
 public:
  Pictures(const render::Dataset& dataset, render::RenderContext& memory) : dataset_(dataset), memory_(memory) {
    const Box3 box = dataset.bounds();
    if (!box.isEmpty()) {
      base_.camera = render::fit_camera(box, render::named_view("iso"), 1);
      size_ = (box.max - box.min).length();
      middle_ = 0.5 * (box.min + box.max);
    }
  }

  void draw() {
    if (dataset_.is_surface()) return draw_triangles();
    const formats::FieldSummary& field = dataset_.field();
    render::Layer surface;
    surface.isovalue = value_at(field, 0.5);
    surface.method = render::default_method(dataset_, render::Mode::isosurface);

    frame(surface, 16, [&](render::Scene& scene) { light(scene); });
    frame(mip(field), 8);
    frame(slice(field), 8);
    frame(with_method(surface, {.algorithm = Method::Algorithm::certified}), 8, {}, {.error = true});
    frame(with_method(surface, {.algorithm = Method::Algorithm::direct}), 8, {},
          {.depth = true, .normal = true, .cell = true});
    frame(with_method(surface, {.algorithm = Method::Algorithm::paper}), 4);
    frame(with_method(surface, {.algorithm = Method::Algorithm::preview, .precision = Method::Precision::float32}), 4);
    frame(with_method(surface, {.algorithm = Method::Algorithm::sampled}), 2);
    frame(with_method(surface, {.algorithm = Method::Algorithm::exact}), 2);
    options_.use_hierarchy = false;
    frame(with_method(surface, {}), 2);
    options_.use_hierarchy = true;

    clear(surface, field);
    colored(surface, field);
    attempt([&] { (void)dataset_.isosurface_bounds(surface.isovalue); });
    if (dataset_.is_mesh()) attempt([&] { Pictures(dataset_.boundary(), memory_).draw(); });
  }

 private:
  using Change = std::function<void(render::Scene&)>;

  static render::Layer with_method(render::Layer layer, const Method& method) {
    layer.method = method;
    return layer;
  }

  void frame(const render::Layer& layer, int edge, const Change& change = {}, const render::ChannelSet& channels = {}) {
    attempt([&] {
      render::Scene scene = base_;
      scene.layers = {layer};
      if (change) change(scene);
      options_.width = options_.height = edge;
      options_.channels = channels;
      options_.threads = 1;
      render::Framebuffer framebuffer;
      render::render(dataset_, scene, options_, framebuffer, memory_);
      RHORAY_CHECK(framebuffer.color.size() == 4 * framebuffer.pixel_count());
    });
  }

  /// Adds shadows of both kinds of light, ambient occlusion and fog.
  void light(render::Scene& scene) const {
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {0.3, -0.8, 0.5}, .casts_shadows = true},
                    {.kind = render::Light::Kind::point,
                     .place = scene.camera.position,
                     .casts_shadows = true,
                     .size = 0.01 * size_,
                     .samples = 2}};
    scene.occlusion = {.samples = 2, .radius = 0.1 * size_};
    if (size_ > 0 && std::isfinite(size_)) scene.fog = render::Fog{.range = {0, 2 * size_}};
  }

  render::Layer mip(const formats::FieldSummary& field) const {
    render::Layer layer;
    layer.mode = render::Mode::mip;
    layer.method = render::default_method(dataset_, layer.mode);
    layer.window = window_of(field);
    return layer;
  }

  render::Layer slice(const formats::FieldSummary& field) const {
    render::Layer layer;
    layer.mode = render::Mode::slice;
    layer.plane = {middle_, {0.2, 1, 0.3}};
    layer.material.color_by = render::FieldColors{.field = field.name, .range = window_of(field)};
    return layer;
  }

  /// Renders two transparent surfaces in a clip region.
  void clear(const render::Layer& surface, const formats::FieldSummary& field) {
    render::Layer outer = surface, inner = surface;
    outer.isovalue = value_at(field, 0.25);
    inner.isovalue = value_at(field, 0.75);
    outer.material.opacity = inner.material.opacity = 0.4;
    frame(outer, 8, [&](render::Scene& scene) {
      scene.layers.push_back(inner);
      scene.clip = render::Clip{.planes = {{middle_, {1, 0.1, 0}}}, .cuts_away = true};
    });
  }

  /// Renders a surface coloured by the last field, with smooth normals where there are any.
  void colored(render::Layer surface, const formats::FieldSummary& field) {
    const std::vector<std::string> names = dataset_.field_names();
    surface.material.color_by = render::FieldColors{.field = names.back(), .range = window_of(field)};
    if (dataset_.is_mesh()) surface.material.normals = render::Normals::smooth;
    frame(surface, 8, [](render::Scene& scene) { scene.camera.orthographic = true; });
  }

  void draw_triangles() {
    render::Layer layer;
    layer.mode = render::Mode::triangles;
    layer.method = render::default_method(dataset_, layer.mode);
    frame(layer, 16, [&](render::Scene& scene) { light(scene); });
    frame(with_method(layer, {}), 8, {}, {.depth = true, .normal = true, .cell = true});
    layer.material.opacity = 0.4;
    layer.material.normals = render::Normals::smooth;
    frame(layer, 8);
    if (!dataset_.has_fields()) return;
    layer.material.color_by =
        render::FieldColors{.field = dataset_.field_names().back(), .range = window_of(dataset_.field())};
    frame(layer, 8, {}, {.value = true});
  }

  const render::Dataset& dataset_;
  render::RenderContext& memory_;
  render::Scene base_;
  render::FrameOptions options_;
  Vec3 middle_{0, 0, 0};
  double size_ = 1;
};

/// Renders every field twice, with the RenderContext of the last frame.
void draw(const formats::PackedFile& file) {
  render::RenderContext memory;
  const render::Dataset first = render::Dataset::load(file);
  Pictures(first, memory).draw();
  const std::vector<std::string> names = first.field_names();
  if (names.size() > 1)
    attempt([&] {
      const render::Dataset last = render::Dataset::load(file, names.back());
      Pictures(last, memory).draw();
    });
}

/// Uses the data as colours on a sound surface.
void cover(const formats::PackedFile& file) {
  static const render::Dataset surface =
      render::Dataset::load(std::filesystem::path(RHORAY_RELEASED_FILES) / "1.3-surface.rho");
  render::Scene scene;
  scene.layers.front().mode = render::Mode::triangles;
  scene.layers.front().method = {};
  scene.layers.front().material.texture = render::Texture::load(file);
  scene.camera = render::fit_camera(surface.bounds(), render::named_view("iso"), 1);
  render::Framebuffer framebuffer;
  render::render(surface, scene, {.width = 16, .height = 16, .threads = 1}, framebuffer);
}

const std::filesystem::path& output_folder() {
  static const tests::TemporaryFolder folder;
  return folder.path();
}

template <class Write>
void export_to(const char* name, const Write& write) {
  const std::filesystem::path path = output_folder() / name;
  attempt([&] {
    const preprocess::ExportReport report = write(path);
    RHORAY_CHECK(report.file_bytes == std::filesystem::file_size(path));
  });
}

/// Exports that need no separate process; the separate processes read with the same functions.
void export_grid(const std::string& path) {
  const preprocess::ExportOptions options{.replace_existing = true};
  export_to("a.nii", [&](const auto& output) { return preprocess::export_nifti(path, output, options); });
  export_to("a.npy", [&](const auto& output) { return preprocess::export_npy(path, output, options); });
  export_to("a.vti", [&](const auto& output) { return preprocess::export_vti(path, output, options); });
}

void export_tets(const std::string& path, const formats::TetMesh& mesh) {
  const preprocess::ExportOptions options{.replace_existing = true};
  attempt([&] { (void)preprocess::unpack_mesh(mesh); });
  const double isovalue = value_at(mesh.description().fields.front(), 0.5);
  for (const std::optional<double> iso : {std::optional<double>{}, std::optional(isovalue)})
    export_to("a.stl", [&](const auto& output) { return preprocess::export_tets_stl(path, iso, output, options); });
}

void look_into(const formats::PackedFile& file, const std::string& path) {
  const std::string& kind = file.description().kind;
  if (kind == "grid") {
    attempt([&] { (void)formats::deep_findings(formats::BrickGrid(file)); });
    export_grid(path);
  } else if (kind == "tets") {
    attempt([&] {
      const formats::TetMesh mesh(file);
      (void)formats::deep_findings(mesh);
      export_tets(path, mesh);
    });
  } else if (kind == formats::TriangleMesh::kind) {
    attempt([&] { (void)formats::deep_findings(formats::TriangleMesh(file)); });
  } else if (kind == formats::ColorGrid::kind) {
    attempt([&] { (void)formats::ColorGrid(file); });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tests::InputFile input;
  input.put(data, size);
  attempt([&] {
    const formats::PackedFile file = formats::PackedFile::from_descriptor(input.descriptor(), "input.rho");
    const tests::GuardedPadding guard(file);
    look_into(file, input.path());
    attempt([&] { draw(file); });
    if (file.description().kind == formats::ColorGrid::kind) attempt([&] { cover(file); });
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return tests::mutate_packed(data, size, max_size, seed);
}
