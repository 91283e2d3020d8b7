#include "tools/rhoray/accuracy/pages.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "formats/base/trouble.h"
#include "tools/rhoray/accuracy/gnuplot.h"
#include "tools/rhoray/accuracy/html.h"
#include "tools/rhoray/accuracy/plots.h"
#include "tools/rhoray/error_map.h"
#include "tools/rhoray/measure.h"
#include "tools/rhoray/new_file.h"
#include "tools/rhoray/pictures.h"
#include "tools/rhoray/version.h"
#include "tools/validate/request.h"
#include "tools/validate/shots.h"

namespace rhoray::tools {

namespace {

std::string file_name(const std::string& text) {
  std::string name;
  for (const char letter : text)
    name += std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '.' ? letter : '_';
  return name;
}

/// The errors of the judged pixels as a picture; of values as shares of the field's range.
ErrorPicture heat_map(const LayerStudy& layer, const Measured& measured) {
  const Truth& truth = layer.result()->truth;
  const bool is_projection = layer.scene().layers[0].mode == render::Mode::mip;
  const Interval<double> range = layer.volume().field().range;
  const float unit = is_projection && range.hi > range.lo ? static_cast<float>(range.hi - range.lo) : 1.0F;
  std::vector<float> errors(truth.pixel_count(), nothing_there);
  std::vector<std::uint8_t> verdicts(errors.size(), validate::no_verdict);
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const float error = measured.error_list[i];
    if (std::isnan(error)) continue;
    using validate::Verdict;
    const Verdict verdict = error == is_missed  ? Verdict::missed
                            : error == is_false ? Verdict::false_hit
                                                : Verdict::right;
    verdicts[truth.pixels[i]] = static_cast<std::uint8_t>(verdict);
    errors[truth.pixels[i]] = error / unit;
  }
  return depth_error_picture({.width = truth.size.width,
                              .height = truth.size.height,
                              .distance_cells = {},
                              .depth_cells = errors,
                              .verdict = verdicts});
}

std::string cell(const std::optional<double>& value, int digits = 3) {
  if (!value) return "<td>–</td>";
  return concat("<td>", std::isfinite(*value) ? short_number(*value, digits) : std::string("∞"), "</td>");
}

std::string spread_cell(const std::vector<double>& times) {
  if (times.empty()) return "<td>–</td>";
  const Spread spread = spread_of(times);
  if (times.size() == 1) return concat("<td>", short_number(spread.median, 3), "</td>");
  return concat("<td title=\"", short_number(spread.smallest, 3), " to ", short_number(spread.largest, 3), "\">",
                short_number(spread.median, 3), " <small>±",
                short_number(50 * (spread.largest - spread.smallest) / spread.median, 2), " %</small></td>");
}

std::string row_html(const ResultRow& row, const Truth& truth) {
  const Measured& measured = *row.measured;
  std::string name = html_text(measured.variant.name);
  if (measured.variant.name != measured.method) name += concat(" <small>", html_text(measured.method), "</small>");
  std::string out = concat(row.is_on_front ? "<tr class=\"front\">" : "<tr>", "<td>", name, row.is_on_front ? " ◆" : "",
                           "</td>", spread_cell(measured.cpu_ms));
  const std::optional<ErrorCounts>& errors = measured.errors;
  for (const auto member : {&ErrorCounts::missed, &ErrorCounts::false_hits}) {
    if (!errors) {
      out += "<td>–</td>";
      continue;
    }
    const Share share = share_of((*errors).*member, errors->rays, truth.are_all());
    out += concat("<td>", short_number(1e6 * share.found, 3));
    if (!truth.are_all())
      out +=
          concat(" <small>[", short_number(1e6 * share.low, 2), ", ", short_number(1e6 * share.high, 2), "]</small>");
    out += "</td>";
  }
  const auto quantiles = [&](const std::optional<Quantiles>& of) {
    for (const auto member : {&Quantiles::median, &Quantiles::p99, &Quantiles::largest})
      out += cell(of ? std::optional((*of).*member) : std::nullopt, 2);
  };
  quantiles(errors ? errors->error : std::nullopt);
  out += cell(errors && errors->value_error ? std::optional(errors->value_error->p99) : std::nullopt, 2);
  const std::optional<PictureErrors>& picture = measured.picture_errors;
  out += cell(picture && picture->normal_deg ? std::optional(picture->normal_deg->p99) : std::nullopt, 2);
  out += cell(picture ? std::optional(picture->rmse) : std::nullopt, 2);
  out += cell(picture ? std::optional(picture->flip) : std::nullopt, 2);
  out += concat("<td>", bytes_text(measured.data_bytes), "</td>", cell(measured.preprocess_s, 2), "</tr>\n");
  return out;
}

std::string results_table(const LayerStudy& layer) {
  const PassResult& result = *layer.result();
  const bool is_projection = layer.scene().layers[0].mode == render::Mode::mip;
  std::string out = concat(
      "<div class=\"wide\"><table><thead><tr><th rowspan=2>variant</th><th rowspan=2>CPU ms</th><th rowspan=2>missed "
      "ppm</th><th rowspan=2>false ppm</th><th colspan=3>",
      is_projection ? "value error" : "depth error, cells",
      "</th><th rowspan=2>value 99 %</th><th rowspan=2>normal 99 %, °</th><th rowspan=2>RMSE of 255</th><th "
      "rowspan=2>FLIP</th><th rowspan=2>file</th><th rowspan=2>made in, s</th></tr><tr><th>median</th><th>99 %</th>"
      "<th>largest</th></tr></thead><tbody>\n");
  const std::vector<ResultRow> rows = rows_of(result);
  std::string group;
  for (const Measured& measured : result.rows) {
    if (measured.variant.group != group) {
      group = measured.variant.group;
      out += concat("<tr class=\"group\"><td colspan=13>", html_text(group), "</td></tr>\n");
    }
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const ResultRow& r) { return r.measured == &measured; });
    if (row != rows.end())
      out += row_html(*row, result.truth);
    else
      out += concat("<tr><td>", html_text(measured.variant.name),
                    "</td><td class=\"left\" colspan=12>left out: ", html_text(measured.left_out), "</td></tr>\n");
  }
  return out +
         "</tbody></table></div>\n<p><small>◆ no other variant is both faster and closer. ± is half the spread of "
         "the repeated times.</small></p>\n";
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
    for (const Json& item : value) text += concat(text.empty() ? "" : " x ", value_text(item));
    return text;
  }
  return value.dump();
}

