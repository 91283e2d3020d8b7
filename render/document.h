#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "render/called_for.h"
#include "render/resolved_scene.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// A scene document: JSON (data/scenes/README.md).
struct SceneDocument {
  SceneSpec scene_spec;
  std::vector<std::string> warnings;  ///< of keys that are not known, one line each
};

/// True for the text of a document, for a name that ends in .json, and for a file that begins with
/// a brace.
bool is_scene_document(const std::filesystem::path& input);

/// Refuses, with line and column or a JSON pointer, what is found and what is expected: documents
/// that are not JSON, over 4 MiB or nested deeper than 16 levels, keys that are there twice, values
/// of another type or out of range, keys that are missing, and files that are not there. Whether
/// data, layers and camera go together is for resolve_layers.
/// @param input  a file, or the document itself where it begins with a brace; the files it names
///               are then relative to the working folder
SceneDocument read_scene(const std::filesystem::path& input);

/// Who decides which files the names in a document mean.
enum class FileNames {
  of_files,   ///< files that are looked for while the document is read
  for_caller  ///< the caller decides; they stay as they are
};

/// The same of a document's text.
/// @param name    of what holds the text, for messages
/// @param folder  that file names are relative to
SceneDocument read_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                         FileNames files = FileNames::of_files);

/// The document that says the same, as JSON on one line.
/// @param folder  that file names are made relative to; empty: as they are
std::string scene_text(const SceneSpec& scene_spec, const std::filesystem::path& folder = {});

/// The JSON Schema (draft 2020-12) of scene documents, as published in
/// data/scenes/scene.schema.json.
std::string scene_schema_text();
/// Every key of every kind of object, as Markdown tables.
std::string scene_reference();

/// Opens data with world coordinates in this space, where the file says which is its own.
using OpenData = std::function<Dataset(const DataSpec&, formats::Space world)>;

/// Opens a file of colours (formats/color_grid.h), for a texture.
using OpenColors = std::function<formats::PackedFile(const DataSpec&)>;

/// Opens a packed file of colours. Refuses a file that is not packed (ErrorCode::unsupported).
formats::PackedFile open_packed_colors(const DataSpec& data);

/// Opens the data of visible layers and resolves everything but the camera. A layer whose isovalue
/// is outside its field's range is left out with a note if anything else is shown. Refuses
/// conflicts: in a document with the JSON pointer (ErrorCode::invalid), on a command line with the
/// option (ErrorCode::usage).
/// @param watch  watches the search for boundaries of meshes
ResolvedScene resolve_layers(const SceneSpec& scene_spec, const OpenData& open,
                             const OpenColors& open_colors = open_packed_colors, const Watch& watch = {});

/// All that is shown, world axes.
struct Shown {
  Box3 box;                   ///< around it
  std::vector<Vec3> corners;  ///< of boxes whose convex hull contains it
};

/// Finds what is shown. If no surface passes through any cell, returns the bounds of the data.
Shown what_is_shown(const ResolvedScene& plan, const Watch& watch = {});

/// Points the camera: where it is not said, so that all that is shown is seen. Then places what
/// depends on it: lights, ambient occlusion, fog. Chooses the picture's size, unless the
/// specification gives it (PictureSpec::size). Looks at every cell of a mesh where any of these is
/// fitted to what is shown.
/// @param watch  watches the search for what is shown
void aim_camera(const SceneSpec& scene_spec, ResolvedScene& plan, const Watch& watch = {});

/// The axes from which angles of the camera and words of views count.
ViewAxes view_axes(const SceneSpec& scene_spec, const ResolvedScene& plan);

/// The specification that says every choice of a scene; it is resolved to the same picture.
SceneSpec to_spec(const ResolvedScene& plan);

/// What a scene needs and does not need, by layer and effect, and why. The answers come from the
/// functions that rendering uses.
struct Explanation {
  struct Layer {
    std::size_t spec = 0;  ///< index into SceneSpec::layers
    std::string shows, isovalue_from, method, method_because, kernel;
    std::vector<EffectReason> effects;
  };
  std::vector<Layer> layers{};
  std::vector<std::string> lights{};
  std::string antialiasing{};
  std::vector<std::string> left_out{};
};
Explanation explain(const SceneSpec& scene_spec, const ResolvedScene& plan);

}  // namespace rhoray::render
