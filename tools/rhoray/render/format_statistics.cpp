#include "tools/rhoray/render/format_statistics.h"

#include <cmath>

#include "formats/base/number_text.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

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
  const render::FrameStatistics::Phases& phases = statistics.phases;
  return {{"rays", statistics.rays},
          {"rays_ruled_out", statistics.rays_ruled_out},
          {"rays_clipped", statistics.rays_clipped},
          {"rays_clipped_away", statistics.rays_clipped_away},
          {"clear_crossings", statistics.clear_crossings},
          {"rays_through", statistics.rays_through},
          {"shadow_rays", statistics.shadow_rays},
          {"occlusion_rays", statistics.occlusion_rays},
          {"slice_lookups", statistics.slice_lookups},
          {"edge_pixels", statistics.edge_pixels},
          {"edge_samples", statistics.edge_samples},
          {"hits", statistics.hits},
          {"macrocells_visited", statistics.macrocells_visited},
          {"cells_visited", statistics.cells_visited},
          {"cells_solved", statistics.cells_solved},
          {"samples_taken", statistics.samples_taken},
          {"rays_redone_in_double", statistics.rays_redone},
          {"rays_judged_exactly", statistics.rays_exact},
          {"touches", statistics.touches},
          {"largest_error", statistics.largest_error},
          {"highlights_shaded", statistics.highlights_shaded},
          {"normals_smoothed", statistics.normals_smoothed},
          {"colors_looked_up", statistics.colors_looked_up},
          {"texture_lookups", statistics.texture_lookups},
          {"machine", statistics.machine},
          {"preparation_s", statistics.preparation_s},
          {"wall_s", statistics.wall_s},
          {"range_proof", proof_json(statistics.range_proof)},
          {"phases_cpu_s",
           {{"traversal", phases.traversal}, {"intersection", phases.intersection}, {"shading", phases.shading}}}};
}

std::string statistics_text(const render::FrameStatistics& statistics) {
  const auto count = [](const char* name, std::uint64_t number) {
    return concat("  ", name, std::string(22 - std::string_view(name).size(), ' '), grouped(number), "\n");
  };
  const render::FrameStatistics::Phases& phases = statistics.phases;
  const double all = phases.traversal + phases.intersection + phases.shading;
  const auto phase = [&](const char* name, double seconds) {
    return concat("  ", name, std::string(22 - std::string_view(name).size(), ' '), rounded(seconds, 3), " s of CPU, ",
                  rounded(all > 0 ? 100 * seconds / all : 0, 3), " %\n");
  };
  return count("rays", statistics.rays) + count("culled rays", statistics.rays_ruled_out) +
         count("clipped", statistics.rays_clipped) + count("clipped-away rays", statistics.rays_clipped_away) +
         count("transparent hits", statistics.clear_crossings) + count("continued rays", statistics.rays_through) +
         count("shadow rays", statistics.shadow_rays) + count("occlusion rays", statistics.occlusion_rays) +
         count("slice lookups", statistics.slice_lookups) + count("edge pixels", statistics.edge_pixels) +
         count("edge samples", statistics.edge_samples) + count("hits", statistics.hits) +
         count("macrocells visited", statistics.macrocells_visited) + count("cells visited", statistics.cells_visited) +
         count("cells solved", statistics.cells_solved) + count("samples taken", statistics.samples_taken) +
         count("re-traced in double", statistics.rays_redone) + count("decided exactly", statistics.rays_exact) +
         count("tangent hits", statistics.touches) +
         (std::isnan(statistics.largest_error)
              ? std::string()
              : concat("  largest error         ", rounded(statistics.largest_error), "\n")) +
         count("highlights shaded", statistics.highlights_shaded) +
         count("normals smoothed", statistics.normals_smoothed) +
         count("colours looked up", statistics.colors_looked_up) +
         count("texture lookups", statistics.texture_lookups) + phase("traversal", phases.traversal) +
         phase("intersection", phases.intersection) + phase("shading", phases.shading) +
         concat("  preparation          ", rounded(statistics.preparation_s, 3), " s\n") +
         concat("  tracing              ", rounded(statistics.wall_s, 3), " s\n") +
         concat("  ranges checked       ", proof_text(statistics.range_proof), "\n");
}

}  // namespace rhoray::tools
