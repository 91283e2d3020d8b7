// The cost of rays that start at a surface, compared with camera rays. The rays go towards one
// light, and in all directions, in the order of the picture and sorted by direction.

#include "tools/lab/secondary_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "formats/base/read_value.h"
#include "preprocess/input_file.h"
#include "render/isovalue.h"
#include "render/method_words.h"
#include "render/ray_caster.h"
#include "render/scene_spec.h"
#include "tools/lab/rounds.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/bench/views.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::study {

namespace {

using render::Hit;
using render::Ray;

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path input;
  std::string isovalue = "auto", view = "front";
  std::vector<std::string> levels{"float", "certified", "double"};
  render::PictureSize size{512, 512};
  RoundsOptions rounds;
};

struct Kind {
  std::string name;
  std::vector<Ray> rays;
};

/// Camera rays in tiles of 8 x 8 pixels, the groups of the wide kernels.
std::vector<Ray> in_tiles(const std::vector<Ray>& rays, int width, int height) {
  std::vector<Ray> tiled;
  for (int y0 = 0; y0 < height; y0 += 8)
    for (int x0 = 0; x0 < width; x0 += 8)
      for (int y = y0; y < std::min(y0 + 8, height); ++y)
        for (int x = x0; x < std::min(x0 + 8, width); ++x)
          tiled.push_back(
              rays[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)]);
  return tiled;
}

/// The position of a hit, slightly on the eye's side of the surface, and the normal there.
struct Place {
  Vec3 point, normal;
};

std::vector<Place> places_of(const std::vector<Ray>& rays, const std::vector<Hit>& hits) {
  std::vector<Place> places;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const double length = hits[r].gradient.length();
    if (hits[r].is_miss() || !(length > 0)) continue;
    const Vec3 gradient = hits[r].gradient / length;
    const Vec3 normal = gradient.dot(rays[r].direction) > 0 ? -gradient : gradient;
    places.push_back({rays[r].at(hits[r].t) + 0.01 * normal, normal});
  }
  return places;
}

/// Cosine-weighted directions about a normal, as ambient occlusion uses them.
Vec3 around(const Vec3& normal, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const double angle = 2 * std::numbers::pi * share(random), z = 2 * share(random) - 1;
  const double across = std::sqrt(1 - z * z);
  return (normal + Vec3(across * std::cos(angle), across * std::sin(angle), z)).normalized();
}

int octant_of(const Vec3& d) {
  return (d.x < 0 ? 1 : 0) | (d.y < 0 ? 2 : 0) | (d.z < 0 ? 4 : 0);
}

/// Sorts rays by the signs of their directions, within runs of `among` neighbours. Otherwise the
/// order stays.
std::vector<Ray> sorted_by_octant(std::vector<Ray> rays, std::size_t among) {
  for (std::size_t first = 0; first < rays.size(); first += among) {
    const auto begin = rays.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = rays.begin() + static_cast<std::ptrdiff_t>(std::min(first + among, rays.size()));
    std::stable_sort(begin, end,
                     [](const Ray& a, const Ray& b) { return octant_of(a.direction) < octant_of(b.direction); });
  }
  return rays;
}

std::vector<Kind> kinds_of(const render::Dataset& dataset, double isovalue, const Settings& settings) {
  const render::Camera camera = tools::study_camera(tools::study_view_named(settings.view), dataset, isovalue,
                                                    double{1} * settings.size.width / settings.size.height);
  const std::vector<Ray> seen =
      in_tiles(render::camera_rays(dataset, camera, settings.size.width, settings.size.height), settings.size.width,
               settings.size.height);
  std::vector<Hit> hits(seen.size());
  render::RayCaster(dataset, isovalue, render::method_of(render::accuracy_named("certified")), 0)
      .first_crossings(seen, hits);
  const std::vector<Place> places = places_of(seen, hits);
  if (places.empty()) throw Error(ErrorCode::usage, "the view shows no surface; expected some to start rays from");
  const Vec3 light = Vec3(0.4, -0.6, 0.7).normalized();
  std::mt19937_64 random(1);
  Kind to_light{"to a light", {}}, to_anywhere{"to all sides", {}};
  for (const Place& place : places) {
    if (place.normal.dot(light) > 0) to_light.rays.push_back({place.point, light});
    to_anywhere.rays.push_back({place.point, around(place.normal, random)});
  }
  Kind sorted{"to all sides, sorted in 1024", sorted_by_octant(to_anywhere.rays, 1024)};
  Kind alone{"to all sides, from anywhere", to_anywhere.rays};
  std::shuffle(alone.rays.begin(), alone.rays.end(), random);
  return {{"camera", seen}, std::move(to_light), std::move(to_anywhere), std::move(sorted), std::move(alone)};
}

