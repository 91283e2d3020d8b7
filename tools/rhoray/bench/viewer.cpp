#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>

#include "formats/base/text.h"
#include "render/document.h"
#include "tools/rhoray/bench/tables.h"
#include "tools/rhoray/data_choice.h"
#include "tools/view/drag_client.h"
#include "tools/view/server.h"
#include "tools/view/simulated_line.h"

namespace rhoray::tools {

namespace {

constexpr Line slow_line{.round_trip_ms = 30, .megabits_per_s = 20};
constexpr double stall_s = 6;

ViewedScene opened(const BenchOptions& options) {
  render::SceneSpec scene_spec{.data = {{.name = "data", .file = options.packed, .field = options.field}},
                               .layers = {{.isovalues = {options.isovalues.front()}}},
                               .accuracy = options.accuracy};
  scene_spec.layers[0].normals = options.normals, scene_spec.layers[0].color_by = options.color_by;
  scene_spec.camera.view = options.view;
  scene_spec.image.size = options.size;
  DataAccess access;
  access.opened = std::make_shared<DataAccess::Opened>();
  access.loaded = std::make_shared<DataAccess::Loaded>();
  ViewedScene viewed{.title = options.input.filename().string(), .program = "rhoray", .scene_spec = scene_spec};
  viewed.resolve = [access](const render::SceneSpec& changed) { return resolve_layers(changed, access); };
  viewed.plan = viewed.resolve(scene_spec);
  aim_camera(viewed.scene_spec, viewed.plan);
  viewed.command_of = [](const render::ResolvedScene&) { return std::string(); };
  viewed.texts_of = [](const render::ResolvedScene&, std::string_view) { return std::vector<PictureText>{}; };
  return viewed;
}

/// The motions of a drag, as parts of requests.
class Motions {
 public:
  Motions(const ViewedScene& viewed, const render::PictureSize& size)
      : size_(concat(R"("size": [)", size.width, ", ", size.height, "]")),
        camera_(viewed.plan.scene.camera),
        isovalue_(viewed.plan.scene.layers[0].isovalue),
        range_(viewed.plan.datasets[0].field().range) {}

  /// Half a turn in 3 s around the camera's target.
  std::string turn(double second) const {
    const double angle = second * std::numbers::pi / 3;
    const Vec3 axis = camera_.up.normalized(), from = camera_.position - camera_.target;
    const Vec3 turned =
        std::cos(angle) * from + std::sin(angle) * axis.cross(from) + (1 - std::cos(angle)) * axis.dot(from) * axis;
    render::Camera camera = camera_;
    camera.position = camera_.target + turned;
    return concat(size_, R"(, "camera": )", dump(json_of_camera(camera)));
  }

  /// A sine wave of the isovalue: 5 % of the field's range in each direction, 2 s long.
  std::string change_isovalue(double second) const {
    const double share = 0.05 * std::sin(second * std::numbers::pi);
    const double isovalue = std::clamp(isovalue_ + share * (range_.hi - range_.lo), range_.lo, range_.hi);
    return concat(size_, R"(, "scene": {"layers": {"0": {"isovalue": )", isovalue, "}}}");
  }

  std::string none() const { return size_; }

 private:
  std::string size_;
  render::Camera camera_;
  double isovalue_;
  Interval<double> range_;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

Json row_of(const std::string& what, const DragFigures& figures, double cpu_s) {
  return {{"what", what},
          {"p50_ms", quantile(figures.latencies_ms, 0.5)},
          {"p95_ms", quantile(figures.latencies_ms, 0.95)},
          {"largest_ms", quantile(figures.latencies_ms, 1)},
          {"pictures_per_s", static_cast<double>(figures.spacings.size()) / figures.seconds},
          {"spacing", quantile(figures.spacings, 0.5)},
          {"kilobytes", 1e-3 * quantile(figures.picture_bytes, 0.5)},
          {"cores", cpu_s / figures.seconds},
          {"late_pictures", figures.late_pictures}};
}

}  // namespace

Table viewer_table(const BenchOptions& options, const Step& step) {
  const ViewedScene viewed = opened(options);
  const Motions motions(viewed, options.size);
  Server server(viewed, {.threads = options.threads});
  const std::jthread serving([&](const std::stop_token& stop) { server.run(stop); });
  Table table{
      "view", "The viewer: from a request to its picture, without the browser's decoding", bench_context(options), {}};
  table.context["size"] = {options.size.width, options.size.height};
  const double seconds = options.repeat;
  const auto measure = [&](const std::string& what, DragClient& client, const auto& motion, double stall) {
    step(what);
    client.drag(0.5, motion);  // warms the caches
    const double cpu_begin = usage_so_far().cpu_s;
    const DragFigures figures = client.drag(seconds, motion, stall);
    table.rows.push_back(row_of(what, figures, usage_so_far().cpu_s - cpu_begin));
  };
  const auto turn = [&](double second) { return motions.turn(second); };
  const auto change_isovalue = [&](double second) { return motions.change_isovalue(second); };
  {
    DragClient client(server.url(), server.port());
    measure("camera", client, turn, 0);
    measure("isovalue", client, change_isovalue, 0);
    step("at rest");
    const DragClient::Settled settled = client.settle(motions.none());
    table.context["whole_picture_ms"] = settled.whole_ms;
    table.context["lossless_picture_ms"] = settled.lossless_ms;
  }
  const std::string over = concat(", over ", slow_line.round_trip_ms, " ms and ", slow_line.megabits_per_s, " Mbit/s");
  SimulatedLine line(server.port(), slow_line);
  DragClient client(server.url(), line.port());
  measure("camera" + over, client, turn, 0);
  measure("isovalue" + over, client, change_isovalue, 0);
  measure(concat("camera", over, ", then a stall of ", stall_s, " s"), client, turn, stall_s);
  return table;
}

}  // namespace rhoray::tools
