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

std::shared_ptr<const LightOccluders> OccluderCache::of(const OccluderSearch& search, const LoadedDataset& dataset,
                                                        const RayQuery& query, const LightPlace& light, Machine machine,
                                                        unsigned threads, const std::stop_token& stop) {
  const std::shared_ptr<const void> source = search.source(dataset, query, light, threads, stop);
  if (!source) return nullptr;
  OfSurface* kept = bring_to_front(kept_, [&](const OfSurface& of) { return of.source == source; });
  const Shadows shadows = kept != nullptr ? Shadows::known : Shadows::unknown;
  if (kept == nullptr)
    kept = &put_in_front(kept_, {source, search.surface(dataset, query, source, threads, stop), {}}, most_kept);
  const OccludingSurface& surface = *kept->surface;
  if (OfLight* of = bring_to_front(kept->lights, [&](const OfLight& one) { return one.light == light; })) {
    if (of->shadows != shadows)
      of->occluders = surface.with_shadows(machine, of->occluders, light), of->shadows = shadows;
    return of->occluders;
  }
  auto occluders = surface.of_light(machine, light, shadows);
  return put_in_front(kept->lights, {light, std::move(occluders), shadows}, most_kept).occluders;
}

}  // namespace rhoray::render::wide