tools::Table measure(const Settings& settings, const std::function<void(const std::string&)>& tell) {
  const render::Dataset dataset = render::Dataset::load(settings.input);
  const double isovalue = render::choose_isovalue(settings.isovalue, dataset.field()).value;
  tell("rays");
  const std::vector<Kind> kinds = kinds_of(dataset, isovalue, settings);
  tools::Table table{"secondary_rays", "Rays from a surface: CPU time of one thread", {}, {}};
  table.context = context_with({{"input", settings.input.filename().string()},
                                {"isovalue", isovalue},
                                {"view", settings.view},
                                {"machine", render::name_of(render::chosen_machine())},
                                {"cycles", cycles_source()},
                                {"repeat", settings.rounds.rounds}});
  for (const Kind& kind : kinds) {
    std::vector<Hit> hits(kind.rays.size());
    std::vector<TimedRow> rows;
    for (const std::string& level : settings.levels)
      rows.push_back({.name = level, .act = [&, level] {
                        const render::Method method = render::method_of(render::accuracy_named(level));
                        render::RayCaster(dataset, isovalue, method).first_crossings(kind.rays, hits);
                      }});
    if (rows.empty() || kind.rays.empty()) continue;
    run_rounds(rows, settings.rounds, [&](const std::string& step) { tell(concat(kind.name, ", ", step)); });
    const auto hit_count = std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return !hit.is_miss(); });
    for (const TimedRow& row : rows) {
      const tools::Spread ms = row.cpu_ms();
      const double count = static_cast<double>(kind.rays.size());
      table.rows.push_back({{"rays", kind.name},
                            {"level", row.name},
                            {"count", kind.rays.size()},
                            {"hit", static_cast<double>(hit_count) / count},
                            {"cpu_ms", ms.median},
                            {"cpu_ms_min", ms.smallest},
                            {"cpu_ms_max", ms.largest},
                            {"cycles_per_ray", row.median_cycles() / count}});
    }
  }
  return table;
}

int run(const Settings& settings) {
  require_publishable(settings.common, {"secondary_rays"});
  require_within("--repeat", settings.rounds.rounds, 1, 10'000);
  preprocess::require_input(settings.input);
  const tools::Table table = [&] {
    tools::ProgressDisplay display(settings.common);
    return measure(settings, [&](const std::string& what) { display.show(what); });
  }();
  publish(table, settings.common);
  return 0;
}

}  // namespace

tools::Subcommand secondary_rays() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "secondary-rays",
      .summary = "Rays that start at a surface, beside camera rays",
      .examples = {"rhoray-study secondary-rays smooth.rho --iso 600.5",
                   "RHORAY_MACHINE=scalar rhoray-study secondary-rays smooth.rho --iso 600.5"},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed file", settings->input)},
           tools::output_options(settings->common, "FOLDER for secondary_rays.csv and .json"),
           {tools::value_option("--iso", "V", "Isovalue, as in render; default auto", settings->isovalue),
            tools::value_option("--view", "NAME", "front, from-feet, close-up or inside; default front",
                                settings->view),
            tools::value_option("--levels", "NAME[,NAME]", "As render's --accuracy; default float,certified,double",
                                settings->levels),
            tools::value_option("--size", "WxH", "Pixels whose hits rays start from; default 512x512", settings->size),
            tools::value_option("--repeat", "N", "Rounds; default 5", settings->rounds.rounds),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
