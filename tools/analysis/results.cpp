#include "tools/analysis/results.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "tools/analysis/measure.h"

namespace rhoray::tools {

namespace {

/// Numbers that are not finite cannot be written to JSON or CSV.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A row of the results, or of nothing to name its columns.
struct RowSource {
  std::string layer{};
  bool is_projection = false;
  render::PictureSize size{};
  const Measured& measured;
  bool is_on_front = false;
};

std::vector<ResultCell> cells_of(const RowSource& source) {
  using render::ErrorCounts;
  const Measured& measured = source.measured;
  const std::optional<ErrorCounts>& errors = measured.errors;
  const std::optional<PictureErrors>& picture = measured.picture_errors;
  const bool is_drawn = measured.left_out.empty(), has_memory = measured.memory_bytes > 0;
  std::vector<ResultCell> cells;
  const auto put = [&](const std::string& name, const char* unit, const char* meaning, Json value) {
    cells.push_back({name, unit, meaning, std::move(value)});
  };
  const auto put_count = [&](const char* name, const char* meaning, std::uint64_t ErrorCounts::*count) {
    put(name, "", meaning, errors ? Json((*errors).*count) : Json(nullptr));
  };
  const auto put_border = [&](const char* name, const char* meaning, std::uint64_t ErrorCounts::Border::*count) {
    put(name, "", meaning, errors && errors->border ? Json((*errors->border).*count) : Json(nullptr));
  };
  const auto put_share = [&](const std::string& name, const char* meaning, std::uint64_t ErrorCounts::*count) {
    std::optional<render::Share> share;
    if (errors) share = render::share_of((*errors).*count, errors->rays, measured.judges_all);
    const auto ppm = [&](double render::Share::*member) {
      return share ? number(1e6 * (*share).*member) : Json(nullptr);
    };
    put(name + "_ppm", "of a million judged pixels", meaning, ppm(&render::Share::found));
    put(name + "_ppm_low", "of a million",
        "lower end of the 95 % interval (Wilson); the value itself where all were judged", ppm(&render::Share::low));
    put(name + "_ppm_high", "of a million", "upper end", ppm(&render::Share::high));
  };
  const auto put_quantiles = [&](const std::string& name, const std::string& ending, const char* unit,
                                 const char* meaning, const std::optional<render::Quantiles>& quantiles) {
    const render::Quantiles of = quantiles.value_or(render::Quantiles{nan, nan, nan});
    put(name + "_median" + ending, unit, meaning, number(of.median));
    put(name + "_p99" + ending, unit, "99 % quantile of the same", number(of.p99));
    put(name + "_max" + ending, unit, "largest of the same", number(of.largest));
  };
  const auto put_times = [&](const std::string& name, const char* meaning, const std::vector<double>& times) {
    const Spread spread = times.empty() ? Spread{nan, nan, nan} : spread_of(times);
    put(name, "ms", meaning, number(spread.median));
    put(name + "_min", "ms", "smallest", number(spread.smallest));
    put(name + "_max", "ms", "largest", number(spread.largest));
  };
  const bool has_depth = errors && !source.is_projection;

  put("layer", "", "what is shown", source.layer);
  put("group", "", "group of the variant", measured.variant.group);
  put("variant", "", "variant that was drawn", measured.variant.name);
  put("data", "", "original data, or the copy that was drawn", text_of(measured.variant.data));
  put("method", "", "value of --accuracy or --method", measured.method);
  put("width", "pixels", "of the picture", source.size.width);
  put("height", "pixels", "of the picture", source.size.height);
  put_count("judged_pixels", "pixels that were compared with the exact answer: all, or a random sample",
            &ErrorCounts::rays);
  put_count("true_hits", "judged pixels that show something", &ErrorCounts::true_hits);
  put_count("missed", "false negatives: pixels that should show something and do not", &ErrorCounts::missed);
  put_count("false_hits", "false positives: pixels that show something and should not", &ErrorCounts::false_hits);
  put_border("border_missed", "false negatives where the resampled grid has no value at the surface",
             &ErrorCounts::Border::missed);
  put_border("border_false", "false positives where the resampled grid shows something outside the mesh",
             &ErrorCounts::Border::false_hits);
  put_border("border_off",
             "pixels where both show something, but only the mesh or only the grid exists at one of the hits; not in "
             "the depths below",
             &ErrorCounts::Border::off);
  put_share("missed", "missed", &ErrorCounts::missed);
  put_share("false", "false hits", &ErrorCounts::false_hits);
  put_quantiles(
      "depth", "_cells", "cells",
      "distance along the ray from the true crossing, where both hit; of resampled grids away from their border",
      has_depth ? errors->error : std::nullopt);
  put("depth_kept_by_99_cells", "cells",
      "error that 99 % of the pixels keep, among those that show or should show something; wrong pixels keep none",
      number(has_depth ? errors->kept_by(0.99) : nan));
  put_quantiles("value", "", "of the field",
                "field at the found position, compared with the isovalue or the largest value",
                errors ? errors->value_error : std::nullopt);
  put_quantiles("normal", "_deg", "degrees", "angle between the normals that light the pictures",
                picture ? picture->normal_deg : std::nullopt);
  put("rmse_of_255", "8-bit levels", "root of the mean square difference of the pictures, in sRGB",
      number(picture ? picture->rmse : nan));
  put("flip", "0 to 1", "mean of FLIP (Andersson et al. 2020), 67 pixels per degree",
      number(picture ? picture->flip : nan));
  put_times("cpu_ms",
            "CPU time of all threads for the picture, median; where `times` is 0, extrapolated from the judged pixels",
            measured.cpu_ms);
  put_times("wall_ms", "elapsed time, median", measured.wall_ms);
  put("times", "", "number of timed pictures", measured.wall_ms.size());
  put("prepare_ms", "ms", "additional time of the first picture after loading data or changing the isovalue",
      number(has_memory ? measured.prepare_ms : nan));
  put("preprocess_s", "s", "time to make the copy of the data", number(is_drawn ? measured.preprocess_s : nan));
  put("data_bytes", "bytes", "size of the file that is mapped or read",
      is_drawn ? Json(measured.data_bytes) : Json(nullptr));
  put("memory_bytes", "bytes",
      "memory that is mapped, plus the growth of the process's anonymous memory by loading the data and drawing a "
      "first picture, without memory given back to the allocator",
      has_memory ? Json(measured.memory_bytes) : Json(nullptr));
  put("front", "", "no other variant of the layer is both faster and more accurate", source.is_on_front);
  put("note", "", "why it was left out, or a remark",
      is_drawn ? measured.note : concat("left out: ", measured.left_out));
  return cells;
}

void mark_front(std::vector<ResultRow>& rows) {
  for (ResultRow& row : rows) {
    if (!row.kept || !std::isfinite(*row.kept)) continue;
    row.is_on_front = std::none_of(rows.begin(), rows.end(), [&](const ResultRow& other) {
      return other.kept && other.cpu_ms <= row.cpu_ms && *other.kept <= *row.kept &&
             (other.cpu_ms < row.cpu_ms || *other.kept < *row.kept);
    });
  }
}

}  // namespace

const std::vector<ResultCell>& result_columns() {
  static const std::vector<ResultCell> columns = cells_of({.measured = Measured{}});
  return columns;
}

std::vector<ResultRow> rows_of(const PassResult& result) {
  std::vector<ResultRow> rows;
  for (const Measured& measured : result.rows) {
    if (!measured.left_out.empty() || measured.cpu_ms.empty()) continue;
    ResultRow row{.measured = &measured, .cpu_ms = spread_of(measured.cpu_ms).median};
    if (measured.errors) row.kept = measured.errors->kept_by(0.99);
    rows.push_back(row);
  }
  mark_front(rows);
  return rows;
}

std::vector<Json> rows_json(const LayerStudy& layer) {
  const std::vector<ResultRow> rows = rows_of(*layer.result());
  std::vector<Json> all;
  for (const Measured& measured : layer.result()->rows) {
    const bool is_on_front = std::any_of(
        rows.begin(), rows.end(), [&](const ResultRow& row) { return row.measured == &measured && row.is_on_front; });
    Json& row = all.emplace_back();
    for (ResultCell& cell : cells_of({.layer = layer.name(),
                            .is_projection = layer.is_projection(),
                            .size = layer.result()->size,
                            .measured = measured,
                            .is_on_front = is_on_front}))
      row[cell.name] = std::move(cell.value);
  }
  return all;
}

Table table_of(const std::vector<const LayerStudy*>& layers, const StudyContext& context) {
  Table table{"accuracy", "Accuracy and time", context.facts, {}};
  for (const LayerStudy* layer : layers)
    if (layer->result() != nullptr)
      for (Json& row : rows_json(*layer)) table.rows.push_back(std::move(row));
  return table;
}

Json results_json(const std::vector<const LayerStudy*>& layers, const StudyContext& context) {
  Json columns = Json::array(), conclusions = Json::array(), shown = Json::array();
  for (const ResultCell& column : result_columns())
    columns.push_back({{"name", column.name}, {"unit", column.unit}, {"meaning", column.meaning}});
  for (const LayerStudy* layer : layers) {
    if (layer->result() == nullptr) continue;
    const PassResult& result = *layer->result();
    shown.push_back({{"layer", layer->name()},
                     {"error_unit", error_unit(*layer)},
                     {"size", {result.size.width, result.size.height}},
                     {"judged_pixels", result.truth.pixels.size()},
                     {"all_pixels_judged", result.truth.are_all()},
                     {"judge_cpu_s", result.truth.cpu_s},
                     {"true_picture", result.picture_method}});
    for (const std::string& sentence : conclusions_of(*layer)) conclusions.push_back(sentence);
  }
  return {{"schema", results_schema},   {"stage", context.stage},
          {"context", context.facts},   {"layers", shown},
          {"conclusions", conclusions}, {"notes", context.notes},
          {"columns", columns},         {"rows", table_of(layers, context).rows}};
}

std::string error_unit(const LayerStudy& layer) {
  if (!layer.is_projection()) return "cells";
  const std::string& unit = layer.dataset().field().unit;
  return unit.empty() ? "in the field's values" : unit;
}

}  // namespace rhoray::tools
