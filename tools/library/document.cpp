#include "rhoray/document.h"

#include <algorithm>
#include <utility>

#include "formats/base/regular_file.h"
#include "render/document.h"
#include "tools/library/conversions.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_bytes = std::size_t{4} << 20;

}  // namespace

class SceneDocument::Implementation {
 public:
  render::SceneDocument document;
};

SceneDocument::SceneDocument(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
SceneDocument::SceneDocument(const SceneDocument& other)
    : implementation_(std::make_unique<Implementation>(*other.implementation_)) {}
SceneDocument::SceneDocument(SceneDocument&&) noexcept = default;
SceneDocument& SceneDocument::operator=(const SceneDocument& other) {
  implementation_ = std::make_unique<Implementation>(*other.implementation_);
  return *this;
}
SceneDocument& SceneDocument::operator=(SceneDocument&&) noexcept = default;
SceneDocument::~SceneDocument() = default;

SceneDocument SceneDocument::parse(std::string_view json, std::string name) {
  return inside::guarded([&] {
    if (json.size() > most_bytes)
      throw rhoray::Error(rhoray::ErrorCode::invalid, concat(name, ": is larger than 4 MiB; expected a document"));
    return SceneDocument(std::make_unique<Implementation>(
        Implementation{render::read_scene(std::string(json), name, {}, render::FileNames::for_caller)}));
  });
}

SceneDocument SceneDocument::read(const fs::path& path) {
  const std::string text = inside::guarded([&] {
    require_readable(path);
    if (fs::is_directory(path))
      throw rhoray::Error(rhoray::ErrorCode::unreadable, concat(path.string(), ": is a folder; expected a document"));
    return first_bytes(path, most_bytes + 1);
  });
  return parse(text, path.string());
}

std::string SceneDocument::json() const {
  return inside::guarded([&] { return render::scene_text(implementation_->document.scene_spec); });
}

std::span<const std::string> SceneDocument::warnings() const {
  return implementation_->document.warnings;
}

OpenData files_in(const fs::path& folder, const Watch& watch) {
  const fs::path real = inside::guarded([&] {
    std::error_code error;
    const fs::path found = fs::canonical(folder, error);
    if (error || !fs::is_directory(found))
      throw v0_1::Error(v0_1::ErrorCode::unreadable, concat(folder.string(), ": is no folder that can be read"));
    return found;
  });
  return [real, watch](const fs::path& file) {
    return inside::guarded([&] {
      std::error_code error;
      const fs::path found = fs::weakly_canonical(real / file, error);
      const fs::path relative = found.lexically_relative(real);
      if (error || relative.empty() || *relative.begin() == "..")
        inside::refuse(file.string(), ": is outside of ", real.string());
      return inside::opened(found, inside::inside_of(watch));
    });
  };
}

namespace {

/// Leaves out what only the program draws over a picture, so that no room is kept for it.
void leave_out_annotations(const render::AnnotationsSpec& asked, render::ResolvedScene& resolved) {
  if (asked.axes || asked.box.value_or(false) || asked.color_bar || asked.legend.value_or(false) ||
      !asked.caption.empty())
    resolved.notes.emplace_back("annotations are left out: only the program draws them");
  if (resolved.page) resolved.notes.emplace_back("the heat map is left out: only the program draws it");
  const auto has_lines = [](const render::LayerOrigin& origin) { return origin.lines && !origin.lines->edges.empty(); };
  if (std::any_of(resolved.origins.begin(), resolved.origins.end(), has_lines))
    resolved.notes.emplace_back("feature edges are left out: only the program draws them");
  resolved.annotations = {};
  resolved.annotations.legend = false;
  resolved.page.reset();
  for (render::LayerOrigin& origin : resolved.origins) {
    origin.lines.reset();
    origin.feature_edges_deg = render::no_feature_edges;
  }
}

SceneDocument document_of(const render::ResolvedScene& resolved) {
  return SceneDocument::parse(render::scene_text(render::to_spec(resolved)));
}

}  // namespace

ResolvedScene resolve(const SceneDocument& document, const OpenData& open, const Watch& watch) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(watch);
    if (!open) inside::refuse("resolve: no function that opens data; files_in(folder) is one");
    const render::SceneSpec& spec = document.implementation().document.scene_spec;
    inside::OpenedData all_opened;
    const auto load = [&](const render::DataSpec& data, formats::Space world) {
      const Dataset opened = inside::call_back(open, data.file);
      all_opened.insert_or_assign(data.name, opened);
      if (data.label && opened.kind() == DataKind::grid)
        throw rhoray::Error(rhoray::ErrorCode::unsupported,
                            concat(data.file.string(), ": labels of grids are in the program only"));
      // The field of a label is one of cells.
      const render::Dataset known = opened.implementation().of(data.label ? "" : data.field, watched);
      if (known.space() == world || known.space() == formats::Space::unknown) return known;
      return render::Dataset::load(known.file(), known.is_surface() ? "" : known.field().name, world, watched);
    };
    const auto refuse_colors = [](const render::DataSpec& data) -> formats::PackedFile {
      throw rhoray::Error(rhoray::ErrorCode::unsupported,
                          concat(data.file.string(), ": textures of documents are in the program only"));
    };
    render::ResolvedScene resolved = render::resolve_layers(spec, load, refuse_colors, watched);
    leave_out_annotations(spec.annotations, resolved);
    render::aim_camera(spec, resolved, watched);
    return ResolvedScene{.scene = inside::outside_of(resolved, all_opened),
                         .options = inside::options_of(resolved),
                         .document = document_of(resolved),
                         .notes = resolved.notes};
  });
}

SceneDocument to_document(const Scene& scene, const RenderOptions& options) {
  return inside::guarded([&] {
    if (options.window)
      inside::refuse("to_document: RenderOptions::window is given; expected none: a document is of a whole picture");
    for (std::size_t i = 0; i < scene.layers.size(); ++i) {
      scene.layers[i].data.implementation().require_whole_file("to_document");
      if (scene.layers[i].data.implementation().is_in_memory())
        inside::refuse("to_document: the data of layer ", i, " are in memory; save them and open the file");
      if (scene.layers[i].material.texture)
        inside::refuse("to_document: layer ", i, " has a texture, which a document names by a file");
    }
    return document_of(inside::resolved_with_camera(scene, options));
  });
}

}  // namespace rhoray::v0_1
