#include "tools/rhoray/render/asked_scene.h"

#include <optional>

#include "formats/base/error.h"
#include "render/document.h"
#include "tools/pictures/pictures.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

namespace {

/// The text of the scene that made this picture; nothing for other files.
std::optional<std::string> scene_in_picture(const std::filesystem::path& input) {
  if (input.extension() != ".png" && input.extension() != ".exr") return std::nullopt;
  for (const PictureText& text : read_picture(input).texts)
    if (text.name == scene_text_name) return text.value;
  return std::nullopt;
}

/// The scene document, alone or in a picture; nothing where the input is data.
std::optional<render::SceneDocument> document_in(const std::filesystem::path& input) {
  if (render::is_scene_document(input)) return render::read_scene(input);
  const std::optional<std::string> text = scene_in_picture(input);
  if (!text) return std::nullopt;
  return render::read_scene(*text, input.string(), input.parent_path());
}

}  // namespace

render::SceneSpec asked_scene(const PictureOptions& picture, const std::vector<std::filesystem::path>& inputs,
                              const CommonOptions& common) {
  const std::filesystem::path& input = inputs.front();
  const bool has_header = picture.scene_spec.data[0].read.raw.empty();
  const std::optional<render::SceneDocument> document = has_header ? document_in(input) : std::nullopt;
  if (!document) return spec_of(picture, inputs);
  if (inputs.size() > 1)
    throw Error(ErrorCode::usage,
                concat(inputs[1].string(), ": not allowed with the scene ", input.string(), ", which names its files"));
  for (const std::string& warning : document->warnings) say(common, concat("warning: ", warning));
  return with_options(document->scene_spec, picture);
}

}  // namespace rhoray::tools
