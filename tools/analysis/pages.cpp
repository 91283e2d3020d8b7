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
#include "tools/analysis/gnuplot.h"
#include "tools/analysis/heat_map.h"
#include "tools/analysis/html.h"
#include "tools/analysis/measure.h"
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

bool is_projection(const LayerStudy& layer) {
  return layer.scene().layers[0].mode == render::Mode::mip;
}

HeatScale scale_of_errors(const LayerStudy& layer) {
  return {.unit = is_projection(layer) ? "Error of the value, as a share of the field's range"
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
                   .unit = is_projection(layer) && range.hi > range.lo ? range.hi - range.lo : 1},
                  scale_of_errors(layer));
}

std::string number_html(double number, int digits) {
  return with_powers(short_number(number, digits));
}

std::string cell(const std::optional<double>& value, int digits = 3) {
  if (!value) return "<td>–</td>";
  return concat("<td>", std::isfinite(*value) ? number_html(*value, digits) : std::string("∞"), "</td>");
}

std::string spread_cell(const Measured& measured) {
  const std::vector<double>& times = measured.cpu_ms;
  if (times.empty()) return "<td>–</td>";
  const Spread spread = spread_of(times);
  if (measured.wall_ms.empty())
    return concat("<td title=\"", html_text(measured.note), "\">≈ ", short_number(spread.median, 3), "</td>");
  if (times.size() == 1) return concat("<td>", short_number(spread.median, 3), "</td>");
  return concat("<td title=\"", short_number(spread.smallest, 3), " to ", short_number(spread.largest, 3), "\">",
                short_number(spread.median, 3), " <small>±",
                short_number(50 * (spread.largest - spread.smallest) / spread.median, 2), " %</small></td>");
}

/// @param of_values  for a projection, whose values have neither position nor normal
std::string row_html(const ResultRow& row, bool of_values) {
  const Measured& measured = *row.measured;
  std::string name = html_text(measured.variant.name);
  if (measured.variant.name != measured.method) name += concat(" <small>", html_text(measured.method), "</small>");
  std::string out = concat(row.is_on_front ? "<tr class=\"front\">" : "<tr>", "<td>", name, row.is_on_front ? " ◆" : "",
                           "</td>", spread_cell(measured));
  const std::optional<render::ErrorCounts>& errors = measured.errors;
  using Border = render::ErrorCounts::Border;
  for (const auto& [member, of_border] : {std::pair{&render::ErrorCounts::missed, &Border::missed},
                                          {&render::ErrorCounts::false_hits, &Border::false_hits}}) {
    if (!errors) {
      out += "<td>–</td>";
      continue;
    }
    const render::Share share = render::share_of((*errors).*member, errors->rays, measured.judges_all);
    out += concat("<td>", number_html(1e6 * share.found, 3));
    if (!measured.judges_all)
      out += concat(" <small>[", number_html(1e6 * share.low, 2), ", ", number_html(1e6 * share.high, 2), "]</small>");
    if (errors->border && errors->rays > 0)
      out += concat(
          " <small>border ",
          number_html(1e6 * static_cast<double>((*errors->border).*of_border) / static_cast<double>(errors->rays), 3),
          "</small>");
    out += "</td>";
  }
  const auto quantiles = [&](const std::optional<render::Quantiles>& of) {
    for (const auto member : {&render::Quantiles::median, &render::Quantiles::p99, &render::Quantiles::largest})
      out += cell(of ? std::optional((*of).*member) : std::nullopt, 2);
  };
  quantiles(errors ? errors->error : std::nullopt);
  const std::optional<PictureErrors>& picture = measured.picture_errors;
  if (!of_values) {
    out += cell(errors && errors->value_error ? std::optional(errors->value_error->p99) : std::nullopt, 2);
    out += cell(picture && picture->normal_deg ? std::optional(picture->normal_deg->p99) : std::nullopt, 2);
  }
  out += cell(picture ? std::optional(picture->rmse) : std::nullopt, 2);
  out += cell(picture ? std::optional(picture->flip) : std::nullopt, 2);
  out += concat("<td>", bytes_text(measured.data_bytes), "</td><td>",
                measured.memory_bytes > 0 ? bytes_text(measured.memory_bytes) : std::string("–"), "</td>",
                cell(measured.preprocess_s > 0 ? std::optional(measured.preprocess_s) : std::nullopt, 2), "</tr>\n");
  return out;
}

/// Rows of a group that were left out, grouped by reason.
std::string left_out_html(const std::vector<const Measured*>& rows) {
  std::map<std::string, std::string> names;
  for (const Measured* row : rows) {
    std::string& list = names[row->left_out];
    list += concat(list.empty() ? "" : ", ", html_text(row->variant.name));
  }
  std::string out;
  for (const auto& [reason, list] : names)
    out += concat("<tr><td class=\"left\" colspan=14>left out, ", html_text(reason), ": ", list, "</td></tr>\n");
  return out;
}

