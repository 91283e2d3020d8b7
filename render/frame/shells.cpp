#include "render/frame/shells.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "render/frame/lighting.h"
#include "render/frame/peeling.h"
#include "render/march/ticks.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A walk may end where this is left: lower than least_light by more than the rounding of products, so that no crossing
/// is missing that is shown.
constexpr float surely_dark = least_light * (1 - 0x1p-16F);

/// Null where a layer's rays are asked about crossing by crossing.
CrossingsKernel kernel_of(const Frame& frame, const FrameLayer& layer) {
  const bool is_cut = layer.clipped && frame.clip->cuts_away();
  if (layer.slice || is_cut || layer.kernel != layer.kernel_through) return nullptr;
  return crossings_kernel(layer.volume, layer.question);
}

bool go_together(const Frame& frame, const ShellGroup& group, const FrameLayer& layer) {
  const FrameLayer& first = frame.layers[group.layers.front()];
  return group.layers.size() < CrossingsQuestion::most_surfaces && &first.volume == &layer.volume &&
         first.clipped == layer.clipped;
}

/// A ray's crossings with all layers as they are met, one after another.
class NextCrossings {
 public:
  NextCrossings(const Frame& frame, Worker& worker) : frame_(frame), worker_(worker), deepest_(frame.layers.size()) {
    for (const ShellGroup& group : frame.shells)
      layers_.insert(layers_.end(), group.layers.begin(), group.layers.end());
    std::sort(layers_.begin(), layers_.end());  // of crossings at one t the first layer's comes first
    taken_.resize(layers_.size());
  }

  /// Gives the crossings of a ray their shares of its light.
  void share_light(std::size_t r) {
    std::fill(taken_.begin(), taken_.end(), std::uint8_t{0});
    const double limit = known_until(r);
    float light = 1;
    while (!(light < least_light)) {
      std::size_t next = layers_.size();
      double t = infinity;
      for (std::size_t i = 0; i < layers_.size(); ++i) {
        const CrossingList& list = crossings(i);
        if (taken_[i] == list.count[r]) continue;
        const double here = list.hits(taken_[i]).t[r];
        if (here < t && here <= limit) t = here, next = i;
      }
      if (next == layers_.size()) break;
      const std::uint8_t layer = layers_[next];
      const float share = static_cast<float>(frame_.layers[layer].look.layer.surface.opacity) * light;
      light -= share;
      share_of(layer, taken_[next]++)[r] = share;
      ++worker_.counts.clear_crossings;
      worker_.counts.rays_through += !(light < least_light);
    }
    worker_.front.alpha[r] = light;
    worker_.shells.goes_on[r] = limit < infinity && !(light < least_light);
    if (worker_.shells.goes_on[r] != 0) note_last(r);
  }

  const std::vector<LastCrossing>& last() const { return last_; }

  /// The most crossings of a layer that a ray shows.
  std::size_t deepest(std::uint8_t layer) const { return deepest_[layer]; }

 private:
  const CrossingList& crossings(std::size_t i) const { return worker_.shells.layers[layers_[i]]->crossings; }

  /// The k-th shares of a layer's crossings; of those asked for the first time, all are nothing.
  float* share_of(std::uint8_t layer, std::size_t k) {
    float* shares = worker_.shells.layers[layer]->share[k].data();
    if (k == deepest_[layer]) {
      std::fill_n(shares, tile_capacity, 0.0F);
      ++deepest_[layer];
    }
    return shares;
  }

  /// Until which t all crossings of a ray are noted: the last of a list that is full, or infinity. Below all t where
  /// another kernel is to answer.
  double known_until(std::size_t r) const {
    double limit = infinity;
    for (std::size_t g = 0; g < frame_.shells.size(); ++g) {
      if (worker_.shells.complete[g][r] != 0) continue;
      double known = -infinity;
      for (const std::uint8_t layer : frame_.shells[g].layers) {
        const CrossingList& list = worker_.shells.layers[layer]->crossings;
        if (list.count[r] != CrossingList::most) continue;
        const double last = list.hits(CrossingList::most - 1).t[r];
        known = known == -infinity ? last : std::min(known, last);
      }
      limit = std::min(limit, known);
    }
    return limit;
  }

