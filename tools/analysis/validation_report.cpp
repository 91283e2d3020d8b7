#include "tools/analysis/validation_report.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/pending_file.h"
#include "formats/base/write_failure.h"
#include "tools/analysis/error_map.h"
#include "tools/pictures/pictures.h"
#include "tools/validate/request.h"

namespace rhoray::tools {

namespace {

constexpr const char* file_names[] = {"report.txt",          "report.json",    "rays.csv",
                                      "errors.csv",          "limits.csv",     "disputed_rays.csv",
                                      "signed_distance.png", "depth_error.png"};

/// The terms of the text for the keys of the JSON.
std::string shown_name(const std::string& key) {
  static const std::map<std::string, std::string> names{{"missed", "false negatives"},
                                                        {"false", "false positives"},
                                                        {"elsewhere", "different cell"},
                                                        {"grazes", "grazing"},
                                                        {"redecided", "re-evaluated"}};
  const auto found = names.find(key);
  return found == names.end() ? key : found->second;
}

/// A row of a table as the text shows it.
Json shown(const Json& row) {
  Json out = Json::object();
  for (const auto& [key, value] : row.items())
    if (key != "reason") out[shown_name(key)] = value.is_string() ? Json(shown_name(value.get<std::string>())) : value;
  return out;
}

constexpr const char* definitions =
    "false negative: the surface is there, but the renderer reports no hit\n"
    "false positive: the renderer reports a hit, but there is no surface\n"
    "different cell: the hit is not where the ray first crosses the surface\n"
    "grazing: a ray moved by rounding gives the renderer's answer\n"
    "undecided: the reference is not exact enough to tell\n"
    "re-evaluated: the answers differed and were decided again\n\n";

}  // namespace

ValidationReport::ValidationReport(formats::PackedFile answer) : answer_(std::move(answer)) {
  const auto bytes = answer_.array<std::uint8_t>(validate::report_array, {0});
  json_ = Json::parse(bytes.begin(), bytes.end());
}

void ValidationReport::add_context(const Json& context, double seconds, const std::string& version) {
  Json whole = context;
  for (const auto& [key, value] : json_.items()) whole[key] = value;
  whole["seconds"] = seconds;
  whole["version"] = version;
  json_ = std::move(whole);
}

Table ValidationReport::table(const char* key, const char* name, const char* title) const {
  Table table{.name = name, .title = title, .context = Json::object(), .rows = {}};
  for (const Json& row : json_.at(key)) table.rows.push_back(row);
  return table;
}

std::vector<Table> ValidationReport::tables() const {
  return {table("rays", "rays", "Rays, by target"), table("measures", "errors", "Error quantiles"),
          table("checks", "limits", "Limits")};
}

std::string ValidationReport::text() const {
  std::string text =
      concat(json_.at("file").get<std::string>(), ", field '", json_.at("field").get<std::string>(), "', isovalue ",
             json_.at("isovalue").get<double>(), "\nreference: ", json_.at("reference").get<std::string>(), "\n",
             grouped(json_.at("straddling_cells").get<std::uint64_t>()), " cells meet the surface, ",
             grouped(json_.at("triangles").get<std::uint64_t>()), " triangles in the reference\n\n");
  for (Table& table : tables()) {
    for (Json& row : table.rows) row = shown(row);
    text += text_of(table) + "\n";
  }
  text += definitions;
  for (const Json& way : json_.at("hausdorff"))
    if (!way.at("cells").is_null())
      text +=
          concat("Hausdorff distance, ", way.at("way").get<std::string>(), ": ", rounded(way.at("cells").get<double>()),
                 " cells, ", rounded(way.at("box").get<double>()), " of the box\n");
  text += "\n";
  for (const Json& note : json_.at("notes")) text += concat("note: ", note.get<std::string>(), "\n");
  return text + concat(json_.at("holds").get<bool>() ? "within the limits" : "OUTSIDE THE LIMITS", ", took ",
                       rounded(json_.at("seconds").get<double>(), 3), " s\n");
}

void ValidationReport::write(const std::filesystem::path& folder, bool replace_existing) const {
  std::error_code error;
  const bool is_made = std::filesystem::create_directory(folder, error);
  if (error) throw write_failure(folder.string(), "make the folder", error.value());
  try {
    PendingFiles files(replace_existing);
    add_files(folder, files);
    files.publish();
  } catch (...) {
    if (is_made) std::filesystem::remove(folder, error);
    throw;
  }
}

void ValidationReport::add_files(const std::filesystem::path& folder, PendingFiles& files) const {
  files.add(folder / "report.txt", text());
  files.add(folder / "report.json", json_.dump(2) + "\n");
  for (const Table& table : tables()) files.add(folder / (table.name + ".csv"), csv_of(table));
  if (!json_.at("disputed").empty())
    files.add(folder / "disputed_rays.csv", csv_of(table("disputed", "disputed_rays", "Rays with a different answer")));

  const std::vector<std::uint64_t>& shape = answer_.entry(validate::verdict_array).shape;
  const ErrorMap map{.width = static_cast<int>(shape.at(1)),
                     .height = static_cast<int>(shape.at(0)),
                     .distance_cells = answer_.array<float>(validate::distance_array, shape),
                     .depth_cells = answer_.array<float>(validate::depth_array, shape),
                     .verdict = answer_.array<std::uint8_t>(validate::verdict_array, shape)};
  const auto save = [&](const ErrorPicture& picture, const char* name) {
    const std::filesystem::path path = folder / name;
    files.add(path, encode_picture(picture.framebuffer,
                                   {{"Software", concat("rhoray ", json_.at("version").get<std::string>())},
                                    {"Description", picture.legend}},
                                   path));
  };
  save(signed_distance_picture(map), "signed_distance.png");
  save(depth_error_picture(map), "depth_error.png");
}

void ValidationReport::refuse_outside_limits(const std::string& name) const {
  std::string broken;
  for (const Json& check : json_.at("checks")) {
    if (check.at("holds").get<bool>()) continue;
    const Json& found = check.at("found");
    broken += concat(broken.empty() ? " " : "; ", shown_name(check.at("check").get<std::string>()), " ",
                     found.is_null() ? "not measured" : rounded(found.get<double>()), ", limit ",
                     rounded(check.at("limit").get<double>()));
  }
  if (!broken.empty()) throw Error(ErrorCode::outside_limit, concat(name, ": outside the limits:", broken));
}

void require_report_folder(const std::filesystem::path& folder, bool replace_existing) {
  std::error_code ignored;
  const std::filesystem::path parent = folder.has_parent_path() ? folder.parent_path() : std::filesystem::path(".");
  if (!std::filesystem::is_directory(parent, ignored))
    throw Error(ErrorCode::usage, concat(folder.string(), ": there is no folder ", parent.string()),
                "create the folder first");
  if (std::filesystem::exists(folder, ignored) && !std::filesystem::is_directory(folder, ignored))
    throw Error(ErrorCode::usage, concat(folder.string(), ": is not a folder"));
  for (const char* name : file_names)
    if (std::filesystem::exists(folder / name, ignored) && !replace_existing)
      throw Error(ErrorCode::usage, concat((folder / name).string(), " already exists"), "use --force to overwrite it");
}

}  // namespace rhoray::tools
