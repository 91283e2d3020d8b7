#include "render/frame/shells.h"

#include <algorithm>
#include <array>
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

/// The rays' crossings with all layers as they are met, one after another: gives them their shares of the light.
class LightShares {
 public:
  LightShares(const Frame& frame, Worker& worker) : frame_(frame), worker_(worker) {
    for (const ShellGroup& group : frame.shells)
      for (const std::uint8_t layer : group.layers) {
        ShellWork& work = *worker.shells.layers[layer];
        OfLayer& of = layers_.emplace_back();
        of.layer = layer;
        of.opacity = static_cast<float>(frame.layers[layer].look.layer.surface.opacity);
        of.count = work.crossings.count.data();
        for (std::size_t k = 0; k < CrossingList::most; ++k) {
          of.t[k] = work.crossings.hits(k).t.data();
          of.share[k] = work.share[k].data();
        }
      }
    // Of crossings at one t the first layer's comes first.
    std::sort(layers_.begin(), layers_.end(), [](const OfLayer& a, const OfLayer& b) { return a.layer < b.layer; });
  }

  void share_light(std::size_t ray_count) {
    std::fill_n(worker_.front.alpha, ray_count, 1.0F);
    std::fill_n(worker_.shells.goes_on.data(), ray_count, std::uint8_t{0});
    std::fill_n(is_left_, ray_count, std::uint8_t{0});
    is_complete_ = true;
    for (std::size_t g = 0; g < frame_.shells.size(); ++g) {
      const std::uint8_t* complete = worker_.shells.complete[g].data();
      is_complete_ &= std::find(complete, complete + ray_count, 0) == complete + ray_count;
      for (std::size_t r = 0; r < ray_count; ++r)
        is_left_[r] = static_cast<std::uint8_t>(is_left_[r] | (complete[r] ^ 1));
    }
    if (layers_.size() == 2 && is_complete_)
      share_between_two(ray_count);
    else
      for (const OfLayer& of : layers_)
        for (std::size_t r = 0; r < ray_count; ++r) is_left_[r] = static_cast<std::uint8_t>(is_left_[r] | of.count[r]);
    for (std::size_t r = 0; r < ray_count; ++r)
      if (is_left_[r] != 0) share_light_of(r);
  }

  const std::vector<LastCrossing>& last() const { return last_; }

  /// Calls act(layer, the most crossings of it that a ray shows).
  template <class Act>
  void for_each_layer(const Act& act) const {
    for (const OfLayer& of : layers_) act(of.layer, of.deepest);
  }

 private:
  struct OfLayer {
    std::uint8_t layer = 0;
    float opacity = 0;
    const std::uint8_t* count = nullptr;
    std::array<const double*, CrossingList::most> t{};
    std::array<float*, CrossingList::most> share{};
    std::size_t deepest = 0;  ///< so many of the shares have been asked for
    // Of one ray:
    std::size_t taken = 0;
    double next = infinity;  ///< t of the first that is not taken

    void look_ahead(std::size_t r, double limit) {
      next = taken < count[r] && t[taken][r] <= limit ? t[taken][r] : infinity;
    }
  };

  /// Shares the light of all rays that cross either layer once at most, without a branch; the others are left.
  void share_between_two(std::size_t ray_count) {
    OfLayer &a = layers_[0], &b = layers_[1];
    const std::uint8_t *count_a = a.count, *count_b = b.count;
    const double *t_a = a.t[0], *t_b = b.t[0];
    float *share_a = a.share[0], *share_b = b.share[0], *alpha = worker_.front.alpha;
    std::uint64_t shown = 0, through = 0;
    unsigned any_a = 0, any_b = 0;
    for (std::size_t r = 0; r < ray_count; ++r) {
      const unsigned has_a = count_a[r], has_b = count_b[r];
      const bool is_left = (has_a | has_b) > 1;
      any_a |= has_a, any_b |= has_b;
      const bool a_first = has_a != 0 && (has_b == 0 || t_a[r] <= t_b[r]);
      const bool has_first = !is_left && (has_a | has_b) != 0;
      const float of_first = has_first ? a_first ? a.opacity : b.opacity : 0;
      const float behind_first = 1 - of_first;
      const bool has_second = !is_left && (has_a & has_b) != 0 && !(behind_first < least_light);
      const float of_second = has_second ? (a_first ? b.opacity : a.opacity) * behind_first : 0;
      const float light = behind_first - of_second;
      share_a[r] = a_first ? of_first : of_second;
      share_b[r] = a_first ? of_second : of_first;
      alpha[r] = light;
      is_left_[r] = is_left;
      shown += static_cast<unsigned>(has_first) + static_cast<unsigned>(has_second);
      through += static_cast<unsigned>(has_first && !(behind_first < least_light)) +
                 static_cast<unsigned>(has_second && !(light < least_light));
    }
    for (OfLayer* of : {&a, &b}) std::fill(of->share[0] + ray_count, of->share[0] + tile_capacity, 0.0F);
    a.deepest = any_a != 0, b.deepest = any_b != 0;
    worker_.counts.clear_crossings += shown;
    worker_.counts.rays_through += through;
  }