std::string results_table(const LayerStudy& layer) {
  const PassResult& result = *layer.result();
  const std::string unit = is_projection(layer) ? concat("error of the value <small>", html_text(error_unit(layer)))
                                                : std::string("error of depth <small>cells");
  std::string out = concat(
      "<div class=\"wide\"><table><thead><tr><th rowspan=2>variant</th><th rowspan=2>CPU time<br><small>ms</small></th>"
      "<th colspan=2>wrong pixels <small>per million</small></th><th colspan=3>",
      unit, "</small></th>",
      is_projection(layer)
          ? ""
          : "<th rowspan=2>value at hit<br><small>99 %</small></th><th rowspan=2>normal<br><small>99 %, "
            "°</small></th>",
      "<th colspan=2>picture</th><th rowspan=2>file</th><th rowspan=2>memory</th><th rowspan=2>made "
      "in<br><small>s</small></th></tr><tr><th>false negatives</th><th>false positives</th><th>median</th><th>99 "
      "%</th><th>largest</th>"
      "<th>RMSE <small>of 255</small></th><th>FLIP</th></tr></thead><tbody>\n");
  const std::vector<ResultRow> rows = rows_of(result);
  for (std::size_t first = 0; first < result.rows.size();) {
    const std::string& group = result.rows[first].variant.group;
    out += concat("<tr class=\"group\"><td colspan=14>", html_text(group), "</td></tr>\n");
    std::vector<const Measured*> left_out;
    for (; first < result.rows.size() && result.rows[first].variant.group == group; ++first) {
      const Measured& measured = result.rows[first];
      const auto row =
          std::find_if(rows.begin(), rows.end(), [&](const ResultRow& r) { return r.measured == &measured; });
      if (row != rows.end())
        out += row_html(*row, is_projection(layer));
      else
        left_out.push_back(&measured);
    }
    out += left_out_html(left_out);
  }
  return concat(out,
                "</tbody></table></div>\n"
                "<p><small>◆ no other variant is both faster and more accurate. CPU time: median, ± half the spread of "
                "the repeated times. 99 %: of the pixels that both hit, 99 % are within it. ",
                "≈: too slow for pictures in the given time; measured on a random sample of pixels, and the time is "
                "extrapolated. [a, b]: 95 % confidence interval of a sample. ",
                "Border: among the pixels to the left, those that only the mesh or only its resampled grid covers; "
                "errors of depth are those of the other pixels. ",
                "Value at hit: difference between the field at the found position and the isovalue. File and memory: "
                "what is read, and what is mapped or kept for drawing. Made in: time to make the copy. –: not "
                "measured, or does not apply. False negative: a pixel that should show something and does "
                "not. False positive: a pixel that shows something and should not.</small></p>\n");
}

std::string glossary(const LayerStudy& layer) {
  std::vector<std::string> groups;
  for (const Variant& variant : layer.variants()) groups.push_back(variant.group);
  std::string out = "<table class=\"words\"><tbody>\n";
  for (const auto& [name, meaning] : variant_words(groups, layer.dataset().is_mesh(), is_projection(layer)))
    out += concat("<tr><td>", html_text(name), "</td><td>", html_text(meaning), "</td></tr>\n");
  return out + "</tbody></table>\n";
}

std::string columns_table() {
  std::string out =
      "<table class=\"words\"><thead><tr><th>column</th><th>unit</th><th>meaning</th></tr></thead><tbody>\n";
  for (const ResultColumn& column : result_columns())
    out += concat("<tr><td><code>", column.name, "</code></td><td>", html_text(column.unit), "</td><td>",
                  html_text(column.meaning), "</td></tr>\n");
  return out + "</tbody></table>\n";
}

std::string value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) {
    std::string text;
    for (const Json& item : value) text += concat(text.empty() ? "" : " × ", value_text(item));
    return text;
  }
  return value.dump();
}

/// A fact's name and value for readers; nothing for facts that are told elsewhere.
std::optional<std::pair<std::string, std::string>> fact_words(const std::string& key, const Json& value) {
  if (key == "command" || key.starts_with("instruments_")) return std::nullopt;
  if (key == "memory_bytes") return std::pair{std::string("memory"), bytes_text(value.get<std::uint64_t>())};
  if (key == "time_limit_s") return std::pair{std::string("time limit"), concat(rounded(value.get<double>()), " s")};
  if (key == "ranges_proven") return std::pair{std::string("stored value ranges checked"), value_text(value)};
  if (key == "repeat") return std::pair{std::string("requested repetitions"), value_text(value)};
  if (key == "size") return std::pair{std::string("picture"), concat(value_text(value), " pixels")};
  return std::pair{key, value_text(value)};
}

