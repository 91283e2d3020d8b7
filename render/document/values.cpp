#include "render/document/values.h"

#include <cmath>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "formats/base/regular_file.h"
#include "render/method_words.h"

namespace rhoray::render {

namespace {

Json numbers_schema(std::size_t count) {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", count}, {"maxItems", count}};
}

/// As many numbers as asked for, or nothing. Documents hold finite ones only.
std::optional<std::vector<double>> numbers_in(const Json& json, std::size_t count) {
  if (!json.is_array() || json.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& number : json) {
    if (!number.is_number()) return std::nullopt;
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

std::string quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += concat(text.empty() ? "" : ", ", '"', word, '"');
  return text;
}

/// A text that an option would take too.
template <class T>
std::optional<T> value_of(const Json& json) {
  if (!json.is_string()) return std::nullopt;
  try {
    using rhoray::read_value;
    T value{};
    read_value(json.get<std::string>(), value);
    return value;
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool is_percentile(const std::string& text) {
  return text.starts_with("p") && [&] {
    const auto percent = value_of<double>(Json(text.substr(1)));
    return percent && limits::percentile.contains(*percent);
  }();
}

}  // namespace

ValueKind<double> number() {
  return {.expected = "a number",
          .schema = {{"type", "number"}},
          .read =
              [](const Json& json, const Reading& at) {
                if (!json.is_number()) at.place.refuse(json, "a number");
                return json.get<double>();
              },
          .write = [](double value) -> Json { return value; }};
}

ValueKind<double> number_within(const Interval<double>& limits) {
  ValueKind<double> kind = number();
  kind.expected = concat("a number from ", limits.lo, " to ", limits.hi);
  kind.schema.update(Json{{"minimum", limits.lo}, {"maximum", limits.hi}});
  kind.read = [limits, expected = kind.expected](const Json& json, const Reading& at) {
    if (!json.is_number() || !limits.contains(json.get<double>())) at.place.refuse(json, expected);
    return json.get<double>();
  };
  return kind;
}

ValueKind<double> number_from_zero() {
  ValueKind<double> kind = number();
  kind.expected = "a number from 0 up";
  kind.schema["minimum"] = 0;
  kind.read = [](const Json& json, const Reading& at) {
    if (!json.is_number() || !(json.get<double>() >= 0)) at.place.refuse(json, "a number from 0 up");
    return json.get<double>();
  };
  return kind;
}

ValueKind<double> number_above_zero() {
  ValueKind<double> kind = number();
  kind.expected = "a number above 0";
  kind.schema["exclusiveMinimum"] = 0;
  kind.read = [](const Json& json, const Reading& at) {
    if (!json.is_number() || !(json.get<double>() > 0)) at.place.refuse(json, "a number above 0");
    return json.get<double>();
  };
  return kind;
}

ValueKind<int> whole_number_within(const Interval<int>& limits) {
  const std::string expected = concat("a whole number from ", limits.lo, " to ", limits.hi);
  return {.expected = expected,
          .schema = {{"type", "integer"}, {"minimum", limits.lo}, {"maximum", limits.hi}},
          .read =
              [limits, expected](const Json& json, const Reading& at) {
                const Interval<double> of_doubles{static_cast<double>(limits.lo), static_cast<double>(limits.hi)};
                if (!json.is_number_integer() || !of_doubles.contains(json.get<double>()))
                  at.place.refuse(json, expected);
                return json.get<int>();
              },
          .write = [](int value) -> Json { return value; }};
}

ValueKind<bool> yes_or_no() {
  return {.expected = "true or false",
          .schema = {{"type", "boolean"}},
          .read =
              [](const Json& json, const Reading& at) {
                if (!json.is_boolean()) at.place.refuse(json, "true or false");
                return json.get<bool>();
              },
          .write = [](bool value) -> Json { return value; }};
}

ValueKind<std::string> text_value() {
  return {.expected = "a string",
          .schema = {{"type", "string"}, {"minLength", 1}},
          .read =
              [](const Json& json, const Reading& at) {
                if (!json.is_string() || json.get<std::string>().empty()) at.place.refuse(json, "a string");
                return json.get<std::string>();
              },
          .write = [](const std::string& text) -> Json { return text.empty() ? Json() : Json(text); }};
}

ValueKind<Vec3> vector_value() {
  return {.expected = "three numbers [x, y, z]",
          .schema = numbers_schema(3),
          .read = [](const Json& json, const Reading& at) -> Vec3 {
            const auto numbers = numbers_in(json, 3);
            if (!numbers) at.place.refuse(json, "three numbers [x, y, z]");
            return {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
          },
          .write = [](const Vec3& v) { return json_of(v); }};
}

ValueKind<Interval<double>> interval_value() {
  const std::string expected = "two numbers [a, b] with a below b";
  return {.expected = expected,
          .schema = numbers_schema(2),
          .read = [expected](const Json& json, const Reading& at) -> Interval<double> {
            const auto numbers = numbers_in(json, 2);
            if (!numbers || !((*numbers)[0] < (*numbers)[1])) at.place.refuse(json, expected);
            return {(*numbers)[0], (*numbers)[1]};
          },
          .write = [](const Interval<double>& interval) { return json_of(interval); }};
}

ValueKind<Color> color_value() {
  const std::string expected = "a colour: \"#rrggbb\", or linear [r, g, b] from 0 to 1";
  Json parts = numbers_schema(3);
  parts["items"].update(Json{{"minimum", 0}, {"maximum", 1}});
  return {.expected = expected,
          .schema = {{"oneOf", {{{"type", "string"}, {"pattern", "^#[0-9a-fA-F]{6}$"}}, parts}}},
          .read = [expected](const Json& json, const Reading& at) -> Color {
            if (json.is_string() && json.get<std::string>().starts_with("#"))
              if (const auto color = value_of<Color>(json)) return *color;
            const auto numbers = numbers_in(json, 3);
            if (!numbers) at.place.refuse(json, expected);
            for (const double part : *numbers)
              if (!limits::share.contains(part)) at.place.refuse(json, expected);
            return {{(*numbers)[0], (*numbers)[1], (*numbers)[2]}};
          },
          .write = [](const Color& color) { return json_of(color.linear); }};
}

ValueKind<PictureSize> size_value() {
  const std::string expected = "[width, height] from 1 to 65536, or \"720p\", \"1080p\", \"4k\"";
  const Json side{{"type", "integer"}, {"minimum", 1}, {"maximum", 65536}};
  return {.expected = expected,
          .schema = {{"oneOf",
                      {{{"type", "array"}, {"items", side}, {"minItems", 2}, {"maxItems", 2}},
                       {{"type", "string"}, {"pattern", "^(720p|1080p|4k|[0-9]+x[0-9]+)$"}}}}},
          .read =
              [expected](const Json& json, const Reading& at) {
                if (const auto size = value_of<PictureSize>(json)) return *size;
                const auto sides = numbers_in(json, 2);
                if (!sides || !json[0].is_number_integer() || !json[1].is_number_integer())
                  at.place.refuse(json, expected);
                for (const double pixels : *sides)
                  if (!(pixels >= 1 && pixels <= 65536)) at.place.refuse(json, expected);
                return PictureSize{static_cast<int>((*sides)[0]), static_cast<int>((*sides)[1])};
              },
          .write = [](const PictureSize& size) -> Json {
            return {size.width, size.height};
          }};
}

ValueKind<std::filesystem::path> file_value() {
  return {.expected = "a file name",
          .schema = {{"type", "string"}, {"minLength", 1}},
          .read =
              [](const Json& json, const Reading& at) {
                if (!json.is_string() || json.get<std::string>().empty()) at.place.refuse(json, "a file name");
                const std::filesystem::path name = json.get<std::string>();
                const std::filesystem::path file = name.is_absolute() || at.folder.empty() ? name : at.folder / name;
                try {
                  require_readable(file);
                } catch (const Error& error) {
                  throw Error(error.code(), concat(at.place.text(), ": ", error.what()), error.hint());
                }
                return file;
              },
          .write = [](const std::filesystem::path& file) -> Json { return file.string(); }};
}

ValueKind<std::string> word_value(std::vector<std::string> words) {
  const std::string expected = concat("one of ", quoted(words));
  return {.expected = expected,
          .schema = {{"enum", words}},
          .read =
              [words, expected](const Json& json, const Reading& at) {
                if (!json.is_string()) at.place.refuse(json, expected);
                const std::string word = json.get<std::string>();
                if (std::find(words.begin(), words.end(), word) == words.end())
                  at.place.refuse(json, expected, did_you_mean(word, words));
                return word;
              },
          .write = [](const std::string& word) -> Json { return word.empty() ? Json() : Json(word); }};
}

ValueKind<std::vector<std::string>> words_value(std::vector<std::string> words) {
  const ValueKind<std::string> one = word_value(words);
  const std::string expected = concat("an array of ", quoted(words));
  return {.expected = expected,
          .schema = {{"type", "array"}, {"items", one.schema}, {"uniqueItems", true}},
          .read =
              [one, expected](const Json& json, const Reading& at) {
                if (!json.is_array()) at.place.refuse(json, expected);
                std::vector<std::string> taken;
                for (std::size_t i = 0; i < json.size(); ++i) {
                  const std::string word = one.read(json[i], at.at(i));
                  if (std::find(taken.begin(), taken.end(), word) != taken.end())
                    at.place.at(i).refuse(json[i], "each word once");
                  taken.push_back(word);
                }
                return taken;
              },
          .write = [](const std::vector<std::string>& taken) -> Json { return taken; }};
}

ValueKind<std::vector<std::string>> isovalues_value() {
  const std::string expected = "a number, \"auto\" or a percentile such as \"p95\"";
  const Json one{{"oneOf", {{{"type", "number"}}, {{"type", "string"}, {"pattern", "^(auto|p[0-9.]+)$"}}}}};
  Json several{{"type", "array"}, {"items", one}, {"minItems", 1}};
  const auto read_one = [expected](const Json& json, const Reading& at) -> std::string {
    if (json.is_number()) return concat(json.get<double>());
    if (!json.is_string()) at.place.refuse(json, expected);
    const std::string text = json.get<std::string>();
    if (text != "auto" && !is_percentile(text))
      at.place.refuse(json, expected, did_you_mean(text, std::vector<std::string>{"auto"}));
    return text;
  };
  const auto write_one = [](const std::string& text) -> Json {
    const auto value = value_of<double>(Json(text));
    return value ? Json(*value) : Json(text);
  };
  return {.expected = expected + ", or an array of these",
          .schema = {{"oneOf", {one["oneOf"][0], one["oneOf"][1], several}}},
          .read =
              [expected, read_one](const Json& json, const Reading& at) {
                if (!json.is_array()) return std::vector<std::string>{read_one(json, at)};
                if (json.empty()) at.place.refuse(json, expected + ", or an array of these");
                std::vector<std::string> texts;
                for (std::size_t i = 0; i < json.size(); ++i) texts.push_back(read_one(json[i], at.at(i)));
                return texts;
              },
          .write = [write_one](const std::vector<std::string>& texts) -> Json {
            if (texts.size() == 1) return write_one(texts[0]);
            Json list = Json::array();
            for (const std::string& text : texts) list.push_back(write_one(text));
            return list;
          }};
}

ValueKind<std::string> method_value() {
  ValueKind<std::string> kind = text_value();
  kind.expected = "a method name, as for --method";
  return kind;
}

void warn_of_unknown_key(const std::string& key, const std::vector<std::string>& known, const Reading& at) {
  const std::string hint = did_you_mean(key, known);
  at.warnings.push_back(concat(at.place.at(key).text(), ": unknown key, ignored", hint.empty() ? "" : "; ", hint));
}

void refuse_missing_key(const std::string& key, const std::string& expected, const Reading& at) {
  throw Error(ErrorCode::invalid, concat(at.place.text(), ": has no \"", key, "\"; expected ", expected));
}

}  // namespace rhoray::render
