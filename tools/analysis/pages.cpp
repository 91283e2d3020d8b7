#include "tools/analysis/pages.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "rhoray_report_template.h"  // written from report.html
#include "tools/analysis/gnuplot.h"
#include "tools/analysis/heat_map.h"
#include "tools/analysis/page_template.h"
#include "tools/analysis/plots.h"
#include "tools/analysis/variant_names.h"
#include "tools/pictures/pictures.h"

namespace rhoray::tools {

namespace {

std::string file_name(const std::string& text) {
  std::string name;
  for (const char letter : text)
    name += std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '.' ? letter : '_';
  return name;
}

HeatScale scale_of_errors(const LayerStudy& layer) {
  return {.unit = layer.is_projection() ? "Error of the value, as a share of the field's range"
                                        : "Error of depth, cells along the ray"};
}

HeatScale scale_of_looks() {
  return {.least = 1e-3, .most = 1, .unit = "FLIP: visible difference of the pictures", .is_of_hits = false};
}

/// Edge length of the blocks of pixels drawn in one colour, so that a sample fills the picture.
int block_of_sample(const render::Truth& truth) {
  if (truth.are_all()) return 1;
  const double share = static_cast<double>(truth.pixels.size()) / static_cast<double>(truth.pixel_count());
  // Four samples per block: few blocks are empty.
  return static_cast<int>(std::ceil(2 / std::sqrt(share)));
}

/// Draws the errors of the examined pixels; errors of values as shares of the field's range. For a
/// sample, each block of pixels has its largest error; missed and false pixels stay single pixels.
render::Framebuffer errors_of(const LayerStudy& layer, const Measured& measured) {
  const render::Truth& truth = layer.result()->truth;
  const Interval<double> range = layer.dataset().field().range;
  const auto width = static_cast<std::uint32_t>(truth.size.width),
             block = static_cast<std::uint32_t>(block_of_sample(truth));
  const std::uint32_t blocks = (width + block - 1) / block;
  const auto block_of = [&](std::uint32_t pixel) {
    return static_cast<std::size_t>(pixel / width / block) * blocks + pixel % width / block;
  };
  std::vector<float> largest(block_of(static_cast<std::uint32_t>(truth.pixel_count() - 1)) + blocks,
                             render::nothing_there);
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    float& most = largest[block_of(truth.pixels[i])];
    const float error = measured.error_list[i];
    if (std::isfinite(error) && !(error <= most)) most = error;
  }
  std::vector<float> errors(truth.pixel_count());
  for (std::uint32_t pixel = 0; pixel < errors.size(); ++pixel) errors[pixel] = largest[block_of(pixel)];
  for (std::size_t i = 0; i < truth.pixels.size(); ++i)
    if (std::isinf(measured.error_list[i])) errors[truth.pixels[i]] = measured.error_list[i];
  return heat_map({.width = truth.size.width,
                   .height = truth.size.height,
                   .errors = errors,
                   .unit = layer.is_projection() && range.hi > range.lo ? range.hi - range.lo : 1},
                  scale_of_errors(layer));
}

/// Adds to a row of the results what its line in the table shows.
Json row_of_page(Json row, bool is_projection) {
  const int times = row.at("times");
  row["is_renamed"] = row.at("variant") != row.at("method");
  row["is_extrapolated"] = times == 0;
  row["is_timed_once"] = times == 1;
  row["is_repeated"] = times > 1;
  row["cpu_spread"] =
      50 * (row.at("cpu_ms_max").get<double>() - row.at("cpu_ms_min").get<double>()) / row.at("cpu_ms").get<double>();
  for (const std::string name : {"missed", "false"}) {
    const Json &low = row.at(name + "_ppm_low"), &high = row.at(name + "_ppm_high"), &border = row.at("border_" + name);
    Json wrong{{"ppm", row.at(name + "_ppm")}, {"interval", nullptr}, {"border", nullptr}};
    if (low != high) wrong["interval"] = {{"low", low}, {"high", high}};
    if (!border.is_null()) wrong["border"] = 1e6 * border.get<double>() / row.at("judged_pixels").get<double>();
    row["wrong"].push_back(wrong);
  }
  for (const char* which : {"_median", "_p99", "_max"})
    row["errors"].push_back(row.at(is_projection ? concat("value", which) : concat("depth", which, "_cells")));
  row["made_in_s"] = row.at("preprocess_s") > 0 ? row.at("preprocess_s") : Json(nullptr);
  return row;
}

/// Adds a variant to those that were left out for the same reason.
void add_left_out(const Measured& measured, Json& reasons) {
  for (Json& each : reasons)
    if (each.at("reason") == measured.left_out) {
      each["variants"] = concat(each.at("variants").get<std::string>(), ", ", measured.variant.name);
      return;
    }
  reasons.push_back({{"reason", measured.left_out}, {"variants", measured.variant.name}});
}

/// Rows by group.
Json groups_of(const LayerStudy& layer) {
  const std::vector<Json> rows = rows_json(layer);
  Json groups = Json::array();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Measured& measured = layer.result()->rows[r];
    if (groups.empty() || groups.back().at("group") != measured.variant.group)
      groups.push_back({{"group", measured.variant.group}, {"rows", Json::array()}, {"left_out", Json::array()}});
    if (measured.left_out.empty() && !measured.cpu_ms.empty())
      groups.back()["rows"].push_back(row_of_page(rows[r], layer.is_projection()));
    else
      add_left_out(measured, groups.back()["left_out"]);
  }
  return groups;
}

