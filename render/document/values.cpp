#include "render/document/values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "formats/base/regular_file.h"
#include "formats/base/word_list.h"
#include "render/document/css_colors.h"
#include "render/method_words.h"

namespace rhoray::render {

namespace {

constexpr int largest_side = 65'536;

std::optional<double> srgb_part(std::string_view two_digits) {
  unsigned value = 0;
  const auto [end, error_code] = std::from_chars(two_digits.data(), two_digits.data() + 2, value, 16);
  if (error_code != std::errc{} || end != two_digits.data() + 2) return std::nullopt;
  return value / 255.0;
}

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

/// A kind of which a parser takes what it can, and returns nothing for what is to be refused.
template <class T>
ValueKind<T> parsed(
    const std::string& expected, Json schema, std::function<std::optional<T>(const Json&)> parse,
    std::function<Json(const T&)> write = [](const T& value) -> Json { return value; }) {
  return {.expected = expected,
          .schema = [schema = std::move(schema)] { return schema; },
          .read =
              [expected, parse = std::move(parse)](const Json& json, const Reading& at) {
                const std::optional<T> value = parse(json);
                if (!value) at.place.refuse(json, expected);
                return *value;
              },
          .write = std::move(write)};
}

/// @param limits  how the schema says what is taken
ValueKind<double> number_if(const std::string& expected, const Json& limits, std::function<bool(double)> is_taken) {
  Json schema{{"type", "number"}};
  schema.update(limits);
  return parsed<double>(expected, std::move(schema),
                        [is_taken = std::move(is_taken)](const Json& json) -> std::optional<double> {
                          if (!json.is_number() || !is_taken(json.get<double>())) return std::nullopt;
                          return json.get<double>();
                        });
}

}  // namespace

void read_value(const std::string& text, PictureSize& out) {
  static constexpr std::pair<std::string_view, PictureSize> names[] = {
      {"720p", {1280, 720}}, {"1080p", {1920, 1080}}, {"4k", {3840, 2160}}};
  for (const auto& [name, size] : names)
    if (text == name) {
      out = size;
      return;
    }
  const std::vector<std::string> sides = split(text, 'x');
  const auto side = [&](std::size_t i) { return whole_number(sides[i]).value_or(0); };
  if (sides.size() != 2 || side(0) < 1 || side(1) < 1 || side(0) > largest_side || side(1) > largest_side)
    refuse_value(text, concat("WxH with sides from 1 to ", largest_side, ", or 720p, 1080p, 4k"));
  out = {side(0), side(1)};
}

void read_value(const std::string& text, Color& out) {
  const auto* const named = std::lower_bound(std::begin(css_colors), std::end(css_colors), text,
                                             [](const CssColor& a, const std::string& b) { return a.name < b; });
  if (named != std::end(css_colors) && named->name == text) {
    char digits[8];
    std::snprintf(digits, sizeof digits, "#%06x", static_cast<unsigned>(named->srgb));
    return read_value(std::string(digits), out);
  }
  if (text.size() == 7 && text[0] == '#') {
    const std::string_view digits(text);
    const auto r = srgb_part(digits.substr(1, 2)), g = srgb_part(digits.substr(3, 2)),
               b = srgb_part(digits.substr(5, 2));
    if (r && g && b) {
      out.linear = linear_from_srgb({*r, *g, *b});
      return;
    }
  }
  const std::vector<std::string> parts = split(text, ',');
  const auto part = [&](std::size_t i) { return finite_number(parts[i]).value_or(-1); };
  const auto is_share = [](double value) { return value >= 0 && value <= 1; };
  if (parts.size() != 3 || !is_share(part(0)) || !is_share(part(1)) || !is_share(part(2)))
    refuse_value(text, "a colour: a CSS name such as steelblue, #rrggbb, or r,g,b (linear) from 0 to 1");
  out.linear = {part(0), part(1), part(2)};
}

void read_value(const std::string& text, Background& out) {
  out = {};
  if (text != "none") read_value(text, out.color.emplace());
}

std::size_t character_count(std::string_view text) {
  const auto is_first_byte = [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; };
  return static_cast<std::size_t>(std::ranges::count_if(text, is_first_byte));
}

Place Place::at(std::string_view key) const {
  Place place = *this;
  place.pointer += '/';
  for (const char letter : key) {
    if (letter == '~')
      place.pointer += "~0";
    else if (letter == '/')
      place.pointer += "~1";
    else
      place.pointer += letter;
  }
  return place;
}

Place Place::at(std::size_t index) const {
  return at(concat(index));
}

std::string Place::text() const {
  return pointer.empty() ? document : concat(document, ": ", pointer);
}

void Place::refuse(const Json& found, const std::string& expected, const std::string& hint) const {
  throw Error(ErrorCode::invalid, concat(text(), ": found ", found_text(found), "; expected ", expected), hint);
}

std::string found_text(const Json& value) {
  constexpr std::size_t most = 40;
  if (value.is_object()) return "an object";
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    return text.size() <= most ? dump(value) : concat(dump(text.substr(0, most - 3) + "..."));
  }
  const std::string text = value.is_array() && value.size() > most ? std::string(most + 1, ' ') : dump(value);
  return text.size() <= most ? text : concat("an array of ", value.size());
}

