#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/shadow/occluders.h"
#include "render/triangles/facets.h"

namespace rhoray::render::wide {

/// The facets of a mesh's isosurface that may occlude shadow rays with one start side. Sides
/// alternate along a ray: one that starts below the isovalue first crosses a facet through which
/// the field rises along the ray. Facets through which the field falls along every ray to the light
/// therefore occlude nothing. These are half of most surfaces, namely the half on which the rays
/// start.
///
/// The other facets are in blocks and in a tree of their own, in the order of Facets.
class FacetOccluders {
 public:
  /// @param facets  of an isosurface
  /// @param stop    ends it (ErrorCode::interrupted)
  FacetOccluders(Machine machine, std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side,
                 const std::stop_token& stop);

  const Facets& facets() const { return *facets_; }

  std::uint32_t count() const { return static_cast<std::uint32_t>(sources_.size()); }
  const FacetBlock* blocks() const { return blocks_.get(); }
  const std::uint32_t* sources() const { return sources_.data(); }  ///< the index of each in Facets
  /// Per block, one bit per facet: set when all rays to the light pass through the facet in the
  /// direction that ends their start side.
  const std::uint16_t* sure() const { return sure_.data(); }
  const BoxLevels& levels() const { return levels_; }

  /// Returns what they cover as seen from a directional light.
  /// @param shadows  known: the facets' neighbours are computed if they are missing
  /// @param stop     ends it (ErrorCode::interrupted)
  OccluderHeights heights(Machine machine, const LightPlace& light, Shadows shadows, const std::stop_token& stop) const;

 private:
  std::shared_ptr<const Facets> facets_;
  StartSide side_;
  std::unique_ptr<FacetBlock[]> blocks_;
  std::vector<std::uint32_t> sources_;
  std::vector<std::uint16_t> sure_;
  BoxLevels levels_;
};

/// Returns the parts of occluders that were found in facets.
inline const FacetOccluders& facets_of(const Occluders& occluders) {
  return *static_cast<const FacetOccluders*>(occluders.parts.get());
}

/// Returns those that may occlude rays to a light.
/// @param shadows  known: the facets' neighbours are computed, once for all lights
std::shared_ptr<const LightOccluders> facet_occluders_of(Machine machine, std::shared_ptr<const Facets> facets,
                                                         const LightPlace& light, Shadows shadows);

/// Returns the same with known shadows.
/// @param before  for a light without them
std::shared_ptr<const LightOccluders> with_shadows(Machine machine, std::shared_ptr<const LightOccluders> before,
                                                   const LightPlace& light);

/// The facets of an isosurface as OccluderSearch::surface returns them.
std::shared_ptr<const OccludingSurface> occluding_facets(const LoadedDataset& dataset, const RayQuery& query,
                                                         std::shared_ptr<const void> facets, unsigned threads,
                                                         const std::stop_token& stop);

}  // namespace rhoray::render::wide
