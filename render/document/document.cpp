#include "render/document.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/lower_case.h"
#include "formats/base/regular_file.h"
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

constexpr std::size_t most_levels = 16;

/// The library's words without its numbers, and without what it read last where that is long.
std::string syntax_text(std::string message) {
  if (const std::size_t at = message.find("parse error at "); at != std::string::npos)
    message.erase(0, at + std::string_view("parse error at ").size());
  constexpr std::size_t longest = 60;
  const std::size_t from = message.find("; last read: '"), to = message.rfind("'");
  if (from != std::string::npos && to > from + longest) message.erase(from, to + 1 - from);
  for (char& letter : message)
    if (static_cast<unsigned char>(letter) < ' ') letter = ' ';
  return message;
}

/// Makes the tree while it is read, since the library's own maker lets a second key replace the
/// first.
class TreeMaker final : public nlohmann::json_sax<Json> {
 public:
  explicit TreeMaker(const std::string& name) : name_(name) {}

  Json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t&) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // not in text

  bool start_object(std::size_t) override { return open(Json::object()); }
  bool key(string_t& name) override {
    if (!open_.back().keys.insert(name).second)
      throw Error(ErrorCode::invalid, concat(here().at(name).text(), ": duplicate key"));
    open_.back().key = name;
    return true;
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_array() override { return close(); }

  bool parse_error(std::size_t, const std::string& last_read, const nlohmann::detail::exception& error) override {
    constexpr int number_overflow = 406;
    if (error.id == number_overflow)
      throw Error(ErrorCode::invalid, concat(next().text(), ": found ", last_read, "; expected a finite number"));
    throw Error(ErrorCode::invalid, concat(name_, ", ", syntax_text(error.what())));
  }

 private:
  /// An object or an array that has not ended.
  struct Level {
    Json* value;
    std::string key{};             ///< of an object: the last one
    std::set<std::string> keys{};  ///< all so far: Json looks for a key among all others of its object
  };

  /// Returns the place of the innermost object or array that has not ended.
  Place here() const {
    Place place{name_, {}};
    for (std::size_t level = 0; level + 1 < open_.size(); ++level) {
      const auto& [value, key, keys] = open_[level];
      place = value->is_array() ? place.at(value->size() - 1) : place.at(key);
    }
    return place;
  }
  /// Returns the place of the next value.
  Place next() const {
    if (open_.empty()) return {name_, {}};
    const auto& [value, key, keys] = open_.back();
    return value->is_array() ? here().at(value->size()) : here().at(key);
  }

  Json& add(Json value) {
    if (open_.empty()) return root_ = std::move(value);
    Json& parent = *open_.back().value;
    if (parent.is_array()) return parent.emplace_back(std::move(value));
    return parent.get_ref<Json::object_t&>().emplace_back(open_.back().key, std::move(value)).second;
  }
  bool put(Json value) {
    add(std::move(value));
    return true;
  }
  bool open(Json value) {
    if (open_.size() == most_levels)
      throw Error(ErrorCode::invalid, concat(next().text(), ": nested deeper than ", most_levels, " levels"));
    open_.push_back({&add(std::move(value))});
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  const std::string& name_;
  Json root_;
  std::vector<Level> open_;  ///< outermost first; what is open is not moved
};

/// JSON of at most 16 levels, in which no object has a key twice and every number is finite.
/// Refuses other texts with line and column, or with the JSON pointer of what is wrong
/// (ErrorCode::invalid).
/// @param name  of the document, for messages
Json read_json(const std::string& text, const std::string& name) {
  TreeMaker maker(name);
  Json::sax_parse(text, &maker);
  return maker.take();
}

}  // namespace

bool is_scene_document(const std::filesystem::path& input) {
  if (begins_with_brace(input.string())) return true;
  if (lower_case(input.extension().string()) == ".json") return true;
  constexpr std::size_t enough = 64;
  return begins_with_brace(first_bytes(input, enough));
}

SceneDocument read_scene(const std::filesystem::path& input) {
  if (begins_with_brace(input.string())) return read_scene(input.string(), "scene", {});
  return read_scene(document_text(input), input.string(), input.parent_path());
}

SceneDocument read_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                         FileNames files) {
  const Json json = read_json(text, name);
  SceneDocument document;
  document.scene_spec = read_object(json, Reading{{name, {}}, folder, document.warnings, files}, scene_rows());
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
