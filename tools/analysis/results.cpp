#include "tools/analysis/results.h"

#include <algorithm>
#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "tools/analysis/measure.h"

namespace rhoray::tools {

namespace {

/// Numbers that are not finite cannot be written to JSON or CSV.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

void put_quantiles(Json& row, const std::string& name, const std::string& unit,
                   const std::optional<render::Quantiles>& quantiles) {
  const auto put = [&](const char* which, double render::Quantiles::*member) {
    row[concat(name, "_", which, unit)] = quantiles ? number((*quantiles).*member) : Json(nullptr);
  };
  put("median", &render::Quantiles::median);
  put("p99", &render::Quantiles::p99);
  put("max", &render::Quantiles::largest);
}

void put_share(Json& row, const std::string& name, const std::optional<render::Share>& share) {
  const auto ppm = [&](double render::Share::*member) {
    return share ? number(1e6 * (*share).*member) : Json(nullptr);
  };
  row[name + "_ppm"] = ppm(&render::Share::found);
  row[name + "_ppm_low"] = ppm(&render::Share::low);
  row[name + "_ppm_high"] = ppm(&render::Share::high);
}

void put_times(Json& row, const std::string& name, const std::vector<double>& times) {
  const std::optional<Spread> spread = times.empty() ? std::nullopt : std::optional(spread_of(times));
  const auto put = [&](const char* which, double Spread::*member) {
    row[name + which] = spread ? number((*spread).*member) : Json(nullptr);
  };
  put("", &Spread::median);
  put("_min", &Spread::smallest);
  put("_max", &Spread::largest);
}

Json row_json(const LayerStudy& layer, const PassResult& result, const Measured& measured, bool is_on_front) {
  const bool is_projection = layer.scene().layers[0].mode == render::Mode::mip;
  const std::optional<render::ErrorCounts>& errors = measured.errors;
  Json row{{"layer", layer.name()},
           {"group", measured.variant.group},
           {"variant", measured.variant.name},
           {"data", text_of(measured.variant.data)},
           {"method", measured.method},
           {"width", result.size.width},
           {"height", result.size.height},
           {"judged_pixels", errors ? Json(errors->rays) : Json(nullptr)},
           {"true_hits", errors ? Json(errors->true_hits) : Json(nullptr)},
           {"missed", errors ? Json(errors->missed) : Json(nullptr)},
           {"false_hits", errors ? Json(errors->false_hits) : Json(nullptr)}};
  const auto at_border = [&](std::uint64_t render::ErrorCounts::Border::*count) {
    return errors && errors->border ? Json((*errors->border).*count) : Json(nullptr);
  };
  row["border_missed"] = at_border(&render::ErrorCounts::Border::missed);
  row["border_false"] = at_border(&render::ErrorCounts::Border::false_hits);
  row["border_off"] = at_border(&render::ErrorCounts::Border::off);
  const auto share = [&](std::uint64_t render::ErrorCounts::*count) {
    return errors ? std::optional(render::share_of((*errors).*count, errors->rays, measured.judges_all)) : std::nullopt;
  };
  put_share(row, "missed", share(&render::ErrorCounts::missed));
  put_share(row, "false", share(&render::ErrorCounts::false_hits));
  const std::optional<render::Quantiles> none;
  put_quantiles(row, "depth", "_cells", errors && !is_projection ? errors->error : none);
  row["depth_kept_by_99_cells"] = errors && !is_projection ? number(errors->kept_by(0.99)) : Json(nullptr);
  put_quantiles(row, "value", "", errors ? errors->value_error : none);
  put_quantiles(row, "normal", "_deg", measured.picture_errors ? measured.picture_errors->normal_deg : none);
  row["rmse_of_255"] = measured.picture_errors ? number(measured.picture_errors->rmse) : Json(nullptr);
  row["flip"] = measured.picture_errors ? number(measured.picture_errors->flip) : Json(nullptr);
  put_times(row, "cpu_ms", measured.cpu_ms);
  put_times(row, "wall_ms", measured.wall_ms);
  row["times"] = measured.wall_ms.size();
  row["prepare_ms"] = measured.memory_bytes > 0 ? number(measured.prepare_ms) : Json(nullptr);
  row["preprocess_s"] = measured.left_out.empty() ? number(measured.preprocess_s) : Json(nullptr);
  row["data_bytes"] = measured.left_out.empty() ? Json(measured.data_bytes) : Json(nullptr);
  row["memory_bytes"] = measured.memory_bytes > 0 ? Json(measured.memory_bytes) : Json(nullptr);
  row["front"] = is_on_front;
  row["note"] = measured.left_out.empty() ? measured.note : concat("left out: ", measured.left_out);
  return row;
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

const std::vector<ResultColumn>& result_columns() {
  static const std::vector<ResultColumn> columns{
      {"layer", "", "what is shown"},
      {"group", "", "group of the variant"},
      {"variant", "", "variant that was drawn"},
      {"data", "", "original data, or the copy that was drawn"},
      {"method", "", "value of --accuracy or --method"},
      {"width", "pixels", "of the picture"},
      {"height", "pixels", "of the picture"},
      {"judged_pixels", "", "pixels that were compared with the exact answer: all, or a random sample"},
      {"true_hits", "", "judged pixels that show something"},
      {"missed", "", "false negatives: pixels that should show something and do not"},
      {"false_hits", "", "false positives: pixels that show something and should not"},
      {"border_missed", "", "false negatives where the resampled grid has no value at the surface"},
      {"border_false", "", "false positives where the resampled grid shows something outside the mesh"},
      {"border_off", "",
       "pixels where both show something, but only the mesh or only the grid exists at one of the hits; not in the "
       "depths below"},
      {"missed_ppm", "of a million judged pixels", "missed"},
      {"missed_ppm_low", "of a million",
       "lower end of the 95 % interval (Wilson); the value itself where all were judged"},
      {"missed_ppm_high", "of a million", "upper end"},
      {"false_ppm", "of a million judged pixels", "false hits"},
      {"false_ppm_low", "of a million", "lower end of the 95 % interval"},
      {"false_ppm_high", "of a million", "upper end"},
      {"depth_median_cells", "cells",
       "distance along the ray from the true crossing, where both hit; of resampled grids away from their border"},
      {"depth_p99_cells", "cells", "99 % quantile of the same"},
      {"depth_max_cells", "cells", "largest of the same"},
      {"depth_kept_by_99_cells", "cells",
       "error that 99 % of the pixels keep, among those that show or should show something; wrong pixels keep none"},
      {"value_median", "of the field", "field at the found position, compared with the isovalue or the largest value"},
      {"value_p99", "of the field", "99 % quantile of the same"},
      {"value_max", "of the field", "largest of the same"},
      {"normal_median_deg", "degrees", "angle between the normals that light the pictures"},
      {"normal_p99_deg", "degrees", "99 % quantile of the same"},
      {"normal_max_deg", "degrees", "largest of the same"},
      {"rmse_of_255", "8-bit levels", "root of the mean square difference of the pictures, in sRGB"},
      {"flip", "0 to 1", "mean of FLIP (Andersson et al. 2020), 67 pixels per degree"},
      {"cpu_ms", "ms",
       "CPU time of all threads for the picture, median; where `times` is 0, extrapolated from the judged pixels"},
      {"cpu_ms_min", "ms", "smallest"},
      {"cpu_ms_max", "ms", "largest"},
      {"wall_ms", "ms", "elapsed time, median"},
      {"wall_ms_min", "ms", "smallest"},
      {"wall_ms_max", "ms", "largest"},
      {"times", "", "number of timed pictures"},
      {"prepare_ms", "ms", "additional time of the first picture after loading data or changing the isovalue"},
      {"preprocess_s", "s", "time to make the copy of the data"},
      {"data_bytes", "bytes", "size of the file that is mapped or read"},
      {"memory_bytes", "bytes",
       "memory that is mapped, plus the growth of the process's anonymous memory by loading the data and drawing a "
       "first picture, without memory given back to the allocator"},
      {"front", "", "no other variant of the layer is both faster and more accurate"},
      {"note", "", "why it was left out, or a remark"}};
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

Table table_of(const std::vector<const LayerStudy*>& layers, const StudyContext& context) {
  Table table{"accuracy", "Accuracy and time", context.facts, {}};
  for (const LayerStudy* layer : layers) {
    if (layer->result() == nullptr) continue;
    const std::vector<ResultRow> rows = rows_of(*layer->result());
    for (const Measured& measured : layer->result()->rows) {
      const bool is_on_front = std::any_of(
          rows.begin(), rows.end(), [&](const ResultRow& row) { return row.measured == &measured && row.is_on_front; });
      table.rows.push_back(row_json(*layer, *layer->result(), measured, is_on_front));
    }
  }
  return table;
}

Json results_json(const std::vector<const LayerStudy*>& layers, const StudyContext& context) {
  Json columns = Json::array(), conclusions = Json::array(), shown = Json::array();
  for (const ResultColumn& column : result_columns())
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

std::string short_number(double number, int digits) {
  const double size = std::abs(number);
  return size >= std::pow(10, digits) && size < 1e7 ? concat(std::llround(number)) : rounded(number, digits);
}

std::string error_unit(const LayerStudy& layer) {
  if (layer.scene().layers[0].mode != render::Mode::mip) return "cells";
  const std::string& unit = layer.dataset().field().unit;
  return unit.empty() ? "in the field's values" : unit;
}

}  // namespace rhoray::tools