  void note_last(std::size_t r) {
    for (std::size_t i = 0; i < layers_.size(); ++i) {
      if (taken_[i] == 0) continue;
      Ray ray = worker_.layers[layers_[i]].rays[r];
      ray.start_side = StartSide::unknown;
      const bool is_field = frame_.layers[layers_[i]].look.layer.mode != Mode::triangles;
      last_.push_back({.layer = layers_[i],
                       .ray = static_cast<std::uint32_t>(r),
                       .behind = behind(ray, crossings(i).hits(taken_[i] - 1U)[r], is_field)});
    }
  }

  const Frame& frame_;
  Worker& worker_;
  std::vector<std::uint8_t> layers_, taken_;
  std::vector<std::size_t> deepest_;
  std::vector<LastCrossing> last_;
};

/// Adds the light of the k-th crossings of a layer.
void show(const Frame& frame, std::uint8_t layer, std::size_t k, Worker& worker) {
  LayerWork& work = worker.layers[layer];
  ShellWork& shells = *worker.shells.layers[layer];
  if (k > 0) std::swap(work.hits, shells.crossings.hits(k));
  const float* share = shells.share[k].data();
  LayerOfRays shown;
  for (std::size_t r = 0; r < work.rays.count; ++r) shown.of[r] = share[r] > 0 ? layer : LayerOfRays::none;
  receive_light(frame, layer, &shown, worker);
  add_clear(frame.layers[layer].look, work, share, worker.received, worker.counts, worker.shells.light);
  if (k > 0) std::swap(work.hits, shells.crossings.hits(k));
}

}  // namespace

void choose_shells(const FrameOptions& options, Frame& frame) {
  if (!options.one_pass) return;
  std::vector<ShellGroup> groups;
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    const FrameLayer& layer = frame.layers[l];
    if (layer.part != Part::clear) continue;
    const CrossingsKernel kernel = kernel_of(frame, layer);
    if (kernel == nullptr) return;
    const auto fit = std::find_if(groups.begin(), groups.end(),
                                  [&](const ShellGroup& group) { return go_together(frame, group, layer); });
    ShellGroup& group = fit != groups.end() ? *fit : groups.emplace_back(ShellGroup{kernel, {}, {}});
    group.layers.push_back(static_cast<std::uint8_t>(l));
    group.surfaces.push_back(
        {.isovalue = layer.question.isovalue, .passing = static_cast<float>(1 - layer.look.layer.surface.opacity)});
    frame.needs.shell_layers.push_back(static_cast<std::uint8_t>(l));
  }
  frame.needs.shell_groups = groups.size();
  frame.shells = std::move(groups);
}

void cross_shells(const Frame& frame, Worker& worker) {
  for (std::size_t g = 0; g < frame.shells.size(); ++g) {
    const ShellGroup& group = frame.shells[g];
    CrossingList* lists[CrossingsQuestion::most_surfaces];
    for (std::size_t i = 0; i < group.layers.size(); ++i) lists[i] = &worker.shells.layers[group.layers[i]]->crossings;
    const FrameLayer& layer = frame.layers[group.layers.front()];
    LayerWork& work = worker.layers[group.layers.front()];
    group.kernel(layer.volume,
                 {.surfaces = group.surfaces, .least_light = surely_dark, .time_phases = layer.question.time_phases},
                 work.rays, std::span<CrossingList* const>(lists, group.layers.size()),
                 worker.shells.complete[g].data(), worker.shells.memory[g], work.scratch.counters);
  }
}

void show_shells(const Frame& frame, Worker& worker) {
  const std::size_t ray_count = worker.layers[0].rays.count;
  NextCrossings crossings(frame, worker);
  for (std::size_t r = 0; r < ray_count; ++r) crossings.share_light(r);
  for (const auto* sums : {&worker.shells.light.red, &worker.shells.light.green, &worker.shells.light.blue})
    std::fill_n(sums->data(), (ray_count + RayBatch::group_size - 1) / RayBatch::group_size * RayBatch::group_size,
                0.0);
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    const auto layer = static_cast<std::uint8_t>(l);
    for (std::size_t k = 0; k < crossings.deepest(layer); ++k) show(frame, layer, k, worker);
  }
  put_into_front(worker.shells.light, ray_count, worker.front);
  const std::uint8_t* goes_on = worker.shells.goes_on.data();
  if (std::any_of(goes_on, goes_on + ray_count, [](std::uint8_t goes) { return goes != 0; }))
    peel_further(frame, goes_on, crossings.last(), worker);
}

}  // namespace rhoray::render