  void share_light_of(std::size_t r) {
    const double limit = is_complete_ ? infinity : known_until(r);
    for (OfLayer& of : layers_) of.taken = 0, of.look_ahead(r, limit);
    float light = 1;
    std::size_t shown = 0;
    for (; !(light < least_light); ++shown) {
      OfLayer* first = &layers_[0];
      for (std::size_t l = 1; l < layers_.size(); ++l)
        if (layers_[l].next < first->next) first = &layers_[l];
      if (first->next == infinity) break;
      const float share = first->opacity * light;
      light -= share;
      if (first->taken == first->deepest) std::fill_n(first->share[first->deepest++], tile_capacity, 0.0F);
      first->share[first->taken++][r] = share;
      first->look_ahead(r, limit);
    }
    worker_.counts.clear_crossings += shown;
    worker_.counts.rays_through += light < least_light ? shown - 1 : shown;
    worker_.front.alpha[r] = light;
    if (limit == infinity) return;
    worker_.shells.goes_on[r] = !(light < least_light);
    if (worker_.shells.goes_on[r] != 0) note_last(r);
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
    for (const OfLayer& of : layers_) {
      if (of.taken == 0) continue;
      Ray ray = worker_.layers[of.layer].rays[r];
      ray.start_side = StartSide::unknown;
      const bool is_field = frame_.layers[of.layer].look.layer.mode != Mode::triangles;
      const Hit hit = worker_.shells.layers[of.layer]->crossings.hits(of.taken - 1)[r];
      last_.push_back({.layer = of.layer, .ray = static_cast<std::uint32_t>(r), .behind = behind(ray, hit, is_field)});
    }
  }

  const Frame& frame_;
  Worker& worker_;
  std::vector<OfLayer> layers_;
  bool is_complete_ = true;  ///< of all rays all crossings are noted
  alignas(64) std::uint8_t is_left_[tile_capacity];
  std::vector<LastCrossing> last_;
};

/// Adds the light of the k-th crossings of a layer.
void show(const Frame& frame, std::uint8_t layer, std::size_t k, Worker& worker) {
  LayerWork& work = worker.layers[layer];
  ShellWork& shells = *worker.shells.layers[layer];
  if (k > 0) std::swap(work.hits, shells.crossings.hits(k));
  const float* share = shells.share[k].data();
  if (asks_for_light(frame.layers[layer])) {
    LayerOfRays shown;
    for (std::size_t r = 0; r < work.rays.count; ++r) shown.of[r] = share[r] > 0 ? layer : LayerOfRays::none;
    receive_light(frame, layer, &shown, worker);
  }
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
  LightShares shares(frame, worker);
  shares.share_light(ray_count);
  for (const auto* sums : {&worker.shells.light.red, &worker.shells.light.green, &worker.shells.light.blue})
    std::fill_n(sums->data(), (ray_count + RayBatch::group_size - 1) / RayBatch::group_size * RayBatch::group_size,
                0.0);
  shares.for_each_layer([&](std::uint8_t layer, std::size_t deepest) {
    for (std::size_t k = 0; k < deepest; ++k) show(frame, layer, k, worker);
  });
  put_into_front(worker.shells.light, ray_count, worker.front);
  const std::uint8_t* goes_on = worker.shells.goes_on.data();
  if (std::any_of(goes_on, goes_on + ray_count, [](std::uint8_t goes) { return goes != 0; }))
    peel_further(frame, goes_on, shares.last(), worker);
}

}  // namespace rhoray::render
