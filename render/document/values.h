#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/json.h"
#include "formats/base/nearest_name.h"
#include "formats/base/text.h"
#include "render/document.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// Where in a scene document a value stands: the document's name and a JSON pointer (RFC 6901).
struct Place {
  std::string document;
  std::string pointer;  ///< empty: the whole document

  Place at(std::string_view key) const;
  Place at(std::size_t index) const;
  std::string text() const;  ///< torso.json: /layers/0

  /// `torso.json: /image/size: found 7; expected ...` (ErrorCode::invalid).
  [[noreturn]] void refuse(const Json& found, const std::string& expected, const std::string& hint = {}) const;
};

/// The place of the whole document.
inline Place root(const SceneSpec& scene_spec) {
  return {scene_spec.document, {}};
}

/// Adds the place in the document to errors. On the command line the messages name the options.
template <class Act>
auto at_place(const Place& place, const Act& act) {
  try {
    return act();
  } catch (const Error& error) {
    if (place.document.empty()) throw;
    const ErrorCode error_code = error.code() == ErrorCode::usage ? ErrorCode::invalid : error.code();
    throw Error(error_code, concat(place.text(), ": ", error.what()), error.hint());
  }
}

/// A value as messages show it: short, and on one line.
std::string found_text(const Json& value);

/// Counts the code points of a UTF-8 text.
std::size_t character_count(std::string_view text);

/// A document being read: where we are, and what goes on beside.
struct Reading {
  Place place;
  const std::filesystem::path& folder;  ///< that file names are relative to
  std::vector<std::string>& warnings;   ///< one line each
  FileNames files = FileNames::of_files;

  template <class Step>
  Reading at(const Step& step) const {
    return {place.at(step), folder, warnings, files};
  }
};

/// What a value of a document may be: how people are told, its JSON Schema, and the way in and out.
template <class T>
struct ValueKind {
  std::string expected;                                ///< "a number from 0 to 1"
  std::function<Json()> schema;                        ///< made when it is asked for
  std::function<T(const Json&, const Reading&)> read;  ///< refuses with the place (ErrorCode::invalid)
  std::function<Json(const T&)> write;                 ///< null: left out
};

ValueKind<double> number();
ValueKind<double> number_within(const Interval<double>& limits);
ValueKind<double> number_above_zero();
ValueKind<double> number_from_zero();
ValueKind<int> whole_number_within(const Interval<int>& limits);
ValueKind<bool> yes_or_no();
ValueKind<std::string> text_value();
/// A text that is drawn in the picture, of limits::drawn_text characters.
ValueKind<std::string> drawn_text_value();
ValueKind<Vec3> vector_value();
/// A vector that is not 0.
ValueKind<Vec3> direction_value();
ValueKind<Interval<double>> interval_value();
ValueKind<Color> color_value();
/// "none", or a colour.
ValueKind<Background> background_value();
ValueKind<PictureSize> size_value();
/// A file that must be there; names are relative to the document's folder.
ValueKind<std::filesystem::path> file_value();
ValueKind<std::string> word_value(std::vector<std::string> words);
ValueKind<std::vector<std::string>> words_value(std::vector<std::string> words);
/// A number, "auto", a percentile such as "p95", or a list of these.
ValueKind<std::vector<std::string>> isovalues_value();
ValueKind<std::string> method_value();

/// One key of an object of a document.
template <class Object>
struct Row {
  std::string key;
  std::string help;
  std::string expected;
  std::function<Json()> schema;  ///< made when it is asked for
  bool required = false;
  std::function<void(const Json&, const Reading&, Object&)> read;
  std::function<Json(const Object&)> write;  ///< null: left out
};

/// @param member  of type T, or std::optional<T>
template <class Object, class Member, class T>
Row<Object> row(std::string key, Member Object::*member, ValueKind<T> kind, std::string help) {
  return {.key = std::move(key),
          .help = std::move(help),
          .expected = kind.expected,
          .schema = kind.schema,
          .read = [member, read = kind.read](const Json& json, const Reading& at,
                                             Object& out) { out.*member = read(json, at); },
          .write = [member, write = kind.write](const Object& object) -> Json {
            if constexpr (std::is_same_v<Member, T>) {
              Json json = write(object.*member);
              return json.is_object() && json.empty() ? Json() : json;
            } else {
              return object.*member ? write(*(object.*member)) : Json();  // {} may ask for an effect
            }
          }};
}

template <class Object>
Row<Object> required(Row<Object> row) {
  row.required = true;
  return row;
}

