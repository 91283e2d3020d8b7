#include "render/probe.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "formats/intact.h"
#include "render/all_crossings.h"
#include "render/dataset/loaded_dataset.h"
#include "render/frame/camera_rays.h"
#include "render/frame/check_request.h"
#include "render/frame/clip_region.h"
#include "render/frame/peeling.h"
#include "render/frame/slices.h"
#include "render/ray_caster.h"
#include "render/shade/hit_lookup.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t group_size = RayBatch::group_size;

/// A group whose rays are all the same: loops read whole groups.
RayBatch group_of(const Ray& ray) {
  RayBatch rays(group_size);
  rays.count = 1;
  for (std::size_t i = 0; i < group_size; ++i) rays.set(i, ray);
  return rays;
}

/// The ray through a point of a picture, traced through one layer after another.
class Probe {
 public:
  Probe(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options, const PicturePoint& point,
        std::size_t most, const Watch& watch)
      : datasets_(datasets), scene_(scene), options_(options), most_(most), watch_(watch), in_world_(world_ray(point)) {
    if (scene.clip) {
      kept_ = KeptParts(group_size);
      ClipRegion(*scene.clip, machine()).find_kept(group_of(in_world_), kept_);
    }
  }

  std::vector<ProbeHit> hits() {
    for (std::size_t l = 0; l < scene_.layers.size(); ++l) {
      const Layer& layer = scene_.layers[l];
      if (layer.mode == Mode::mip || layer.material.opacity == 0) continue;
      const std::size_t before = hits_.size();
      if (layer.mode == Mode::isosurface) add_crossings(l);
      if (layer.mode == Mode::triangles) add_triangles(l);
      if (layer.mode == Mode::slice) add_slice(l);
      if (hits_.size() == before || layer.material.opacity < 1) continue;
      const double depth = hits_[before].depth;
      end_ = std::min(end_, layer.mode == Mode::slice ? std::nextafter(depth, -infinity) : depth);
    }
    for (std::size_t l = 0; l < scene_.layers.size(); ++l)
      if (scene_.layers[l].mode == Mode::mip) add_largest(l);
    const auto order_of = [&](const ProbeHit& hit) {
      const Mode mode = scene_.layers[hit.layer].mode;
      return std::tuple(hit.depth, mode == Mode::slice ? 0 : mode == Mode::mip ? 2 : 1);
    };
    std::stable_sort(hits_.begin(), hits_.end(),
                     [&](const ProbeHit& a, const ProbeHit& b) { return order_of(a) < order_of(b); });
    if (hits_.size() > most_) hits_.resize(most_);
    for (const Dataset& dataset : datasets_) formats::require_intact(dataset.file());
    return std::move(hits_);
  }

 private:
  Machine machine() const { return options_.machine.value_or(chosen_machine()); }

  Ray world_ray(const PicturePoint& point) const {
    const CameraRays rays(scene_.camera, options_.width, options_.height);
    const double across = rays.across_at(point.x + 0.5), down = rays.down_at(point.y + 0.5);
    return {.origin = rays.origin(across, down), .direction = rays.direction(across, down)};
  }

  const Dataset& dataset_of(std::size_t layer) const { return datasets_[scene_.layers[layer].dataset]; }

  bool is_clipped(std::size_t layer) const { return scene_.clip && scene_.layers[layer].clipped; }

  /// The first part that the clip region keeps, in the frame of a layer's data; its t_max is below
  /// its t_min where nothing is kept.
  Ray first_part(std::size_t layer) const {
    const Affine data_from_world = world_from_ray_frame(dataset_of(layer)).inverse();
    Ray ray{.origin = data_from_world.point(in_world_.origin),
            .direction = data_from_world.vector(in_world_.direction)};
    if (is_clipped(layer)) ray.t_min = kept_.t_min[0], ray.t_max = kept_.t_max[0];
    return ray;
  }

  /// All parts that are not empty.
  std::vector<Ray> parts(std::size_t layer) const {
    std::vector<Ray> rays;
    Ray ray = first_part(layer);
    if (ray.t_min <= ray.t_max) rays.push_back(ray);
    if (!is_clipped(layer) || !(kept_.again[0] < infinity)) return rays;
    ray.t_min = kept_.again[0], ray.t_max = infinity;
    rays.push_back(ray);
    return rays;
  }

  ProbeHit& add(std::size_t layer, double t, std::uint64_t cell) {
    const Ray ray = first_part(layer);
    return hits_.emplace_back(
        ProbeHit{.layer = layer,
                 .depth = t,
                 .position = world_from_ray_frame(dataset_of(layer)).point(ray.origin + t * ray.direction),
                 .cell = cell});
  }

