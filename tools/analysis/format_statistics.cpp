#include "tools/analysis/format_statistics.h"

#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

struct Counter {
  const char *key, *name;  ///< in JSON, and in the table
  std::uint64_t render::FrameStatistics::*count;
};
using Counts = render::FrameStatistics;
constexpr Counter counters[] = {{"rays", "rays", &Counts::rays},
                                {"rays_ruled_out", "culled rays", &Counts::rays_ruled_out},
                                {"rays_clipped", "clipped", &Counts::rays_clipped},
                                {"rays_clipped_away", "clipped-away rays", &Counts::rays_clipped_away},
                                {"clear_crossings", "transparent hits", &Counts::clear_crossings},
                                {"rays_through", "continued rays", &Counts::rays_through},
                                {"shadow_rays", "shadow rays", &Counts::shadow_rays},
                                {"occlusion_rays", "occlusion rays", &Counts::occlusion_rays},
                                {"slice_lookups", "slice lookups", &Counts::slice_lookups},
                                {"edge_pixels", "edge pixels", &Counts::edge_pixels},
                                {"edge_samples", "edge samples", &Counts::edge_samples},
                                {"hits", "hits", &Counts::hits},
                                {"macrocells_visited", "macrocells visited", &Counts::macrocells_visited},
                                {"cells_visited", "cells visited", &Counts::cells_visited},
                                {"cells_solved", "cells solved", &Counts::cells_solved},
                                {"samples_taken", "samples taken", &Counts::samples_taken},
                                {"rays_redone_in_double", "re-traced in double", &Counts::rays_redone},
                                {"rays_judged_exactly", "decided exactly", &Counts::rays_exact},
                                {"touches", "tangent hits", &Counts::touches},
                                {"highlights_shaded", "highlights shaded", &Counts::highlights_shaded},
                                {"normals_smoothed", "normals smoothed", &Counts::normals_smoothed},
                                {"colors_looked_up", "colours looked up", &Counts::colors_looked_up},
                                {"texture_lookups", "texture lookups", &Counts::texture_lookups}};

double seconds_per_gib(const render::RangeProof& proof) {
  return proof.wall_s * 0x1p30 / static_cast<double>(proof.bytes);
}

}  // namespace

Json proof_json(const render::RangeProof& proof) {
  Json json{{"bytes", proof.bytes}, {"wall_s", proof.wall_s}, {"s_per_gib", nullptr}};
  if (proof.bytes > 0) json["s_per_gib"] = seconds_per_gib(proof);
  return json;
}

std::string proof_text(const render::RangeProof& proof) {
  if (proof.bytes == 0) return "none";
  return concat(bytes_text(proof.bytes), " in ", rounded(proof.wall_s, 3), " s, ", rounded(seconds_per_gib(proof), 3),
                " s/GiB");
}

Json statistics_json(const render::FrameStatistics& statistics) {
  Json json;
  for (const Counter& counter : counters) json[counter.key] = statistics.*counter.count;
  const render::FrameStatistics::Phases& phases = statistics.phases;
  json.update(
      Json{{"largest_error", statistics.largest_error},
           {"machine", statistics.machine},
           {"preparation_s", statistics.preparation_s},
           {"wall_s", statistics.wall_s},
           {"range_proof", proof_json(statistics.range_proof)},
           {"phases_cpu_s",
            {{"traversal", phases.traversal}, {"intersection", phases.intersection}, {"shading", phases.shading}}}});
  return json;
}

std::string statistics_text(const render::FrameStatistics& statistics) {
  const auto row = [](std::string_view name, const std::string& text) {
    return concat("  ", name, std::string(22 - name.size(), ' '), text, "\n");
  };
  std::string text;
  for (const Counter& counter : counters) text += row(counter.name, grouped(statistics.*counter.count));
  if (!std::isnan(statistics.largest_error)) text += row("largest error", rounded(statistics.largest_error));
  const auto& [traversal, intersection, shading] = statistics.phases;
  const double all = traversal + intersection + shading;
  for (const auto& [name, seconds] :
       {std::pair{"traversal", traversal}, {"intersection", intersection}, {"shading", shading}})
    text += row(name, concat(rounded(seconds, 3), " s of CPU, ", rounded(all > 0 ? 100 * seconds / all : 0, 3), " %"));
  return text + row("preparation", concat(rounded(statistics.preparation_s, 3), " s")) +
         row("tracing", concat(rounded(statistics.wall_s, 3), " s")) +
         row("ranges checked", proof_text(statistics.range_proof));
}

}  // namespace rhoray::tools
