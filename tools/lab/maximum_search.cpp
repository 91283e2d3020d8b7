// The search order for the largest values along the rays of a picture. Counts the regions, cells
// and cubics that each order examines, for single rays and for groups of 8 x 8 pixels.

#include "tools/lab/maximum_search.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "tools/lab/search_orders.h"
#include "tools/lab/study_run.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::study {
namespace {

struct Settings {
  tools::CommonOptions common;
  std::filesystem::path file;
  std::uint64_t groups = 400;  ///< per view
};

struct View {
  const char* name;
  Vec3 towards;
  /// Side of the picture as a fraction of the volume's diagonal.
  double zoom;
  /// Distance of the eye from the centre, in diagonals.
  double eye_at;
};
constexpr View views[] = {{"front", {0.02, 1, 0.03}, 0.9, 2},
                          {"oblique", {0.5, 0.7, -0.4}, 0.9, 2},
                          {"close", {0.4, 0.8, 0.3}, 0.25, 2},
                          {"inside", {0.3, 0.9, -0.2}, 0.9, 0}};

/// 8 x 8 pixels of a picture of 1024 x 1024.
Group group_at(const Field& field, const View& view, int column, int row) {
  const Vec3 size = Vec3(field.samples - Index3(1)), middle = 0.5 * size;
  const double diagonal = size.length();
  const Vec3 forward = view.towards.normalized(), right = forward.cross(Vec3(0, 0, 1)).normalized(),
             up = right.cross(forward);
  const Vec3 eye = middle - view.eye_at * diagonal * forward;
  const double depth = std::max(view.eye_at, 0.5) * diagonal, side = view.zoom * diagonal;
  Group group;
  for (int p = 0; p < 64; ++p) {
    const double x = (column * 8 + p % 8 + 0.5) / 1024 - 0.5, y = (row * 8 + p / 8 + 0.5) / 1024 - 0.5;
    const Line ray{eye, (depth * forward + side * (x * right + y * up)).normalized()};
    if (const auto inside = clip(field, ray)) group.rays.push_back(ray), group.inside.push_back(*inside);
  }
  return group;
}

struct Row {
  const char* name;
  Work work;
};

class Study {
 public:
  explicit Study(const Field& field) : field_(field) {}

  /// Adds one group, after its left neighbour.
  void add(const View& view, int column, int row) {
    const Group before = group_at(field_, view, column - 1, row), group = group_at(field_, view, column, row);
    if (group.rays.size() < 64 || before.rays.size() < 64) return;
    rays_ += 64;
    Work none;
    std::vector<Best> known_before(64), truth(64);
    for (std::size_t r = 0; r < 64; ++r)
      queue(field_, before.rays[r], before.inside[r].first, before.inside[r].second, known_before[r], none);
    for (std::size_t r = 0; r < 64; ++r)
      queue(field_, group.rays[r], group.inside[r].first, group.inside[r].second, truth[r], none);

    row_ = 0;
    const auto alone = [&](const char* name, auto search, auto first) {
      std::vector<Best> best(64);
      Work work;
      for (std::size_t r = 0; r < 64; ++r) {
        first(best, r);
        search(field_, group.rays[r], group.inside[r].first, group.inside[r].second, best[r], work);
      }
      finish(name, best, truth, work);
    };
    const auto none_first = [](std::vector<Best>&, std::size_t) {};
    const auto last_t = [&](std::vector<Best>& best, std::size_t r) {
      if (r > 0) guess(field_, group.rays[r], best[r - 1].t, best[r]);
    };
    const auto answer = [&](std::vector<Best>& best, std::size_t r) { best[r] = truth[r]; };
    alone("ray, queue", queue, none_first);
    alone("ray, queue, last t", queue, last_t);
    alone("ray, front to back", front_to_back, none_first);
    alone("ray, front to back, last t", front_to_back, last_t);
    alone("ray, front to back, the answer known", front_to_back, answer);

    const std::vector<Shared> nodes = shared_regions(field_, group, 2), blocks = shared_regions(field_, group, 1);
    const auto together = [&](const char* name, Order order, auto first, bool dives = false) {
      std::vector<Best> best(64);
      Work work;
      for (std::size_t r = 0; r < 64; ++r) first(best, r);
      if (dives) dive(field_, group, blocks, best, work);
      in_group(field_, group, nodes, blocks, order, best, work);
      finish(name, best, truth, work);
    };
    const auto neighbour_t = [&](std::vector<Best>& best, std::size_t r) {
      guess(field_, group.rays[r], known_before[r].t, best[r]);
      // Also try the nearest column of the group before.
      guess(field_, group.rays[r], known_before[r / 8 * 8 + 7].t, best[r]);
    };
    together("group, largest bound first", Order::bound, none_first);
    together("group, largest bound first, neighbours' t", Order::bound, neighbour_t);
    together("group, nodes by bound", Order::bound_of_node, none_first);
    together("group, nodes by bound, neighbours' t", Order::bound_of_node, neighbour_t);
    together("group, front to back", Order::front_to_back, none_first);
    together("group, front to back, neighbours' t", Order::front_to_back, neighbour_t);
    together("group, front to back, each ray's highest block first", Order::front_to_back, none_first, true);
    together("group, front to back, both", Order::front_to_back, neighbour_t, true);
    together("group, front to back, the answer known", Order::front_to_back, answer);
  }

