#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rhoray/context.h"
#include "rhoray/dataset.h"
#include "rhoray/export.h"
#include "rhoray/progress.h"
#include "rhoray/scene.h"

namespace rhoray::RHORAY_ABI {

/// The text of a scene document (\ref scene_keys), checked. A value. Names of files stay as they
/// are; the function that opens data decides what they mean.
class RHORAY_API SceneDocument {
 public:
  /// Checks a document: at most 4 MiB, 16 levels deep, known types and ranges.
  /// Throws ErrorCode::invalid with line and column, or the JSON pointer, and what was expected.
  /// @param name  of what holds the text, for messages
  static SceneDocument parse(std::string_view json, std::string name = "scene");
  /// The same for a file.
  static SceneDocument read(const std::filesystem::path& path);

  /// The document that says the same, on one line.
  std::string json() const;
  /// One line for each key that is not known, with the nearest one that is.
  std::span<const std::string> warnings() const;

  SceneDocument(const SceneDocument&);
  SceneDocument(SceneDocument&&) noexcept;  ///< a moved-from one may only be assigned to or destroyed
  SceneDocument& operator=(const SceneDocument&);
  SceneDocument& operator=(SceneDocument&&) noexcept;
  ~SceneDocument();

  class RHORAY_INSIDE Implementation;
  explicit SceneDocument(std::unique_ptr<Implementation> implementation);  ///< for the library's own sources
  const Implementation& implementation() const { return *implementation_; }

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Opens the data that a document names. There is no default: the text of a stranger opens no file.
using OpenData = std::function<Dataset(const std::filesystem::path& file)>;

/// Opens packed files in a folder and below it. Refuses names that lead out of it, by `..` or by
/// symbolic links (ErrorCode::usage).
/// @param watch  watches each Dataset::open
RHORAY_API OpenData files_in(const std::filesystem::path& folder, const Watch& watch = {});

/// A document whose choices have all been made: isovalues, camera, lights, methods.
struct ResolvedScene {
  Scene scene;
  RenderOptions options;
  SceneDocument document;          ///< says every choice, with the names that data have in the given one
  std::vector<std::string> notes;  ///< what was left out or chosen otherwise than asked, one line each
};

/// Makes the choices that a document leaves open, as the command `rhoray render` does. Annotations,
/// feature edges and heat maps are drawn by the program only; a note says so.
/// Throws ErrorCode::invalid for a document that contradicts itself or its data, with the JSON
/// pointer; ErrorCode::unsupported for one that needs what this library does not do (labels of
/// grids, textures); ErrorCode::interrupted if stopped. A stop request does not end `open`.
RHORAY_API ResolvedScene resolve(const SceneDocument& document, const OpenData& open, const Watch& watch = {});

/// Returns the document that says every choice of a scene. `resolve` makes the same picture of it.
/// Datasets are named by the files that they were opened from.
/// Throws ErrorCode::usage for data that are in memory, for textures, and for a window.
RHORAY_API SceneDocument to_document(const Scene& scene, const RenderOptions& options);

}  // namespace rhoray::RHORAY_ABI