  void add_crossings(std::size_t layer) {
    const Dataset& dataset = dataset_of(layer);
    dataset.prove_ranges(options_.threads, watch_);
    std::size_t left = most_;
    for (const Ray& part : parts(layer)) {
      if (left == 0) return;
      for (const Crossing& crossing : all_crossings(dataset, scene_.layers[layer].isovalue, part, left).crossings) {
        ProbeHit& hit = add(layer, crossing.t, crossing.cell);
        hit.error = position_error(crossing.error, hit.depth, in_world_.origin, hit.position);
        hit.value = scene_.layers[layer].isovalue, hit.unit = dataset.field().unit;
        --left;
      }
    }
  }

  void add_triangles(std::size_t layer) {
    const Dataset& dataset = dataset_of(layer);
    const auto& colors = scene_.layers[layer].material.color_by;
    std::optional<HitLookup> lookup;
    if (colors) lookup.emplace(dataset.implementation(), HitAttributes{.field = colors->field}, 1, machine());
    RayCaster caster(dataset, 0, method_of(Accuracy::float64), 1, machine());
    std::size_t left = most_;
    for (const Ray& part : parts(layer))
      for (Ray ray = part; left > 0; --left) {
        const Hit found = caster.first_crossing(ray);
        if (found.is_miss()) break;
        ProbeHit& hit = add(layer, found.t, found.cell);
        if (lookup) {
          hit.value = value_at(*lookup, ray, found);
          hit.unit = dataset.field(colors->field).value().unit;
        }
        ray = behind(ray, found, false);
      }
  }

  static double value_at(const HitLookup& lookup, const Ray& ray, const Hit& found) {
    HitBatch hits(group_size);
    double values[group_size];
    for (std::size_t i = 0; i < group_size; ++i) hits.set(i, found);
    lookup(group_of(ray), hits, 0, values);
    return values[0];
  }

  void add_slice(std::size_t layer) {
    const Dataset& dataset = dataset_of(layer);
    const SlicePlane plane(dataset.implementation(), scene_.layers[layer], scene_.clip, machine());
    HitBatch hits(group_size);
    const bool has_second = is_clipped(layer) && scene_.clip->cuts_away;
    plane.ask(group_of(first_part(layer)), group_of(in_world_), {.begin = has_second ? kept_.again.data() : nullptr},
              hits);
    const Hit found = hits[0];
    if (found.is_miss()) return;
    ProbeHit& hit = add(layer, found.t, found.cell);
    hit.value = found.value, hit.unit = dataset.field().unit;
  }

  void add_largest(std::size_t layer) {
    const Dataset& dataset = dataset_of(layer);
    dataset.prove_ranges(options_.threads, watch_);
    RayCaster caster(dataset, dataset.field().range.lo, method_of(Accuracy::exact), 1, machine());
    Hit largest;
    double error = 0;  // the exact largest value may be in either part
    for (Ray part : parts(layer)) {
      part.t_max = std::min(part.t_max, end_);
      if (!(part.t_min <= part.t_max)) continue;
      Hit found;
      caster.largest_values(std::span(&part, 1), std::span(&found, 1));
      if (found.is_miss()) continue;
      error = std::max(error, found.error);
      if (largest.is_miss() || found.value > largest.value) largest = found;
    }
    if (largest.is_miss()) return;
    ProbeHit& hit = add(layer, largest.t, largest.cell);
    hit.value = largest.value, hit.value_error = error, hit.unit = dataset.field().unit;
  }

  std::span<const Dataset> datasets_;
  const Scene& scene_;
  const FrameOptions& options_;
  std::size_t most_;
  const Watch& watch_;
  Ray in_world_;
  KeptParts kept_;         ///< of the first ray of a group; only with a clip region
  double end_ = infinity;  ///< depth of the nearest opaque surface
  std::vector<ProbeHit> hits_;
};

/// Refuses a point outside the picture, and NaN.
void check(const PicturePoint& point, const FrameOptions& options) {
  if (point.x >= -0.5 && point.x <= options.width - 0.5 && point.y >= -0.5 && point.y <= options.height - 0.5) return;
  throw Error(ErrorCode::usage,
              concat("probe: found (", point.x, ", ", point.y, "); expected a point of the picture, (", -0.5, ", ",
                     -0.5, ") to (", options.width - 0.5, ", ", options.height - 0.5, ")"));
}

}  // namespace

std::vector<ProbeHit> probe(std::span<const Dataset> datasets, const Scene& scene, const FrameOptions& options,
                            const PicturePoint& point, std::size_t most, const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  check_request(datasets, scene, {.width = options.width, .height = options.height});
  check(point, options);
  return Probe(datasets, scene, options, point, most, watch).hits();
}

double position_error(double bound, double depth, const Vec3& eye, const Vec3& position) {
  return 0x1.01p0 * bound + 0x1p-46 * (eye.length() + depth + position.length());
}

}  // namespace rhoray::render
