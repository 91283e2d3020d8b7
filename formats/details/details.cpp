#include "formats/details/details.h"

#include <charconv>
#include <cmath>
#include <set>

#include "formats/format_error.h"

namespace rhoray::formats::details {
namespace {

constexpr int deepest_level = 8;  // real details have four

/// A value that was found, shortened for a message.
std::string shown(const Json& value) {
  constexpr std::size_t longest = 60;
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  return text;
}

std::string label_name_rule() {
  return concat("a name of 1 to ", longest_label_name_bytes, " bytes of UTF-8 without control characters");
}

bool is_count(const Json& value) {
  return value.is_number_unsigned();
}

bool is_finite_number(const Json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

template <class Fits>
bool is_list(const Json& value, std::size_t size, Fits fits) {
  if (!value.is_array() || value.size() != size) return false;
  for (const Json& item : value)
    if (!fits(item)) return false;
  return true;
}

}  // namespace

Json parse(const PackedFile& file) {
  const std::string& text = file.description().details;
  if (text.find('\0') != std::string::npos) refuse(file.name(), "details", "a zero byte", "JSON");

  std::vector<std::set<std::string>> open_objects;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > deepest_level)
      refuse(file.name(), "details", "deeper nesting", concat(deepest_level, " levels at most"));
    if (event == Json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == Json::parse_event_t::object_end) open_objects.pop_back();
    if (event == Json::parse_event_t::key && !open_objects.back().insert(parsed.get<std::string>()).second)
      refuse(file.name(), "details", concat("the key ", shown(parsed), " twice"), "it once");
    return true;
  };
  try {
    Json details = Json::parse(text, watch);
    if (!details.is_object()) refuse(file.name(), "details", shown(details), "a JSON object");
    return details;
  } catch (const Json::parse_error& error) {
    refuse(file.name(), concat("details, byte ", error.byte), "text that is not JSON", "JSON");
  } catch (const Json::exception&) {
    refuse(file.name(), "details", "a number out of range", "numbers that fit 64 bits");
  }
}

Reader::Reader(const Json& object, std::string_view file, std::string place)
    : object_(object), file_(file), place_(std::move(place)) {}

std::string Reader::place(const std::string& key) const {
  return concat(place_, ".", key);
}

void Reader::refuse_value(const std::string& key, std::string_view expected) const {
  const auto found = object_.find(key);
  refuse(file_, place(key), found == object_.end() ? "nothing" : shown(*found), expected);
}

const Json& Reader::value(const std::string& key, std::string_view expected) const {
  const auto found = object_.find(key);
  if (found == object_.end()) refuse_value(key, expected);
  return *found;
}

bool Reader::has(const std::string& key) const {
  return object_.contains(key);
}

Reader Reader::object(const std::string& key) const {
  const Json& found = value(key, "an object");
  if (!found.is_object()) refuse_value(key, "an object");
  return {found, file_, place(key)};
}

std::vector<Reader> Reader::objects(const std::string& key) const {
  const Json& found = value(key, "a list of objects");
  if (!found.is_array()) refuse_value(key, "a list of objects");
  std::vector<Reader> readers;
  for (const Json& item : found) {
    if (!item.is_object()) refuse_value(key, "a list of objects");
    readers.emplace_back(item, file_, concat(place(key), "[", readers.size(), "]"));
  }
  return readers;
}

std::string Reader::text(const std::string& key) const {
  const Json& found = value(key, "a text");
  if (!found.is_string()) refuse_value(key, "a text");
  return found.get<std::string>();
}

std::uint64_t Reader::count(const std::string& key, std::uint64_t smallest, std::uint64_t largest) const {
  const std::string expected = concat("an integer from ", smallest, " to ", largest);
  const Json& found = value(key, expected);
  if (!is_count(found)) refuse_value(key, expected);
  const auto number = found.get<std::uint64_t>();
  if (number < smallest || number > largest) refuse_value(key, expected);
  return number;
}

std::vector<std::uint64_t> Reader::counts(const std::string& key) const {
  constexpr std::string_view expected = "a list of unsigned integers";
  const Json& found = value(key, expected);
  if (!is_list(found, found.size(), is_count)) refuse_value(key, expected);
  return found.get<std::vector<std::uint64_t>>();
}

double Reader::number(const std::string& key, double smallest) const {
  const std::string expected = concat("a finite number of at least ", smallest);
  const Json& found = value(key, expected);
  if (!is_finite_number(found) || found.get<double>() < smallest) refuse_value(key, expected);
  return found.get<double>();
}

std::vector<double> Reader::numbers(const std::string& key, std::size_t count, double smallest) const {
  const std::string expected = concat("a list of ", count, " finite numbers of at least ", smallest);
  const Json& found = value(key, expected);
  const auto fits = [&](const Json& item) { return is_finite_number(item) && item.get<double>() >= smallest; };
  if (!is_list(found, count, fits)) refuse_value(key, expected);
  return found.get<std::vector<double>>();
}

Vec3 Reader::vector(const std::string& key) const {
  constexpr std::string_view expected = "three finite numbers";
  const Json& found = value(key, expected);
  if (!is_list(found, 3, is_finite_number)) refuse_value(key, expected);
  return {found[0].get<double>(), found[1].get<double>(), found[2].get<double>()};
}