  std::vector<Json> rows(const char* view) const {
    std::vector<Json> result;
    for (const Row& row : rows_) {
      const auto per_ray = [&](double count) { return count / rays_; };
      result.push_back({{"view", view},
                        {"order", row.name},
                        {"regions", per_ray(row.work.regions)},
                        {"blocks_of_group", 64 * per_ray(row.work.blocks)},
                        {"in_blocks", per_ray(row.work.in_blocks)},
                        {"cells", per_ray(row.work.cells)},
                        {"cubics", per_ray(row.work.cubics)},
                        {"solved", per_ray(row.work.solved)}});
    }
    return result;
  }
  double rays() const { return rays_; }
  std::uint64_t wrong() const { return wrong_; }

 private:
  void finish(const char* name, const std::vector<Best>& best, const std::vector<Best>& truth, const Work& work) {
    for (std::size_t r = 0; r < 64; ++r)
      wrong_ += !(std::abs(best[r].value - truth[r].value) <= 1e-6 * std::max(1.0, std::abs(truth[r].value)));
    if (rows_.size() <= row_) rows_.push_back({name, {}});
    rows_[row_++].work.add(work);
  }

  const Field& field_;
  double rays_ = 0;
  std::uint64_t wrong_ = 0;
  std::size_t row_ = 0;
  std::vector<Row> rows_;
};

int run(const Settings& settings) {
  require_publishable(settings.common, {"maximum_search"});
  const Field field = load_field(settings.file);
  tools::Table table{"maximum_search", "What the search for the largest value looks at, per ray", {}, {}};
  std::uint64_t wrong = 0;
  for (const View& view : views) {
    Study study(field);
    // Spread the groups evenly over the picture.
    const int stride = std::max(1, static_cast<int>(std::sqrt(128.0 * 128.0 / static_cast<double>(settings.groups))));
    for (int row = stride / 2; row < 128; row += stride)
      for (int column = 1 + stride / 2; column < 128; column += stride) study.add(view, column, row);
    for (const Json& row : study.rows(view.name)) table.rows.push_back(row);
    wrong += study.wrong();
  }
  table.context =
      context_with({{"file", settings.file.filename().string()}, {"groups", settings.groups}, {"wrong", wrong}});
  publish(table, settings.common);
  return wrong == 0 ? 0 : static_cast<int>(ErrorCode::outside_limit);
}

}  // namespace

tools::Subcommand maximum_search() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "maximum-search",
      .summary = "In which order to look for the largest value along rays: what each order looks at",
      .examples = {"rhoray-study maximum-search head.rho -o results"},
      .options = tools::all_options(
          {{tools::file_option("FILE", "Packed grid (.rho)", settings->file)},
           tools::output_options(settings->common, "FOLDER for maximum_search.csv and .json"),
           {tools::value_option("--groups", "N", "Groups of 8 x 8 rays of each view; default 400", settings->groups)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