std::string facts_table(const Json& facts) {
  std::string out = "<table class=\"words\"><tbody>\n";
  for (const auto& [key, value] : facts.items())
    if (const auto words = fact_words(key, value))
      out += concat("<tr><td>", html_text(words->first), "</td><td>", html_text(words->second), "</td></tr>\n");
  return out + "</tbody></table>\n";
}

/// Empty before the overhead was measured.
std::string instruments_html(const Json& facts) {
  if (!facts.contains("instruments_share_of_time")) return {};
  const auto per_cent = [&](const char* key) { return with_powers(rounded(100 * facts.at(key).get<double>(), 2)); };
  return concat(
      "The measurement itself (reading clocks around each picture, and checking at each tile whether to stop) changes "
      "the CPU time of a picture by ",
      per_cent("instruments_share_of_time"), " %: the minimum of ", facts.at("instruments_pictures").dump(),
      " pictures with it, compared with the minimum of as many without it, drawn alternately; two series without it "
      "differ by ",
      per_cent("instruments_noise"), " %.");
}

std::string how_measured(const LayerStudy& layer) {
  const PassResult& result = *layer.result();
  const render::Truth& truth = result.truth;
  const std::string judged =
      truth.are_all()
          ? concat("all ", grouped(truth.pixels.size()), " pixels")
          : concat(grouped(truth.pixels.size()), " of ", grouped(truth.pixel_count()),
                   " pixels, chosen at random because exact arithmetic was too slow for all in the given time");
  return concat("<p class=\"lead\">", result.size.width, " × ", result.size.height,
                " pixels. Exact arithmetic computed ", judged, " (", number_html(truth.cpu_s, 3), " s of CPU time); ",
                grouped(truth.hit_count()),
                " of them show something. Pictures are compared with the picture drawn at the level <code>",
                html_text(result.picture_method), "</code>.</p>\n");
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

std::vector<ResultsFolder::Figure> ResultsFolder::plots(const LayerStudy& layer, const std::string& prefix,
                                                        StudyContext& context) {
  std::vector<Figure> figures;
  if (!has_gnuplot_) return figures;
  try {
    for (const Plot& plot : plots_of(layer)) {
      const std::string svg = drawn_by_gnuplot(plot.script);
      files_->add(folder_ / concat(prefix, plot.name, ".svg"), svg);
      figures.push_back({plot.title, plot.caption, inline_svg(svg)});
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::unsupported) throw;
    context.notes.push_back(concat("plots are missing: ", error.what()));
    has_gnuplot_ = false;
  }
  return figures;
}

std::string ResultsFolder::picture(const render::Framebuffer& pixels, const std::string& name,
                                   const std::string& description) {
  const std::filesystem::path path = folder_ / (name + ".png");
  const std::vector<std::byte> png =
      encode_picture(pixels, {{"Software", concat("rhoray ", version_)}, {"Description", description}}, path);
  files_->add(path, png);
  const std::string_view bytes(reinterpret_cast<const char*>(png.data()), png.size());
  return concat("<img alt=\"", html_text(description), "\" src=\"data:image/png;base64,", base64(bytes), "\">");
}

std::string ResultsFolder::pictures(const LayerStudy& layer, const std::string& prefix) {
  const PassResult& result = *layer.result();
  const auto pair = [](const std::string& title, const std::string& left, const std::string& right) {
    return concat("<figure><div class=\"pair\">", left, right, "</div><figcaption>", title, "</figcaption></figure>\n");
  };
  const std::string truth = picture(result.true_picture->picture(), prefix + "true", "the reference picture");
  std::string by_place =
      pair(concat("<b>Reference picture</b>, drawn at the level <code>", html_text(result.picture_method), "</code>"),
           truth, "");
  std::string by_look;
  for (const Measured& measured : result.rows) {
    if (!measured.picture) continue;
    const std::string name = prefix + file_name(measured.variant.name), said = measured.variant.name;
    const std::string shown = picture(*measured.picture, name, said);
    const std::string title = concat("<b>", html_text(said), "</b>");
    if (!measured.error_list.empty()) {
      by_place += pair(title + " and its errors", shown,
                       picture(errors_of(layer, measured), name + "_error", "errors of " + said));
    } else if (measured.picture_errors && !measured.picture_errors->flip_map.empty()) {
      const render::Framebuffer map = heat_map(
          {.width = result.size.width, .height = result.size.height, .errors = measured.picture_errors->flip_map},
          scale_of_looks());
      by_look +=
          pair(title + " and how it differs", shown, picture(map, name + "_error", "how different " + said + " looks"));
    }
  }
  const int block = block_of_sample(result.truth);
  std::string out =
      concat("<h3>Pictures and their errors</h3>\n", legend_html(scale_of_errors(layer)),
             block == 1 ? std::string()
                        : concat("<p>The errors are those of a sample of the pixels: each block of ", block, " × ",
                                 block, " pixels has the colour of its largest error.</p>\n"),
             "<div class=\"pictures\">\n", by_place, "</div>\n");
  if (!by_look.empty())
    out += concat("<h3>Pictures that differ only in appearance</h3>\n", legend_html(scale_of_looks()),
                  "<div class=\"pictures\">\n", by_look, "</div>\n");
  return out;
}

std::string ResultsFolder::layer_section(const LayerStudy& layer, const std::string& prefix, StudyContext& context) {
  std::string out = concat("<h2>", html_text(layer.name()), "</h2>\n", how_measured(layer), "<ul class=\"found\">\n");
  for (const std::string& sentence : conclusions_of(layer))
    out += concat("<li>", with_powers(html_text(sentence)), "</li>\n");
  out += "</ul>\n";
  for (const Figure& plot : plots(layer, prefix, context))
    out += concat("<figure>", plot.body, "<figcaption><b>", html_text(plot.title), ".</b> ",
                  with_powers(html_text(plot.caption)), "</figcaption></figure>\n");
  out += concat("<h3>All variants</h3>\n", results_table(layer), "<h3>Variants</h3>\n", glossary(layer));
  // Pictures change from pass to pass only.
  auto& [of_pass, shown] = pictures_[prefix];
  const std::size_t drawn = layer.result()->rows.size();
  const auto pass = drawn == layer.variants().size() ? layer.result()->true_picture : nullptr;
  if (pass == nullptr || of_pass != pass) shown = pictures(layer, prefix);
  of_pass = pass;
  return out + shown;
}

void ResultsFolder::write(const std::vector<const LayerStudy*>& layers, StudyContext& context) {
  if (!has_gnuplot() && std::exchange(has_gnuplot_, false))
    context.notes.push_back(concat("no plots: they need gnuplot (Debian package ", gnuplot_package, ")"));
  version_ = context.facts.at("version").get<std::string>();
  files_.emplace(/*replace_existing=*/true);
  files_->add(folder_ / "results.csv", csv_of(table_of(layers, context)));
  std::string body = concat(
      "<h1>Accuracy and time</h1>\n"
      "<p class=\"lead\">",
      html_text(value_text(context.facts.at("input"))), " · ", html_text(value_text(context.facts.at("date"))),
      "</p>\n"
      "<p>One picture, drawn with every method for these data. Each method is compared with exact arithmetic for the "
      "same rays and the same data: false negatives and false positives, errors of surface or value, visible "
      "difference of the picture, time and memory.</p>\n");
  if (!context.stage.empty()) body += concat("<p class=\"stage\">", html_text(context.stage), "</p>\n");
  std::size_t number = 0;
  for (const LayerStudy* layer : layers) {
    ++number;
    const std::string prefix = layers.size() > 1 ? concat("layer", number, "_") : std::string();
    if (layer->result() != nullptr) body += layer_section(*layer, prefix, context);
  }
  if (!context.notes.empty()) {
    body += "<h2>Notes</h2>\n<ul>\n";
    for (const std::string& note : context.notes) body += concat("<li>", html_text(note), "</li>\n");
    body += "</ul>\n";
  }
  body += concat(
      "<h2>How it was measured</h2>\n"
      "<p>Every variant computes the same pixels, and its answers are compared with those of exact arithmetic for the "
      "same rays and the same data, which compares values with the isovalue without rounding. Depth errors are "
      "distances along the ray in cells, or for a mesh in longest edges of the tetrahedron that is hit. Times are CPU "
      "times of all threads for a picture whose isovalue is prepared. All variants are timed in turn, round after "
      "round, so that other load on the machine affects all of them. A copy of the data is compared with the original "
      "data.",
      instruments_html(context.facts), "</p>\n<h3>Machine and version</h3>\n", facts_table(context.facts),
      "<h3>Command</h3>\n<pre>", html_text(value_text(context.facts.at("command"))),
      "</pre>\n<details><summary>Columns of results.csv and results.json</summary>\n", columns_table(), "</details>\n");
  files_->add(folder_ / "report.html", html_page("Accuracy and time", body));
  files_->add(folder_ / "results.json", dump_lines(results_json(layers, context)));
  files_->publish();
}

}  // namespace rhoray::tools