std::string facts_table(const Json& facts) {
  std::string out = "<table class=\"words\"><tbody>\n";
  for (const auto& [key, value] : facts.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    if (key != "command")
      out += concat("<tr><td>", html_text(name), "</td><td>", html_text(value_text(value)), "</td></tr>\n");
  }
  return out + "</tbody></table>\n";
}

std::string how_measured(const LayerStudy& layer) {
  const PassResult& result = *layer.result();
  const Truth& truth = result.truth;
  const std::string judged =
      truth.are_all()
          ? concat("all ", grouped(truth.pixels.size()), " pixels")
          : concat(grouped(truth.pixels.size()), " of ", grouped(truth.pixel_count()),
                   " pixels, drawn at random because exact arithmetic was too slow for all in the time given");
  return concat("<p class=\"lead\">", result.size.width, " x ", result.size.height, " pixels. Exact arithmetic judged ",
                judged, " (", short_number(truth.cpu_s, 3), " s of CPU); ", grouped(truth.hit_count()),
                " of them show something. Pictures are compared with the one drawn at the level <code>",
                html_text(result.picture_method), "</code>.</p>\n");
}

}  // namespace

void require_results_folder(const std::filesystem::path& folder, bool may_replace) {
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  if (std::filesystem::exists(whole, ignored)) {
    if (!std::filesystem::is_directory(whole, ignored))
      throw Error(Trouble::usage, concat(folder.string(), ": is not a folder"));
    if (!may_replace && !std::filesystem::is_empty(whole, ignored))
      throw Error(Trouble::usage, concat(folder.string(), ": is there already, and is not empty"),
                  "--force replaces what stands in it under the names of the results");
    return;
  }
  std::error_code trouble;
  if (!std::filesystem::create_directory(whole, trouble))
    throw Error(std::filesystem::is_directory(whole.parent_path(), ignored) ? Trouble::resource : Trouble::usage,
                concat(folder.string(), ": the folder cannot be made: ", trouble.message()));
}

ResultsFolder::ResultsFolder(std::filesystem::path folder, std::filesystem::path passing)
    : folder_(std::move(folder)), passing_(std::move(passing)) {}

std::vector<ResultsFolder::Figure> ResultsFolder::plots(const LayerStudy& layer, const std::string& prefix,
                                                        StudyContext& context) {
  std::vector<Figure> figures;
  if (!has_gnuplot_) return figures;
  try {
    for (const Plot& plot : plots_of(layer)) {
      const std::string svg = drawn_by_gnuplot(plot.script, passing_);
      write_new_file(folder_ / concat(prefix, plot.name, ".svg"), svg, true);
      figures.push_back({plot.title, plot.caption, inline_svg(svg)});
    }
  } catch (const Error& error) {
    if (error.trouble() != Trouble::unsupported) throw;
    context.notes.push_back(concat("plots are missing: ", error.what()));
    has_gnuplot_ = false;
  }
  return figures;
}

