#include <algorithm>
#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"
#include "tools/analysis/page_template.h"
#include "tools/analysis/results.h"

namespace rhoray::tools {

namespace {

using Rows = std::vector<ResultRow>;

std::string ms_text(double ms) {
  return concat(short_number(ms, 3), " ms");
}

std::string times_text(double ratio) {
  return ratio >= 1 ? concat(short_number(ratio, 2), " times") : concat("1/", short_number(1 / ratio, 2));
}

/// A row's name for users: `float`, `sampled:0.5+linear`, "8 bits (float)".
std::string called(const ResultRow& row) {
  const Measured& measured = *row.measured;
  if (measured.variant.name == measured.method) return concat("`", measured.method, "`");
  return concat(measured.variant.name, " (`", measured.method, "`)");
}

const ResultRow* named(const Rows& rows, const std::string& group, const std::string& name) {
  for (const ResultRow& row : rows)
    if (row.measured->variant.group == group && row.measured->variant.name == name) return &row;
  return nullptr;
}

/// The cheapest row on the original data whose error stays below a limit in 99 % of the pixels.
const ResultRow* cheapest_within(const Rows& rows, double limit) {
  const ResultRow* best = nullptr;
  for (const ResultRow& row : rows)
    if (row.kept && *row.kept <= limit && row.measured->variant.data.kind == DataForm::Kind::original &&
        (best == nullptr || row.cpu_ms < best->cpu_ms))
      best = &row;
  return best;
}

std::string wrong_text(const ResultRow& row) {
  const render::ErrorCounts& errors = *row.measured->errors;
  if (row.measured->judges_all) {
    if (errors.missed == 0 && errors.false_hits == 0)
      return concat("no false negatives and no false positives in ", grouped(errors.rays), " pixels");
    return concat("in ", grouped(errors.rays), " pixels: false negatives ", grouped(errors.missed),
                  ", false positives ", grouped(errors.false_hits));
  }
  const auto ppm = [&](std::uint64_t count) {
    const render::Share share = render::share_of(count, errors.rays, false);
    return concat(short_number(1e6 * share.found, 3), " (95 %: ", short_number(1e6 * share.low, 2), " to ",
                  short_number(1e6 * share.high, 2), ")");
  };
  return concat("per million pixels: false negatives ", ppm(errors.missed), ", false positives ",
                ppm(errors.false_hits));
}

/// The method that a picture has by default.
const ResultRow* default_row(const Rows& rows) {
  const ResultRow* row = named(rows, group_levels, "float");
  return row != nullptr ? row : named(rows, group_levels, "double");
}

/// Says what makes the paper's method miss pixels, where it does (render/cell/crossing_methods.h,
/// tet_methods.h).
void say_paper(const LayerStudy& layer, const Rows& rows, std::vector<std::string>& out) {
  const ResultRow* paper = named(rows, group_published, "paper:double");
  if (paper == nullptr || !paper->measured->errors) return;
  const render::ErrorCounts& errors = *paper->measured->errors;
  if (errors.missed + errors.false_hits == 0) return;
  out.push_back(concat("The paper's method (`paper:double`): ", wrong_text(*paper), ". ",
                       layer.dataset().is_mesh()
                           ? "It tests each tetrahedron alone: rounding can put a ray that passes a shared face, edge "
                             "or point outside all tetrahedra there, and the ray goes through the surface."
                           : "It expands the cubic of a cell around the eye, where the coefficients lose digits, and "
                             "takes coefficients below a fixed size for 0: roots then appear or vanish."));
}

/// Says which method is sufficient for which error.
void say_fastest(const LayerStudy& layer, const Rows& rows, std::vector<std::string>& out) {
  const bool is_projection = layer.is_projection();
  const Interval<double> range = layer.dataset().field().range;
  const double unit = is_projection ? range.hi - range.lo : 1;
  const auto say = [&](double limit, const ResultRow& best) {
    out.push_back(concat("The fastest method that is within ", rounded(limit),
                         is_projection ? " of the field's range" : " cells", " in 99 % of the pixels is ", called(best),
                         ": ", ms_text(best.cpu_ms), " of CPU time per picture; ", wrong_text(best), "."));
  };
  // If one method is the answer for several limits, the tightest one is enough.
  constexpr double limits[] = {0.1, 0.01, 0.001, 1e-6};
  for (std::size_t i = 0; i < std::size(limits); ++i) {
    const ResultRow* best = cheapest_within(rows, limits[i] * unit);
    if (best == nullptr) break;
    const bool is_last = i + 1 == std::size(limits) || cheapest_within(rows, limits[i + 1] * unit) != best;
    if (is_last) say(limits[i], *best);
  }
}

void say_proof(const LayerStudy& layer, const Rows& rows, std::vector<std::string>& out) {
  const ResultRow *proven = named(rows, group_levels, "certified"), *exact = named(rows, group_levels, "exact");
  const ResultRow* quick = default_row(rows);
  if (proven == nullptr || quick == nullptr) return;
  std::string sentence =
      concat("A proof of every hit and miss (`certified`) takes ", times_text(proven->cpu_ms / quick->cpu_ms),
             " the time of `", quick->measured->method, "`");
  if (exact != nullptr)
    sentence += concat(", exact arithmetic for every ray (`exact`) ", times_text(exact->cpu_ms / quick->cpu_ms));
  out.push_back(sentence + ".");
  if (!layer.is_projection())
    out.push_back(concat("`", quick->measured->method, "`: ", wrong_text(*quick), "; depth errors are within ",
                         short_number(quick->measured->errors->error.value_or(render::Quantiles{}).p99, 2),
                         " cells in 99 % of the pixels that both hit."));
}

void say_sampled(const LayerStudy& layer, const Rows& rows, std::vector<std::string>& out) {
  const ResultRow* own = default_row(rows);
  for (const char* group : {group_linear, group_samples}) {
    const ResultRow* half = named(rows, group, "sampled:0.5+linear");
    if (half == nullptr || own == nullptr) continue;
    // Times extrapolated from some rays are not compared with those of pictures.
    const std::string time =
        half->measured->wall_ms.empty()
            ? std::string("was too slow for a picture in the time given")
            : concat("takes ", times_text(half->cpu_ms / own->cpu_ms), " the time of `", own->measured->method, "`");
    const std::string own_error = concat(short_number(own->kept.value_or(0), 2), " ", error_unit(layer));
    const std::string found =
        std::isfinite(half->kept.value_or(0))
            ? concat("Its error is within ", short_number(half->kept.value_or(0), 2), " ", error_unit(layer),
                     " in 99 % of the pixels, that of `", own->measured->method, "` within ", own_error)
            : concat("More than 1 % of its pixels are false negatives or false positives; the error of `",
                     own->measured->method, "` is within ", own_error, " in 99 % of the pixels");
    out.push_back(concat("Sampling every half cell (`", half->measured->method, "`), as many renderers do, ", time,
                         ". ", found, ". Sampling: ", wrong_text(*half), "."));
  }
}

/// One sentence for each kind of copy.
void say_copies(const LayerStudy& layer, const Rows& rows, std::vector<std::string>& out) {
  for (const char* group : {group_bits, group_grids, group_vdb}) {
    std::string list;
    for (const ResultRow& row : rows) {
      const Measured& measured = *row.measured;
      if (measured.variant.group != group || !row.kept) continue;
      const std::string within =
          std::isfinite(*row.kept)
              ? concat("99 % of the pixels within ", short_number(*row.kept, 2), " ", error_unit(layer))
              : concat("more than 1 % of the pixels false negatives or false positives");
      list += concat(list.empty() ? "" : "; ", called(row), ": ", within, ", ", ms_text(row.cpu_ms), " of CPU, ",
                     bytes_text(measured.memory_bytes), " of memory");
    }
    if (!list.empty()) out.push_back(concat("Drawn from copies, ", group, ". ", list, "."));
  }
}

/// The slope of error against step, over the steps where the error is above rounding.
void say_order(const Rows& rows, std::vector<std::string>& out) {
  for (const char* group : {group_linear, group_bisect, group_samples}) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0, n = 0;
    for (const ResultRow& row : rows) {
      const Measured& measured = *row.measured;
      if (measured.variant.group != group || !measured.errors || !measured.errors->error) continue;
      const double error = measured.errors->error->median, step = measured.variant.method->step;
      if (!(error > 1e-9) || step > 1) continue;
      const double x = std::log2(step), y = std::log2(error);
      sx += x, sy += y, sxx += x * x, sxy += x * y, n += 1;
    }
    if (n < 4) continue;
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    out.push_back(concat(group, ": halving the step divides the median error by ", short_number(std::exp2(slope), 2),
                         " (order ", short_number(slope, 2), ", fitted over steps of at most one cell)."));
  }
}

/// Says how far smooth normals are from those of the field.
void say_normals(const Rows& rows, std::vector<std::string>& out) {
  for (const ResultRow& row : rows) {
    const Measured& measured = *row.measured;
    if (measured.variant.group != group_normals || !measured.picture_errors || !measured.picture_errors->normal_deg)
      continue;
    const render::Quantiles& angle = *measured.picture_errors->normal_deg;
    out.push_back(concat("Smooth and ", measured.variant.name == "flat normals" ? "flat" : "exact",
                         " normals differ by ", short_number(angle.median, 2), " degrees in the median, by at most ",
                         short_number(angle.p99, 2), " in 99 % of the pixels and by ", short_number(angle.largest, 2),
                         " at most. They change the shading, not the surface."));
  }
}

}  // namespace

