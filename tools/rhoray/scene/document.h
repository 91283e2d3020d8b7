#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/rhoray/report.h"
#include "tools/rhoray/scene/scene_spec.h"

namespace rhoray::tools {

/// A scene document: JSON (data/scenes/README.md). `input` names a file, or is the document itself
/// where it begins with a brace; the files it names are then relative to the working folder.
struct SceneDocument {
  SceneSpec scene_spec;
  std::vector<std::string> warnings;  ///< of keys that are not known, one line each
};

/// True for the text of a document, for a name that ends in .json, and for a file that begins with
/// a brace.
bool is_scene_document(const std::filesystem::path& input);

/// Refuses, with line and column or a JSON pointer, what is found and what is expected, documents
/// that are not JSON, over 4 MiB or nested deeper than 16 levels, keys that are there twice, values
/// of another type or out of range, keys that are missing, and files that are not there. Whether
/// data, layers and camera go together is for plan.h.
SceneDocument read_scene(const std::filesystem::path& input);

/// The document that says the same.
/// @param folder  that file names are made relative to; empty: as they are
Json scene_json(const SceneSpec& scene_spec, const std::filesystem::path& folder = {});

}  // namespace rhoray::tools
