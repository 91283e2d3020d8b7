// The largest value along rays through grids. Compares the exact method and the certified one with
// exact arithmetic. Measures how far the values on the cells' faces (Parker et al. 1999, 4.3) and
// sampling fall short.

#include "tools/lab/largest_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <numbers>

#include "formats/base/parallel.h"
#include "formats/base/read_value.h"
#include "preprocess/pack_volume.h"
#include "render/ray_caster.h"
#include "tools/lab/hard_cells.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/cli/interrupt.h"
#include "tools/rhoray/cli/progress_display.h"

namespace rhoray::study {
namespace {

using render::Hit;
using render::Method;

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
  std::uint64_t rays = 100'000;  ///< per field
  std::int64_t samples = 64;
  std::uint64_t seed = 1;
};

/// A field in the cube [-1, 1]^3.
struct FieldToShow {
  const char* name;
  double (*at)(const Vec3& p, Dice& dice);
};

/// The test signal of Marschner and Lobb (IEEE Visualization 1994).
double marschner_lobb(const Vec3& p, Dice&) {
  constexpr double pi = std::numbers::pi, frequency = 6, alpha = 0.25;
  const double ripple = std::cos(2 * pi * frequency * std::cos(pi * std::hypot(p.x, p.y) / 2));
  return (1 - std::sin(pi * p.z / 2) + alpha * (1 + ripple)) / (2 * (1 + alpha));
}

/// One to two samples thick.
double thin_shell(const Vec3& p, Dice&) {
  return std::abs(p.length() - 0.7) < 0.02 ? 1 : 0;
}

double noise(const Vec3&, Dice& dice) {
  return dice.unit();
}

constexpr FieldToShow fields[] = {{"marschner-lobb", marschner_lobb}, {"thin-shell", thin_shell}, {"noise", noise}};

struct MethodToShow {
  const char* name;
  Method method;
};
constexpr MethodToShow methods[] = {{"certified", {.algorithm = Method::Algorithm::certified}},
                                    {"exact (double)", {.algorithm = Method::Algorithm::direct}},
                                    {"face", {.algorithm = Method::Algorithm::paper}},
                                    {"sampled:0.1", {.algorithm = Method::Algorithm::sampled, .step = 0.1}},
                                    {"sampled:0.5", {.algorithm = Method::Algorithm::sampled, .step = 0.5}},
                                    {"sampled:1", {.algorithm = Method::Algorithm::sampled, .step = 1}}};

render::Dataset packed(const FieldToShow& field, const Settings& settings, const std::filesystem::path& folder) {
  preprocess::NeutralVolume volume;
  const std::int64_t count = settings.samples;
  volume.sample_count = Index3(count);
  volume.type = formats::ElementType::F32;
  volume.field_name = "value";
  Dice dice(settings.seed);
  const double step = 2.0 / static_cast<double>(count - 1);
  for (std::int64_t k = 0; k < count; ++k)
    for (std::int64_t j = 0; j < count; ++j)
      for (std::int64_t i = 0; i < count; ++i) {
        const Vec3 p(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        const float value = static_cast<float>(field.at(step * p - Vec3(1), dice));
        const std::size_t at = volume.owned_samples.size();
        volume.owned_samples.resize(at + sizeof value);
        std::memcpy(volume.owned_samples.data() + at, &value, sizeof value);
      }
  volume.samples = volume.owned_samples;
  const std::filesystem::path file = folder / concat(field.name, ".rho");
  preprocess::pack_volume(volume, file);
  return render::Dataset::load(file);
}

/// A ray through the box: half of them anywhere, a quarter through samples, a quarter through
/// edges. Some run along axes and diagonals.
render::Ray any_ray(std::int64_t samples, Dice& dice) {
  const double size = static_cast<double>(samples - 1);
  Vec3 target(size * dice.unit(), size * dice.unit(), size * dice.unit());
  if (dice.coin()) {
    const int free_axis = dice.below(6);
    for (int axis = 0; axis < 3; ++axis)
      if (axis != free_axis) target[axis] = std::round(target[axis]);
  }
  Vec3 direction(0);
  const bool is_special = dice.below(4) == 0;
  while (!(direction.length2() > 0.01))
    for (int axis = 0; axis < 3; ++axis) direction[axis] = is_special ? dice.below(3) - 1 : dice.between(-1, 1);
  return {.origin = target - 2 * size / direction.length() * direction, .direction = direction};
}

/// How far a method's values are below the exact ones, as fractions of the field's range. Parts add
/// up in order.
struct Tally {
  std::uint64_t rays = 0, wrong = 0, above = 0, short_by_1e9 = 0, short_by_1_percent = 0, missed = 0;
  double sum = 0, largest = 0, largest_difference = 0, largest_bound = 0;

  void add(const Tally& other) {
    rays += other.rays, wrong += other.wrong, above += other.above, missed += other.missed;
    short_by_1e9 += other.short_by_1e9, short_by_1_percent += other.short_by_1_percent;
    sum += other.sum;
    largest = std::max(largest, other.largest);
    largest_difference = std::max(largest_difference, other.largest_difference);
    largest_bound = std::max(largest_bound, other.largest_bound);
  }

  /// @param range  of the field
  void count(const Hit& hit, const Hit& truth, double range) {
    ++rays;
    if (hit.is_miss() != truth.is_miss()) {
      ++missed;
      return;
    }
    if (truth.is_miss()) return;
    const double deficit = (truth.value - hit.value) / range;
    sum += std::max(deficit, 0.0);
    largest = std::max(largest, deficit);
    largest_difference = std::max(largest_difference, std::abs(deficit));
    short_by_1e9 += deficit > 1e-9;
    short_by_1_percent += deficit > 1e-2;
    above += deficit < -1e-9;
    if (std::isnan(hit.error)) return;
    wrong += !(std::abs(hit.value - truth.value) <= hit.error + truth.error);
    largest_bound = std::max(largest_bound, hit.error / range);
  }
};
using Tallies = std::array<Tally, std::size(methods)>;

constexpr std::uint64_t chunk_size = 1024;

/// Makes rays from one seed per chunk, so that the result does not depend on which thread works on
/// which chunk.
Tallies tally(const render::Dataset& volume, const Settings& settings,
              const std::function<void(std::uint64_t)>& tell_done) {
  const double range = volume.field().range.hi - volume.field().range.lo;
  const std::uint64_t chunks = (settings.rays + chunk_size - 1) / chunk_size;
  std::vector<Tallies> parts(chunks);
  std::mutex telling;
  parallel_for_each(chunks, [&](std::uint64_t chunk) {
    Dice dice((settings.seed << 48) ^ chunk);
    std::vector<render::Ray> rays(std::min(chunk_size, settings.rays - chunk * chunk_size));
    for (render::Ray& ray : rays) ray = any_ray(settings.samples, dice);
    std::vector<Hit> truth(rays.size()), hits(rays.size());
    render::RayCaster(volume, 0, {.algorithm = Method::Algorithm::exact}).largest_values(rays, truth);
    for (std::size_t m = 0; m < std::size(methods); ++m) {
      render::RayCaster(volume, 0, methods[m].method).largest_values(rays, hits);
      for (std::size_t r = 0; r < rays.size(); ++r) parts[chunk][m].count(hits[r], truth[r], range);
    }
    const std::scoped_lock lock(telling);
    tell_done(rays.size());
  });
  Tallies whole;
  for (const Tallies& part : parts)
    for (std::size_t m = 0; m < part.size(); ++m) whole[m].add(part[m]);
  return whole;
}

Json row_of(const FieldToShow& field, const MethodToShow& method, const Tally& tally) {
  const auto share = [&](std::uint64_t count) { return static_cast<double>(count) / static_cast<double>(tally.rays); };
  return {{"field", field.name},
          {"method", method.name},
          {"rays", tally.rays},
          {"hit_or_miss_wrong", tally.missed},
          {"bound_broken", tally.wrong},
          {"largest_difference", tally.largest_difference},
          {"largest_bound", tally.largest_bound},
          {"mean_deficit", tally.sum / static_cast<double>(tally.rays)},
          {"largest_deficit", tally.largest},
          {"share_short_by_1e-9", share(tally.short_by_1e9)},
          {"share_short_by_1_percent", share(tally.short_by_1_percent)},
          {"above_by_1e-9", tally.above}};
}

int run(const Settings& settings) {
  require_within("--rays", static_cast<double>(settings.rays), 1, 1e10);
  require_within("--samples", static_cast<double>(settings.samples), 2, 1024);
  require_publishable(settings.common, {"largest_values"});
  require_within("--seed", static_cast<double>(settings.seed), 0, 65535);
  const ThreadLimit limit(settings.common.threads);
  const tools::ScratchFolder scratch(settings.scratch);
  const tools::Stopwatch watch;
  tools::Table table{
      "largest_values", "Largest values along rays, in parts of the field's range, against the judge", {}, {}};
  bool is_right = true;
  {
    tools::ProgressDisplay display(settings.common);
    for (const FieldToShow& field : fields) {
      std::uint64_t done = 0;
      const Tallies tallies = tally(packed(field, settings, scratch.path()), settings, [&](std::uint64_t count) {
        display.show(concat(field.name, " [rays]"), done += count, settings.rays);
      });
      for (std::size_t m = 0; m < tallies.size(); ++m) {
        table.rows.push_back(row_of(field, methods[m], tallies[m]));
        is_right = is_right && tallies[m].wrong == 0;
      }
    }
  }
  table.context = context_with({{"samples", settings.samples}, {"seed", settings.seed}, {"wall_s", watch.seconds()}});
  publish(table, settings.common);
  return is_right ? 0 : static_cast<int>(ErrorCode::outside_limit);
}

}  // namespace

tools::Subcommand largest_values() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "largest-values",
      .summary = "The largest value along rays: every method against the exact judge",
      .examples = {"rhoray-study largest-values --rays 1000000 -o results"},
      .options = tools::all_options(
          {tools::output_options(settings->common, "FOLDER for largest_values.csv and .json"),
           {tools::value_option("--scratch", "FOLDER", "For the packed volumes", settings->scratch),
            tools::value_option("--rays", "N", "Through each field; default 100000", settings->rays),
            tools::value_option("--samples", "N", "Samples on an axis; default 64", settings->samples),
            tools::value_option("--seed", "N", "Of the random numbers, 0 to 65535; default 1", settings->seed)},
           tools::threads_option(settings->common),
           {tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", settings->common.progress)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