/// Warns of a key that no row has, with the nearest one.
void warn_of_unknown_key(const std::string& key, const std::vector<std::string>& known, const Reading& at);
[[noreturn]] void refuse_missing_key(const std::string& key, const std::string& expected, const Reading& at);

template <class Object>
std::vector<std::string> keys_of(const std::vector<Row<Object>>& rows) {
  std::vector<std::string> keys;
  for (const Row<Object>& row : rows) keys.push_back(row.key);
  return keys;
}

template <class Object>
Object read_object(const Json& json, const Reading& at, const std::vector<Row<Object>>& rows) {
  Object out;
  if (!json.is_object()) at.place.refuse(json, "an object");
  for (const auto& [key, value] : json.items()) {
    const auto found =
        std::find_if(rows.begin(), rows.end(), [&name = key](const Row<Object>& row) { return row.key == name; });
    if (found == rows.end())
      warn_of_unknown_key(key, keys_of(rows), at);
    else
      found->read(value, at.at(key), out);
  }
  for (const Row<Object>& row : rows)
    if (row.required && !json.contains(row.key)) refuse_missing_key(row.key, row.expected, at);
  return out;
}

template <class Object>
Json write_object(const Object& object, const std::vector<Row<Object>>& rows) {
  Json json = Json::object();
  for (const Row<Object>& row : rows) {
    Json value = row.write(object);
    if (!value.is_null()) json[row.key] = std::move(value);
  }
  return json;
}

/// The schema rejects keys that no row has, where the reader only warns: what rejects is an editor,
/// while one types.
template <class Object>
Json schema_of(const std::vector<Row<Object>>& rows) {
  Json properties = Json::object(), required = Json::array();
  for (const Row<Object>& row : rows) {
    Json value = row.schema();
    value["description"] = row.help;
    properties[row.key] = std::move(value);
    if (row.required) required.push_back(row.key);
  }
  Json schema{{"type", "object"}, {"properties", properties}};
  if (!required.empty()) schema["required"] = required;
  schema["additionalProperties"] = false;
  return schema;
}

template <class Object>
ValueKind<Object> object_value(const std::vector<Row<Object>>& rows) {
  return {.expected = "an object",
          .schema = [&rows] { return schema_of(rows); },
          .read = [&rows](const Json& json, const Reading& at) { return read_object(json, at, rows); },
          .write = [&rows](const Object& object) { return write_object(object, rows); }};
}

/// Objects of one kind. Where there must be some, a list without any is not written.
/// @param counts  how many there may be; empty: any number
template <class Object>
ValueKind<std::vector<Object>> list_of(const std::vector<Row<Object>>& rows, const std::string& expected,
                                       const Interval<std::size_t>& counts = {}) {
  return {.expected = expected,
          .schema =
              [=, &rows] {
                Json schema{{"type", "array"}, {"items", schema_of(rows)}};
                if (!counts.is_empty()) schema.update(Json{{"minItems", counts.lo}, {"maxItems", counts.hi}});
                return schema;
              },
          .read =
              [=, &rows](const Json& json, const Reading& at) {
                if (!json.is_array() || (!counts.is_empty() && !counts.contains(json.size())))
                  at.place.refuse(json, expected);
                std::vector<Object> list;
                for (std::size_t i = 0; i < json.size(); ++i) list.push_back(read_object(json[i], at.at(i), rows));
                return list;
              },
          .write = [=, &rows](const std::vector<Object>& list) -> Json {
            if (!counts.is_empty() && list.empty()) return Json();
            Json json = Json::array();
            for (const Object& object : list) json.push_back(write_object(object, rows));
            return json;
          }};
}

/// What is there as it is, or in so many words: true, or an object.
template <class Object, class T>
Row<Object> switched_row(std::string key, std::optional<T> Object::*member, const std::vector<Row<T>>& rows,
                         std::string help) {
  const std::string expected = "true, false or an object";
  return {.key = std::move(key),
          .help = std::move(help),
          .expected = expected,
          .schema = [&rows]() -> Json {
            return {{"oneOf", {{{"type", "boolean"}}, schema_of(rows)}}};
          },
          .read =
              [member, expected, &rows](const Json& json, const Reading& at, Object& out) {
                if (!json.is_boolean() && !json.is_object()) at.place.refuse(json, expected);
                (out.*member).reset();
                if (json.is_object()) out.*member = read_object(json, at, rows);
                if (json == true) out.*member = T{};
              },
          .write = [member, &rows](const Object& object) -> Json {
            if (!(object.*member)) return Json();
            Json json = write_object(*(object.*member), rows);
            return json.empty() ? Json(true) : json;
          }};
}

}  // namespace rhoray::render
