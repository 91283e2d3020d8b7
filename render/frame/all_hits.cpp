#include "render/frame/all_hits.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "render/frame/clear_light.h"
#include "render/frame/lighting.h"
#include "render/frame/peeling.h"
#include "render/query/compiled_for.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A walk may end when only this much light is left. It is below least_light by more than the
/// rounding of products, so that no visible crossing is missing.
constexpr float surely_dark = least_light * (1 - 0x1p-16F);

/// Returns null if a layer's rays are traced crossing by crossing.
AllHitsKernel kernel_of(const Frame& frame, const FrameLayer& layer) {
  const bool is_cut = layer.clipped && frame.clip->cuts_away();
  if (layer.slice || is_cut || layer.kernel != layer.continuation->first_hit) return nullptr;
  return layer.intersectors.all_hits;
}

/// True if a layer's crossings are shaded from their positions and gradients alone.
bool shows_only_places(const Frame& frame, const FrameLayer& layer) {
  const LayerShading& shading = layer.shading;
  return !frame.keeps_channels && !shading.lookup && !shading.texture && !shading.effects.smooth_normals &&
         !asks_for_light(layer);
}

bool go_together(const Frame& frame, const AllHitsGroup& group, const FrameLayer& layer) {
  const FrameLayer& first = frame.layers[group.layers.front()];
  return group.layers.size() < AllHitsQuery::most_surfaces && &first.dataset == &layer.dataset &&
         first.clipped == layer.clipped;
}

/// Shares out the light among the rays' crossings with all layers, in their order.
class LightShares {
 public:
  LightShares(const Frame& frame, Worker& worker) : frame_(frame), worker_(worker) {
    for (const AllHitsGroup& group : frame.all_hits_groups)
      of_.insert(of_.end(), group.layers.begin(), group.layers.end());
    // At equal t, the crossing of the first layer comes first.
    std::sort(of_.begin(), of_.end());
    for (const std::uint8_t l : of_) {
      AllHitsWork& work = *worker.all_hits.layers[l];
      SharedLayer& layer = layers_.emplace_back();
      layer.opacity = frame.layers[l].shading.layer.material.opacity;
      layer.count = work.crossings.count.data();
      for (std::size_t k = 0; k < CrossingList::most; ++k) {
        layer.t[k] = work.crossings.hits(k).t.data();
        layer.share[k] = work.share[k].data();
      }
    }
    met_.resize(layers_.size());
  }

  void share_light(std::size_t ray_count) {
    std::fill_n(worker_.all_hits.goes_on.data(), ray_count, std::uint8_t{0});
    std::fill_n(is_left_, ray_count, std::uint8_t{0});
    for (std::size_t g = 0; g < frame_.all_hits_groups.size(); ++g) {
      const std::uint8_t* complete = worker_.all_hits.complete[g].data();
      for (std::size_t r = 0; r < ray_count; ++r)
        is_left_[r] = static_cast<std::uint8_t>(is_left_[r] | (complete[r] ^ 1));
    }
    if (layers_.size() <= LightSharing::most_layers) {
      SharedLight light{.alpha = worker_.front.alpha};
      compiled_for<share_light_inline>(frame_.layers.front().shading.machine)(
          {layers_.data(), layers_.size(), is_left_, ray_count, least_light}, light);
      worker_.counts.clear_crossings += light.shown;
      worker_.counts.rays_through += light.through;
    } else {
      std::fill_n(worker_.front.alpha, ray_count, 1.0F);
      for (const SharedLayer& layer : layers_)
        for (std::size_t r = 0; r < ray_count; ++r)
          is_left_[r] = static_cast<std::uint8_t>(is_left_[r] | (layer.count[r] != 0));
    }
    for (std::size_t r = 0; r < ray_count; ++r)
      if (is_left_[r] != 0) share_light_of(r);
  }

  const std::vector<LastCrossing>& last() const { return last_; }