ValueKind<double> number() {
  return number_if("a number", Json::object(), [](double) { return true; });
}

ValueKind<double> number_within(const Interval<double>& limits) {
  return number_if(concat("a number from ", limits.lo, " to ", limits.hi),
                   Json{{"minimum", limits.lo}, {"maximum", limits.hi}},
                   [limits](double value) { return limits.contains(value); });
}

ValueKind<double> number_from_zero() {
  return number_if("a number from 0 up", Json{{"minimum", 0}}, [](double value) { return value >= 0; });
}

ValueKind<double> number_above_zero() {
  return number_if("a number above 0", Json{{"exclusiveMinimum", 0}}, [](double value) { return value > 0; });
}

ValueKind<int> whole_number_within(const Interval<int>& limits) {
  return parsed<int>(
      concat("a whole number from ", limits.lo, " to ", limits.hi),
      {{"type", "integer"}, {"minimum", limits.lo}, {"maximum", limits.hi}},
      [limits](const Json& json) -> std::optional<int> {
        const Interval<double> of_doubles{static_cast<double>(limits.lo), static_cast<double>(limits.hi)};
        if (!json.is_number_integer() || !of_doubles.contains(json.get<double>())) return std::nullopt;
        return json.get<int>();
      });
}

ValueKind<bool> yes_or_no() {
  return parsed<bool>("true or false", {{"type", "boolean"}}, [](const Json& json) -> std::optional<bool> {
    if (!json.is_boolean()) return std::nullopt;
    return json.get<bool>();
  });
}

ValueKind<std::string> text_value() {
  return parsed<std::string>(
      "a string", {{"type", "string"}, {"minLength", 1}},
      [](const Json& json) -> std::optional<std::string> {
        if (!json.is_string() || json.get_ref<const std::string&>().empty()) return std::nullopt;
        return json.get<std::string>();
      },
      [](const std::string& text) { return text.empty() ? Json() : Json(text); });
}

ValueKind<std::string> drawn_text_value() {
  const ValueKind<std::string> text = text_value();
  Json schema = text.schema();
  schema["maxLength"] = limits::drawn_text.hi;
  return parsed<std::string>(
      concat("a string of ", limits::drawn_text.lo, " to ", limits::drawn_text.hi, " characters"), std::move(schema),
      [](const Json& json) -> std::optional<std::string> {
        if (!json.is_string()) return std::nullopt;
        const std::string found = json.get<std::string>();
        return limits::drawn_text.contains(character_count(found)) ? std::optional(found) : std::nullopt;
      },
      text.write);
}

ValueKind<Vec3> vector_value() {
  return parsed<Vec3>(
      "three numbers [x, y, z]", numbers_schema(3),
      [](const Json& json) -> std::optional<Vec3> {
        const auto numbers = numbers_in(json, 3);
        if (!numbers) return std::nullopt;
        return Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
      },
      [](const Vec3& v) { return json_of(v); });
}

ValueKind<Interval<double>> interval_value() {
  return parsed<Interval<double>>(
      "two numbers [a, b] with a below b", numbers_schema(2),
      [](const Json& json) -> std::optional<Interval<double>> {
        const auto numbers = numbers_in(json, 2);
        if (!numbers || !((*numbers)[0] < (*numbers)[1])) return std::nullopt;
        return Interval<double>{(*numbers)[0], (*numbers)[1]};
      },
      [](const Interval<double>& interval) { return json_of(interval); });
}

