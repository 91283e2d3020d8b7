#include "formats/base/text.h"
#include "render/document.h"
#include "render/document/clip.h"
#include "render/document/tables.h"

namespace rhoray::render {

namespace {

/// Escapes bars, which would end a table's cell.
std::string cell(const std::string& text) {
  std::string out;
  for (const char letter : text) out += letter == '|' ? std::string("\\|") : std::string(1, letter);
  return out;
}

template <class Object>
std::string table(const std::string& title, const std::vector<Row<Object>>& rows) {
  std::string text = concat("### ", title, "\n\n| key | takes | |\n|---|---|---|\n");
  for (const Row<Object>& row : rows)
    text += concat("| `", row.key, "` | ", cell(row.expected), " | ", row.required ? "Required. " : "", cell(row.help),
                   " |\n");
  return text;
}

}  // namespace

std::string scene_schema_text() {
  Json schema{
      {"$schema", "https://json-schema.org/draft/2020-12/schema"},
      {"title", "Rhoray scene"},
      {"description",
       "What a picture shows: data, layers, lights, camera and image; rhoray render SCENE.json -o picture.png"}};
  schema.update(schema_of(scene_rows()));
  return dump_lines(schema);
}

std::string scene_reference() {
  std::string text = table("The document", scene_rows()) + "\n" + table("\"data\", one for each name", data_rows());
  for (const LayerKind& kind : layer_kinds())
    text += "\n" + table(concat("\"layers\", of type \"", kind.word, "\": ", kind.help), kind.rows);
  for (const LightKind& kind : light_kinds())
    text += "\n" + table(concat("\"lights\", of type \"", kind.word, "\": ", kind.help), kind.rows);
  text += "\n" + table("\"effects\"", effect_rows()) + "\n" +
          table("\"ambient_occlusion\" of effects", occlusion_rows()) + "\n" + table("\"fog\" of effects", fog_rows());
  text += "\n" + table("\"clip\"", clip_rows()) + "\n" + table("\"planes\" of clip", half_space_rows());
  return text + "\n" + table("\"camera\"", camera_rows()) + "\n" +
         table("\"keyframes\" of the camera", keyframe_rows()) + "\n" + table("\"image\"", image_rows()) + "\n" +
         table("\"annotations\"", annotation_rows()) + "\n" + table("\"axes\" of annotations", axes_rows()) + "\n" +
         table("\"colorbar\" of annotations", color_bar_rows());
}

}  // namespace rhoray::render
