#include "render/document.h"

#include <algorithm>
#include <cctype>

#include "formats/base/error.h"
#include "formats/base/regular_file.h"
#include "render/document/json_tree.h"
#include "render/document/tables.h"

namespace rhoray::render {

namespace {

constexpr std::string_view blanks = " \t\r\n";

bool begins_with_brace(std::string_view text) {
  const std::size_t at = text.find_first_not_of(blanks);
  return at != std::string_view::npos && text[at] == '{';
}

std::string document_text(const std::filesystem::path& path) {
  constexpr std::size_t most_bytes = std::size_t{4} << 20;
  require_readable(path);
  if (std::filesystem::is_directory(path))
    throw Error(ErrorCode::unreadable, concat(path.string(), ": is a folder; expected a scene document"));
  std::string text = first_bytes(path, most_bytes + 1);
  if (text.size() > most_bytes)
    throw Error(ErrorCode::invalid, concat(path.string(), ": is larger than 4 MiB; expected a scene document"));
  return text;
}

}  // namespace

bool is_scene_document(const std::filesystem::path& input) {
  if (begins_with_brace(input.string())) return true;
  std::string extension = input.extension().string();
  for (char& letter : extension) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  if (extension == ".json") return true;
  constexpr std::size_t enough = 64;
  return begins_with_brace(first_bytes(input, enough));
}

SceneDocument read_scene(const std::filesystem::path& input) {
  const bool is_text = begins_with_brace(input.string());
  const std::string name = is_text ? "scene" : input.string();
  const Json json = read_json(is_text ? input.string() : document_text(input), name);
  SceneDocument document;
  const std::filesystem::path folder = is_text ? std::filesystem::path() : input.parent_path();
  document.scene_spec = read_object(json, Reading{{name, {}}, folder, document.warnings}, scene_rows());
  document.scene_spec.document = name;
  return document;
}

std::string scene_text(const SceneSpec& scene_spec, const std::filesystem::path& folder) {
  SceneSpec named = scene_spec;
  if (!folder.empty())
    for (DataSpec& data : named.data)
      data.file = std::filesystem::absolute(data.file).lexically_normal().lexically_proximate(
          std::filesystem::absolute(folder).lexically_normal());
  return dump(write_object(named, scene_rows()));
}

}  // namespace rhoray::render