Index3 Reader::index(const std::string& key, std::int64_t smallest, std::int64_t largest) const {
  const std::string expected = concat("three integers from ", smallest, " to ", largest);
  const Json& found = value(key, expected);
  const auto fits = [&](const Json& item) {
    return is_count(item) && item.get<std::uint64_t>() >= static_cast<std::uint64_t>(smallest) &&
           item.get<std::uint64_t>() <= static_cast<std::uint64_t>(largest);
  };
  if (!is_list(found, 3, fits)) refuse_value(key, expected);
  return {found[0].get<std::int64_t>(), found[1].get<std::int64_t>(), found[2].get<std::int64_t>()};
}

Interval<double> Reader::interval(const std::string& key) const {
  constexpr std::string_view expected = "null or two finite numbers that do not fall";
  const Json& found = value(key, expected);
  if (found.is_null()) return {};
  if (!is_list(found, 2, is_finite_number)) refuse_value(key, expected);
  const Interval<double> interval{found[0].get<double>(), found[1].get<double>()};
  if (interval.is_empty()) refuse_value(key, expected);
  return interval;
}

ElementType Reader::element_type(const std::string& key) const {
  const std::string name = text(key);
  for (int i = 0; i <= static_cast<int>(ElementType::F64); ++i)
    if (element_name(static_cast<ElementType>(i)) == name) return static_cast<ElementType>(i);
  refuse_value(key, "the name of an element type");
}

LabelNames Reader::label_names(const std::string& key) const {
  const std::string expected = concat("an object of at most ", most_label_names, " names");
  const Json& found = value(key, expected);
  if (!found.is_object()) refuse_value(key, expected);
  if (found.size() > most_label_names) refuse(file_, place(key), concat(found.size(), " names"), expected);
  LabelNames names;
  for (const auto& [label, name] : found.items()) {
    int number = 0;
    std::from_chars(label.data(), label.data() + label.size(), number);
    if (concat(number) != label)
      refuse(file_, place(key), concat("the key ", shown(label)), "an integer of 32 bits in plain digits");
    if (!name.is_string() || !is_label_name(name.get_ref<const std::string&>()))
      refuse(file_, concat(place(key), ".", label), shown(name), label_name_rule());
    names[number] = name.get<std::string>();
  }
  return names;
}

// -------------------------------------------------------------------------------------------------

Json number_json(double number, std::string_view what) {
  if (!std::isfinite(number))
    throw Error(ErrorCode::invalid, concat(what, ": found ", number, "; expected a finite number"));
  return number;
}

Json vector_json(const Vec3& vector, std::string_view what) {
  return Json::array({number_json(vector.x, what), number_json(vector.y, what), number_json(vector.z, what)});
}

Json index_json(const Index3& index) {
  return Json::array({index.x, index.y, index.z});
}

namespace {

Json label_names_json(const FieldSummary& field) {
  const std::string what = concat("names of labels of field '", field.name, "'");
  if (field.label_names.size() > most_label_names)
    throw Error(ErrorCode::invalid,
                concat(what, ": found ", field.label_names.size(), "; expected at most ", most_label_names));
  Json json = Json::object();
  for (const auto& [label, name] : field.label_names) {
    if (!is_label_name(name))
      throw Error(ErrorCode::invalid, concat(what, ": found ", shown(name), "; expected ", label_name_rule()));
    json[concat(label)] = name;
  }
  return json;
}

}  // namespace

Json field_json(const FieldSummary& field) {
  const std::string what = concat("range of field '", field.name, "'");
  Json range;  // null
  if (!field.range.is_empty())
    range = Json::array({number_json(field.range.lo, what), number_json(field.range.hi, what)});
  Json json{{"name", field.name},
            {"unit", field.unit},
            {"type", element_name(field.type)},
            {"range", range},
            {"no_data_count", field.no_data_count},
            {"histogram", field.histogram}};
  if (!field.mean_gradient.empty()) {
    json["isosurface_area"] = field.isosurface_area;
    json["mean_gradient"] = field.mean_gradient;
  }
  if (!field.label_names.empty()) json["label_names"] = label_names_json(field);
  return json;
}

Json macro_json(const MacroShape& shape) {
  return {{"factor", shape.factor}, {"level_count", shape.level_count}};
}

Json provenance_json(const Provenance& provenance) {
  return {{"source_name", provenance.source_name},
          {"source_checksum", provenance.source_checksum},
          {"command", provenance.command}};
}

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

FieldSummary read_field(const Reader& reader) {
  FieldSummary field;
  field.name = reader.text("name");
  if (field.name.empty()) reader.refuse_value("name", "a name");
  field.unit = reader.text("unit");
  field.type = reader.element_type("type");
  field.range = reader.interval("range");
  field.no_data_count = reader.count("no_data_count");
  field.histogram = reader.counts("histogram");
  if (reader.has("label_names")) field.label_names = reader.label_names("label_names");
  if (!reader.has("isosurface_area") && !reader.has("mean_gradient")) return field;
  field.isosurface_area = reader.numbers("isosurface_area", field.histogram.size(), 0);
  field.mean_gradient = reader.numbers("mean_gradient", field.histogram.size(), 0);
  return field;
}

MacroShape read_macro(const Reader& reader, const Index3& leaf_count) {
  constexpr std::uint64_t largest_factor = 32;  // with 12 levels factor^level stays below 2^63
  MacroShape shape;
  shape.leaf_count = leaf_count;
  shape.factor = static_cast<std::int64_t>(reader.count("factor", 2, largest_factor));
  shape.level_count = static_cast<int>(reader.count("level_count", 1, MacroShape::largest_level_count));
  return shape;
}

Provenance read_provenance(const Reader& reader) {
  return {.source_name = reader.text("source_name"),
          .source_checksum = reader.text("source_checksum"),
          .command = reader.text("command")};
}

}  // namespace rhoray::formats::details