Json glossary(const LayerStudy& layer) {
  std::vector<std::string> groups;
  for (const Variant& variant : layer.variants()) groups.push_back(variant.group);
  Json variants = Json::array();
  for (const auto& [name, meaning] : variant_words(groups, layer.dataset().is_mesh(), layer.is_projection()))
    variants.push_back({{"name", name}, {"meaning", meaning}});
  return variants;
}

std::string value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const Json& item : value) text += concat(text.empty() ? "" : " × ", value_text(item));
  return text;
}

/// Names and values for readers, without those that the page shows elsewhere.
Json facts_of(const Json& context) {
  Json facts = Json::array();
  for (const auto& [key, value] : context.items()) {
    if (key == "command" || key.starts_with("instruments_")) continue;
    const bool is_memory = key == "memory_bytes", is_limit = key == "time_limit_s";
    const std::string name = is_memory                ? "memory"
                             : is_limit               ? "time limit"
                             : key == "ranges_proven" ? "stored value ranges checked"
                             : key == "repeat"        ? "requested repetitions"
                             : key == "size"          ? "picture"
                                                      : key;
    facts.push_back({{"name", name},
                     {"value", is_memory  ? bytes_text(value.get<std::uint64_t>())
                               : is_limit ? concat(rounded(value.get<double>()), " s")
                                          : concat(value_text(value), key == "size" ? " pixels" : "")}});
  }
  return facts;
}

/// Null before the overhead was measured.
Json instruments_of(const Json& context) {
  if (!context.contains("instruments_share_of_time")) return nullptr;
  const auto per_cent = [&](const char* key) { return 100 * context.at(key).get<double>(); };
  return {{"per_cent", per_cent("instruments_share_of_time")},
          {"pictures", context.at("instruments_pictures")},
          {"noise_per_cent", per_cent("instruments_noise")}};
}

}  // namespace

void require_results_folder(const std::filesystem::path& folder, bool may_replace) {
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  if (std::filesystem::exists(whole, ignored)) {
    if (!std::filesystem::is_directory(whole, ignored))
      throw Error(ErrorCode::usage, concat(folder.string(), ": is not a folder"));
    if (!may_replace && !std::filesystem::is_empty(whole, ignored))
      throw Error(ErrorCode::usage, concat(folder.string(), " already exists and is not empty"),
                  "use --force to overwrite the results in it");
  } else if (::access(whole.parent_path().c_str(), W_OK | X_OK) != 0) {
    const int error = errno;
    throw Error(std::filesystem::is_directory(whole.parent_path(), ignored) ? ErrorCode::resource : ErrorCode::usage,
                concat(folder.string(), ": the folder cannot be made: ", std::strerror(error)));
  }
}

ResultsFolder::ResultsFolder(std::filesystem::path folder, bool may_replace) : folder_(std::move(folder)) {
  require_results_folder(folder_, may_replace);
  std::error_code error_code;
  is_made_ = std::filesystem::create_directory(std::filesystem::absolute(folder_).lexically_normal(), error_code);
  if (error_code)
    throw Error(ErrorCode::resource, concat(folder_.string(), ": the folder cannot be made: ", error_code.message()));
}

ResultsFolder::~ResultsFolder() {
  files_.reset();
  std::error_code stays;  // set if the folder is not empty
  if (is_made_) std::filesystem::remove(folder_, stays);
}

Json ResultsFolder::plots(const LayerStudy& layer, const std::string& prefix, StudyContext& context) {
  Json figures = Json::array();
  if (!has_gnuplot_) return figures;
  try {
    for (const Plot& plot : plots_of(layer)) {
      const std::string svg = drawn_by_gnuplot(plot.script);
      files_->add(folder_ / concat(prefix, plot.name, ".svg"), svg);
      figures.push_back({{"title", plot.title}, {"caption", plot.caption}, {"svg", inline_svg(svg)}});
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::unsupported) throw;
    context.notes.push_back(concat("plots are missing: ", error.what()));
    has_gnuplot_ = false;
  }
  return figures;
}

