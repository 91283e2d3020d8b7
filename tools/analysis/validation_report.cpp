#include "tools/analysis/validation_report.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/pending_file.h"
#include "formats/base/write_failure.h"
#include "render/paint.h"
#include "tools/pictures/pictures.h"
#include "tools/validate/request.h"
#include "tools/validate/shots.h"

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
    "re-evaluated: the answers differed and were decided again\n"
    "-: there was nothing to measure\n\n";

/// A picture's errors, pixel by pixel (tools/validate/request.h).
struct ErrorMap {
  int width = 0, height = 0;
  std::span<const float> distance_cells, depth_cells;
  std::span<const std::uint8_t> verdict;
};

constexpr const char* marks =
    "magenta: false negative, false positive or different cell; yellow: undecided; dark: nothing";

/// @param color_of  the colour of an error that is not NaN
render::Framebuffer painted(const ErrorMap& map, std::span<const float> errors,
                            const std::function<Vec3(double error)>& color_of) {
  static const Vec3 background(0.03, 0.03, 0.03), wrong(1, 0, 1), undecided(1, 0.8, 0);
  render::Framebuffer picture(map.width, map.height, {});
  render::paint(picture, [&](std::size_t pixel) {
    using validate::Verdict;
    const auto verdict = static_cast<Verdict>(map.verdict[pixel]);
    if (verdict == Verdict::missed || verdict == Verdict::false_hit || verdict == Verdict::elsewhere) return wrong;
    if (verdict == Verdict::undecided) return undecided;
    if (map.verdict[pixel] == validate::no_verdict || std::isnan(errors[pixel])) return background;
    return color_of(static_cast<double>(errors[pixel]));
  });
  return picture;
}

double quantile(std::span<const float> values, double share) {
  std::vector<double> sizes;
  for (const float value : values)
    if (std::isfinite(value)) sizes.push_back(std::abs(static_cast<double>(value)));
  if (sizes.empty()) return 0;
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

struct ErrorPicture {
  render::Framebuffer framebuffer;
  std::string legend;  ///< meaning of the colours
};

/// Signed distance of the rendered surface from the reference: blue below (smaller values), white
/// on it, red above. The scale ends at the 99.9 % quantile.
ErrorPicture signed_distance_picture(const ErrorMap& map) {
  static const Vec3 white(1, 1, 1), below(0.02, 0.12, 0.6), above(0.6, 0.02, 0.05);
  const double scale = std::max(quantile(map.distance_cells, 0.999), 1e-300);
  const auto color_of = [&](double distance) {
    const double share = std::clamp(distance / scale, -1.0, 1.0);
    return white + std::abs(share) * ((share < 0 ? below : above) - white);
  };
  return {painted(map, map.distance_cells, color_of),
          concat("signed distance from the reference, blue ", rounded(-scale), " cells to red ", rounded(scale),
                 " cells; ", marks)};
}

/// The error along the ray, from black (1e-16 cells or less) over red and yellow to white (1 cell
/// or more). Equal steps of colour are powers of ten.
ErrorPicture depth_error_picture(const ErrorMap& map) {
  const auto color_of = [](double error) {
    const double share = std::clamp((std::log10(std::max(error, 1e-16)) + 16) / 16, 0.0, 1.0);
    return Vec3(std::min(1.0, 3 * share), std::clamp(3 * share - 1, 0.0, 1.0), std::clamp(3 * share - 2, 0.0, 1.0));
  };
  return {painted(map, map.depth_cells, color_of),
          concat("error along the ray, black 1e-16 cells, red 5e-11, yellow 2e-5, white 1 cell; ", marks)};
}

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
    if (check.at("holds") != false) continue;
    const Json& found = check.at("found");
    broken += concat(broken.empty() ? " " : "; ", shown_name(check.at("check").get<std::string>()), " ",
                     found.is_null() ? "infinite" : rounded(found.get<double>()), ", limit ",
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