std::string verdict_of(const LayerStudy& layer) {
  if (layer.result() == nullptr) return {};
  const Rows rows = rows_of(*layer.result());
  const ResultRow* row = default_row(rows);
  if (row == nullptr || !row->measured->errors) return {};
  const render::ErrorCounts& errors = *row->measured->errors;
  std::string text = concat("The default, `", row->measured->method, "`: ", wrong_text(*row));
  if (const auto& off = errors.value_error) {
    const std::string& unit = layer.dataset().field().unit;
    const std::string within = concat(short_number(off->p99, 2), unit.empty() ? "" : " ", unit);
    text += layer.is_projection() ? concat("; 99 % of the values are within ", within, " of the largest on their ray")
                                  : concat("; in 99 % of the pixels '", layer.dataset().field().name, "' is within ",
                                           within, " of the isovalue where the surface is drawn");
  }
  return text + ".";
}

std::vector<std::string> conclusions_of(const LayerStudy& layer) {
  std::vector<std::string> out;
  if (layer.result() == nullptr) return out;
  const Rows rows = rows_of(*layer.result());
  say_fastest(layer, rows, out);
  say_proof(layer, rows, out);
  say_paper(layer, rows, out);
  say_sampled(layer, rows, out);
  say_order(rows, out);
  say_copies(layer, rows, out);
  say_normals(rows, out);
  return out;
}

}  // namespace rhoray::tools