namespace {

std::optional<Color> color_in(const Json& json) {
  if (json.is_string()) return value_of<Color>(json);
  const auto numbers = numbers_in(json, 3);
  if (!numbers) return std::nullopt;
  for (const double part : *numbers)
    if (!limits::share.contains(part)) return std::nullopt;
  return Color{{(*numbers)[0], (*numbers)[1], (*numbers)[2]}};
}

}  // namespace

ValueKind<Color> color_value() {
  Json parts = numbers_schema(3);
  parts["items"].update(Json{{"minimum", 0}, {"maximum", 1}});
  return parsed<Color>("a colour: a CSS name, \"#rrggbb\", or linear [r, g, b] from 0 to 1",
                       {{"oneOf", {{{"type", "string"}, {"pattern", "^(#[0-9a-fA-F]{6}|[a-z]+)$"}}, parts}}}, color_in,
                       [](const Color& color) { return json_of(color.linear); });
}

ValueKind<Background> background_value() {
  const ValueKind<Color> color = color_value();
  return parsed<Background>(
      concat("\"none\", or ", color.expected), color.schema(),
      [](const Json& json) -> std::optional<Background> {
        if (json == "none") return Background{};
        const std::optional<Color> found = color_in(json);
        return found ? std::optional(Background{found}) : std::nullopt;
      },
      [](const Background& background) { return background.color ? json_of(background.color->linear) : Json("none"); });
}

ValueKind<PictureSize> size_value() {
  const Json side{{"type", "integer"}, {"minimum", 1}, {"maximum", largest_side}};
  return parsed<PictureSize>(
      concat("[width, height] from 1 to ", largest_side, ", or \"720p\", \"1080p\", \"4k\""),
      {{"oneOf",
        {{{"type", "array"}, {"items", side}, {"minItems", 2}, {"maxItems", 2}},
         {{"type", "string"}, {"pattern", "^(720p|1080p|4k|[0-9]+x[0-9]+)$"}}}}},
      [](const Json& json) -> std::optional<PictureSize> {
        if (json.is_string()) return value_of<PictureSize>(json);
        const auto sides = numbers_in(json, 2);
        if (!sides || !json[0].is_number_integer() || !json[1].is_number_integer()) return std::nullopt;
        for (const double pixels : *sides)
          if (!(pixels >= 1 && pixels <= largest_side)) return std::nullopt;
        return PictureSize{static_cast<int>((*sides)[0]), static_cast<int>((*sides)[1])};
      },
      [](const PictureSize& size) -> Json {
        return {size.width, size.height};
      });
}

ValueKind<std::filesystem::path> file_value() {
  return {.expected = "a file name",
          .schema = []() -> Json {
            return {{"type", "string"}, {"minLength", 1}};
          },
          .read =
              [](const Json& json, const Reading& at) {
                if (!json.is_string() || json.get<std::string>().empty()) at.place.refuse(json, "a file name");
                // The system would end the name there and open another file.
                if (json.get_ref<const std::string&>().find('\0') != std::string::npos)
                  at.place.refuse(json, "a file name without the character NUL");
                const std::filesystem::path name = json.get<std::string>();
                if (at.files == FileNames::for_caller) return name;
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
  const std::string expected = concat("one of ", joined(words, ", ", "\""));
  return {.expected = expected,
          .schema = [words]() -> Json {
            return {{"enum", words}};
          },
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
  const std::string expected = concat("an array of ", joined(words, ", ", "\""));
  return {.expected = expected,
          .schema = [one]() -> Json {
            return {{"type", "array"}, {"items", one.schema()}, {"uniqueItems", true}};
          },
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
          .schema = []() -> Json {
            const Json number{{"type", "number"}}, word{{"type", "string"}, {"pattern", "^(auto|p[0-9.]+)$"}};
            const Json several{{"type", "array"}, {"items", {{"oneOf", {number, word}}}}, {"minItems", 1}};
            return {{"oneOf", {number, word, several}}};
          },
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

ValueKind<Vec3> direction_value() {
  ValueKind<Vec3> kind = vector_value();
  kind.expected = "three numbers [x, y, z], not all 0";
  kind.read = [read = kind.read, expected = kind.expected](const Json& json, const Reading& at) {
    const Vec3 direction = read(json, at);
    if (direction == Vec3(0, 0, 0)) at.place.refuse(json, expected);
    return direction;
  };
  return kind;
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
