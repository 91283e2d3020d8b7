#include "render/shadow/occluder_cache.h"

#include <algorithm>
#include <utility>

namespace rhoray::render::wide {

namespace {

/// Moves an element of a list to its front.
/// @return  null when it is not in the list
template <class Kept, class Is>
Kept* bring_to_front(std::vector<Kept>& list, const Is& is) {
  const auto found = std::find_if(list.begin(), list.end(), is);
  if (found == list.end()) return nullptr;
  std::rotate(list.begin(), found, found + 1);
  return &list.front();
}

/// Inserts an element at the front; drops the last one if there are too many.
template <class Kept>
Kept& put_in_front(std::vector<Kept>& list, Kept added, std::size_t most) {
  if (list.size() == most) list.pop_back();
  return *list.insert(list.begin(), std::move(added));
}

}  // namespace

std::shared_ptr<const LightOccluders> OccluderCache::of(const VolumeImplementation& volume, const RayQuery& query,
                                                        const LightPlace& light, unsigned threads) {
  const std::shared_ptr<const Facets> facets = facets_with_occluders(volume, query, threads);
  if (!facets && !light.is_one_direction()) return nullptr;
  const std::shared_ptr<const void> surface =
      facets ? std::shared_ptr<const void>(facets) : occupancy_of_grid(volume, query);
  if (!surface) return nullptr;
  OfSurface* kept = bring_to_front(kept_, [&](const OfSurface& of) { return of.surface == surface; });
  const Shadows shadows = facets && kept != nullptr ? Shadows::known : Shadows::unknown;
  if (kept == nullptr) {
    auto cells = facets ? nullptr : SurfaceCells::of(volume, query, threads);
    if (!facets && !cells) return nullptr;
    kept = &put_in_front(kept_, {surface, std::move(cells), {}}, most_kept);
  }
  if (OfLight* of = bring_to_front(kept->lights, [&](const OfLight& one) { return one.light == light; })) {
    if (of->shadows != shadows)
      of->occluders = with_shadows(chosen_machine(), of->occluders, light), of->shadows = shadows;
    return of->occluders;
  }
  auto occluders = facets ? facet_occluders_of(chosen_machine(), facets, light, shadows)
                          : grid_occluders_of(chosen_machine(), kept->cells, light);
  return put_in_front(kept->lights, {light, std::move(occluders), shadows}, most_kept).occluders;
}

}  // namespace rhoray::render::wide