Json ResultsFolder::picture(const render::Framebuffer& pixels, const std::string& name,
                            const std::string& description) {
  const std::filesystem::path path = folder_ / (name + ".png");
  const std::vector<std::byte> png =
      encode_picture(pixels, {{"Software", concat("rhoray ", version_)}, {"Description", description}}, path);
  files_->add(path, png);
  const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
  return {{"description", description}, {"png", base64(bytes)}};
}

Json ResultsFolder::galleries(const LayerStudy& layer, const std::string& prefix) {
  const PassResult& result = *layer.result();
  Json of_errors = legend_json(scale_of_errors(layer)), of_looks = legend_json(scale_of_looks());
  of_errors["title"] = "Pictures and their errors";
  of_looks["title"] = "Pictures that differ only in appearance";
  if (const int block = block_of_sample(result.truth); block > 1) of_errors["block"] = block;
  of_errors["figures"].push_back(
      {{"title", "Reference picture"},
       {"what", concat(", drawn at the level `", result.picture_method, "`")},
       {"pictures", Json::array({picture(result.true_picture->picture(), prefix + "true", "the reference picture")})}});
  for (const Measured& measured : result.rows) {
    if (!measured.picture) continue;
    const std::string name = prefix + file_name(measured.variant.name), said = measured.variant.name;
    Json figure{{"title", said}, {"pictures", Json::array({picture(*measured.picture, name, said)})}};
    const auto add = [&](const char* what, const render::Framebuffer& map, const std::string& description, Json& to) {
      figure["what"] = what;
      figure["pictures"].push_back(picture(map, name + "_error", description));
      to["figures"].push_back(figure);
    };
    if (!measured.error_list.empty())
      add(" and its errors", errors_of(layer, measured), concat("errors of ", said), of_errors);
    else if (measured.picture_errors && !measured.picture_errors->flip_map.empty())
      add(" and how it differs",
          heat_map(
              {.width = result.size.width, .height = result.size.height, .errors = measured.picture_errors->flip_map},
              scale_of_looks()),
          concat("how different ", said, " looks"), of_looks);
  }
  Json all = Json::array();
  for (const Json& gallery : {of_errors, of_looks})
    if (gallery.contains("figures")) all.push_back(gallery);
  return all;
}

void ResultsFolder::add_layer(const LayerStudy& layer, const std::string& prefix, StudyContext& context,
                              Json& section) {
  const PassResult& result = *layer.result();
  section["size"] = value_text(section.at("size"));
  section["pixels"] = result.truth.pixel_count();
  section["hits"] = result.truth.hit_count();
  section["is_projection"] = layer.is_projection();
  section["verdict"] = verdict_of(layer);
  section["conclusions"] = conclusions_of(layer);
  section["plots"] = plots(layer, prefix, context);
  section["groups"] = groups_of(layer);
  section["variants"] = glossary(layer);
  // Pictures change from pass to pass only.
  auto& [of_pass, shown] = pictures_[prefix];
  const auto pass = result.rows.size() == layer.variants().size() ? result.true_picture : nullptr;
  if (pass == nullptr || of_pass != pass) shown = galleries(layer, prefix);
  of_pass = pass;
  section["galleries"] = shown;
  // The picture stands at the top of the section.
  section["reference"] = shown.empty() ? Json() : shown[0].at("figures")[0].at("pictures")[0];
}

void ResultsFolder::write(const std::vector<const LayerStudy*>& layers, StudyContext& context) {
  if (!has_gnuplot() && std::exchange(has_gnuplot_, false))
    context.notes.push_back(concat("no plots: they need gnuplot (Debian package ", gnuplot_package, ")"));
  version_ = context.facts.at("version").get<std::string>();
  files_.emplace(/*replace_existing=*/true);
  files_->add(folder_ / "results.csv", csv_of(table_of(layers, context)));
  Json page = results_json(layers, context);
  auto section = page.at("layers").begin();
  for (std::size_t number = 1; number <= layers.size(); ++number)
    if (const LayerStudy& layer = *layers[number - 1]; layer.result() != nullptr)
      add_layer(layer, layers.size() > 1 ? concat("layer", number, "_") : std::string(), context, *section++);
  page["notes"] = context.notes;
  page["has_notes"] = !context.notes.empty();
  page["instruments"] = instruments_of(context.facts);
  page["facts"] = facts_of(context.facts);
  files_->add(folder_ / "report.html", fill_template(report_template, page));
  files_->add(folder_ / "results.json", dump_lines(results_json(layers, context)));
  files_->publish();
}

}  // namespace rhoray::tools