  /// Calls act(layer, the largest number of its crossings that a ray shows).
  template <class Act>
  void for_each_layer(const Act& act) const {
    for (std::size_t l = 0; l < layers_.size(); ++l) act(of_[l], layers_[l].deepest);
  }

 private:
  /// State of one ray with one layer.
  struct MetLayer {
    std::size_t taken = 0;
    double next = infinity;  ///< t of the first crossing not yet taken
  };

  void look_ahead(std::size_t l, std::size_t r, double limit) {
    const SharedLayer& layer = layers_[l];
    MetLayer& met = met_[l];
    met.next = met.taken < layer.count[r] && layer.t[met.taken][r] <= limit ? layer.t[met.taken][r] : infinity;
  }

  void share_light_of(std::size_t r) {
    const double limit = known_until(r);
    for (std::size_t l = 0; l < layers_.size(); ++l) met_[l].taken = 0, look_ahead(l, r, limit);
    double light = 1;
    std::size_t shown = 0;
    for (; !(light < least_light); ++shown) {
      std::size_t first = 0;
      for (std::size_t l = 1; l < layers_.size(); ++l)
        if (met_[l].next < met_[first].next) first = l;
      if (met_[first].next == infinity) break;
      SharedLayer& layer = layers_[first];
      const std::size_t k = met_[first].taken++;
      if (k == layer.deepest) std::fill_n(layer.share[layer.deepest++], tile_capacity, 0.0F);
      layer.share[k][r] = static_cast<float>(layer.opacity * light);
      light *= 1 - layer.opacity;
      look_ahead(first, r, limit);
    }
    worker_.counts.clear_crossings += shown;
    worker_.counts.rays_through += light < least_light ? shown - 1 : shown;
    worker_.front.alpha[r] = static_cast<float>(light);
    if (limit == infinity) return;
    worker_.all_hits.goes_on[r] = !(light < least_light);
    if (worker_.all_hits.goes_on[r] != 0) note_last(r);
  }

  /// Returns t up to which all crossings of a ray are known: the last one of a full list, or
  /// infinity. The result is below all t where another kernel must trace the ray.
  double known_until(std::size_t r) const {
    double limit = infinity;
    for (std::size_t g = 0; g < frame_.all_hits_groups.size(); ++g) {
      if (worker_.all_hits.complete[g][r] != 0) continue;
      double known = -infinity;
      for (const std::uint8_t layer : frame_.all_hits_groups[g].layers) {
        const CrossingList& list = worker_.all_hits.layers[layer]->crossings;
        if (list.count[r] != CrossingList::most) continue;
        const double last = list.hits(CrossingList::most - 1).t[r];
        known = known == -infinity ? last : std::min(known, last);
      }
      limit = std::min(limit, known);
    }
    return limit;
  }

  void note_last(std::size_t r) {
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      if (met_[l].taken == 0) continue;
      Ray ray = worker_.layers[of_[l]].rays[r];
      ray.start_side = StartSide::unknown;
      const bool is_field = frame_.layers[of_[l]].shading.layer.mode != Mode::triangles;
      const Hit hit = worker_.all_hits.layers[of_[l]]->crossings.hits(met_[l].taken - 1)[r];
      last_.push_back({.layer = of_[l], .ray = static_cast<std::uint32_t>(r), .behind = behind(ray, hit, is_field)});
    }
  }

  const Frame& frame_;
  Worker& worker_;
  std::vector<std::uint8_t> of_;  ///< indices into Frame::layers
  std::vector<SharedLayer> layers_;
  std::vector<MetLayer> met_;
  alignas(64) std::uint8_t is_left_[tile_capacity];
  std::vector<LastCrossing> last_;
};