std::string ResultsFolder::picture(const render::Framebuffer& pixels, const std::string& name,
                                   const std::string& description) {
  const std::filesystem::path path = folder_ / (name + ".png");
  write_picture(pixels, {{"Software", concat("rhoray ", version())}, {"Description", description}}, path, true);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return concat("<img alt=\"", html_text(description), "\" src=\"data:image/png;base64,", base64(bytes), "\">");
}

std::vector<ResultsFolder::Figure> ResultsFolder::pictures(const LayerStudy& layer, const std::string& prefix) {
  const PassResult& result = *layer.result();
  std::vector<Figure> figures{{"True picture", concat("Drawn at the level `", result.picture_method, "`."),
                               picture(result.true_picture->picture(), prefix + "true", "the true picture")}};
  for (const Measured& measured : result.rows) {
    if (!measured.picture) continue;
    const std::string name = prefix + file_name(measured.variant.name);
    figures.push_back({measured.variant.name, "", picture(*measured.picture, name, measured.variant.name)});
    if (measured.error_list.empty()) continue;
    ErrorPicture map = heat_map(layer, measured);
    if (layer.scene().layers[0].mode == render::Mode::mip)
      map.legend =
          "error of the value as a share of the field's range, black 1e-16, red 5e-11, yellow 2e-5, white 1; "
          "magenta: missed or false; dark: nothing";
    if (!result.truth.are_all()) map.legend += "; also dark: pixels that were not judged";
    figures.push_back({concat("Errors of ", measured.variant.name), map.legend,
                       picture(map.framebuffer, name + "_error", map.legend)});
  }
  return figures;
}

std::string ResultsFolder::layer_section(const LayerStudy& layer, const std::string& prefix, StudyContext& context) {
  std::string out = concat("<h2>", html_text(layer.name()), "</h2>\n", how_measured(layer), "<ul class=\"found\">\n");
  for (const std::string& sentence : conclusions_of(layer)) out += concat("<li>", html_text(sentence), "</li>\n");
  out += "</ul>\n";
  const auto figure = [](const Figure& f) {
    return concat("<figure>", f.body, "<figcaption><b>", html_text(f.title), ".</b> ", html_text(f.caption),
                  "</figcaption></figure>\n");
  };
  for (const Figure& plot : plots(layer, prefix, context)) out += figure(plot);
  out += concat("<h3>All variants</h3>\n", results_table(layer));
  // Pictures change from pass to pass only.
  auto& [of_pass, figures] = pictures_[prefix];
  const std::size_t drawn = layer.result()->rows.size();
  const void* const pass = drawn == layer.variants().size() ? layer.result()->true_picture.get() : nullptr;
  if (pass == nullptr || of_pass != pass) figures = pictures(layer, prefix);
  of_pass = pass;
  out += "<h3>Pictures and their errors</h3>\n<div class=\"pictures\">\n";
  for (const Figure& each : figures) out += figure(each);
  return out + "</div>\n";
}

void ResultsFolder::write(const std::vector<const LayerStudy*>& layers, StudyContext& context) {
  if (!has_gnuplot() && std::exchange(has_gnuplot_, false))
    context.notes.push_back(concat("no plots were drawn: they need gnuplot (Debian's package ", gnuplot_package, ")"));
  write_new_file(folder_ / "results.csv", csv_of(table_of(layers, context)), true);
  std::string body = concat("<h1>What accuracy costs in time</h1>\n<p class=\"lead\">",
                            html_text(value_text(context.facts.at("input"))), " · ",
                            html_text(value_text(context.facts.at("date"))), "</p>\n");
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
      "<h2>How it was measured</h2>\n<p>Every variant is asked for the same pixels, and its answers are compared with "
      "those of exact arithmetic for the same rays and the same data: where a value lies on a side of the isovalue is "
      "decided without rounding. Depth errors are distances along the ray in cells, of meshes in longest edges of the "
      "tetrahedron that is hit. Times are CPU times of all threads for a picture whose isovalue is prepared; all "
      "variants take turns, round after round, so that what else runs on the machine meets all of them. A copy of the "
      "data is judged against the data it was made from.</p>\n<h3>Machine and version</h3>\n",
      facts_table(context.facts), "<h3>Command</h3>\n<pre>", html_text(value_text(context.facts.at("command"))),
      "</pre>\n<h3>Columns of results.csv and results.json</h3>\n", columns_table());
  write_new_file(folder_ / "report.html", html_page("What accuracy costs in time", body), true);
  write_new_file(folder_ / "results.json", dump_lines(results_json(layers, context)), true);
}

}  // namespace rhoray::tools