/// Adds the light of the k-th crossings of a layer.
void show(const Frame& frame, std::uint8_t layer, std::size_t k, Worker& worker) {
  LayerWork& work = worker.layers[layer];
  AllHitsWork& all = *worker.all_hits.layers[layer];
  if (k > 0) std::swap(work.hits, all.crossings.hits(k));
  const float* share = all.share[k].data();
  if (asks_for_light(frame.layers[layer])) {
    LayerOfRays shown;
    for (std::size_t r = 0; r < work.rays.count; ++r) shown.of[r] = share[r] > 0 ? layer : LayerOfRays::none;
    receive_light(frame, layer, &shown, worker);
  }
  add_clear(frame.layers[layer].shading, work, share, worker.received, worker.counts, worker.all_hits.light);
  if (k > 0) std::swap(work.hits, all.crossings.hits(k));
}

}  // namespace

void choose_all_hits(const FrameOptions& options, Frame& frame) {
  if (!options.one_pass) return;
  std::vector<AllHitsGroup> groups;
  for (std::size_t l = 0; l < frame.layers.size(); ++l) {
    const FrameLayer& layer = frame.layers[l];
    if (layer.blend != Blend::transparent) continue;
    const AllHitsKernel kernel = kernel_of(frame, layer);
    if (kernel == nullptr) return;
    const auto fit = std::find_if(groups.begin(), groups.end(),
                                  [&](const AllHitsGroup& group) { return go_together(frame, group, layer); });
    AllHitsGroup& group =
        fit != groups.end() ? *fit : groups.emplace_back(AllHitsGroup{.kernel = kernel, .layers = {}, .surfaces = {}});
    group.only_places = group.only_places && shows_only_places(frame, layer);
    group.layers.push_back(static_cast<std::uint8_t>(l));
    group.surfaces.push_back(
        {.isovalue = layer.query.isovalue, .passing = static_cast<float>(1 - layer.shading.layer.material.opacity)});
    frame.needs.transparent_layers.push_back(static_cast<std::uint8_t>(l));
  }
  frame.needs.all_hits_groups = groups.size();
  frame.all_hits_groups = std::move(groups);
}

void find_all_hits(const Frame& frame, Worker& worker) {
  for (std::size_t g = 0; g < frame.all_hits_groups.size(); ++g) {
    const AllHitsGroup& group = frame.all_hits_groups[g];
    CrossingList* lists[AllHitsQuery::most_surfaces];
    for (std::size_t i = 0; i < group.layers.size(); ++i)
      lists[i] = &worker.all_hits.layers[group.layers[i]]->crossings;
    const FrameLayer& layer = frame.layers[group.layers.front()];
    LayerWork& work = worker.layers[group.layers.front()];
    group.kernel(layer.dataset,
                 {.surfaces = group.surfaces,
                  .least_light = surely_dark,
                  .time_phases = layer.query.time_phases,
                  .only_places = group.only_places},
                 work.rays, std::span<CrossingList* const>(lists, group.layers.size()),
                 worker.all_hits.complete[g].data(), worker.all_hits.scratch[g], work.scratch.counters);
  }
}

void composite_all_hits(const Frame& frame, Worker& worker) {
  const std::size_t ray_count = worker.layers[0].rays.count;
  LightShares shares(frame, worker);
  shares.share_light(ray_count);
  for (const auto* sums : {&worker.all_hits.light.red, &worker.all_hits.light.green, &worker.all_hits.light.blue})
    std::fill_n(sums->data(), (ray_count + RayBatch::group_size - 1) / RayBatch::group_size * RayBatch::group_size,
                0.0);
  shares.for_each_layer([&](std::uint8_t layer, std::size_t deepest) {
    for (std::size_t k = 0; k < deepest; ++k) show(frame, layer, k, worker);
  });
  put_into_front(worker.all_hits.light, ray_count, worker.front);
  const std::uint8_t* goes_on = worker.all_hits.goes_on.data();
  if (std::any_of(goes_on, goes_on + ray_count, [](std::uint8_t goes) { return goes != 0; }))
    peel_further(frame, goes_on, shares.last(), worker);
}

}  // namespace rhoray::render
