#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/shadow/occluder_heights.h"
#include "render/triangles/facets.h"

namespace rhoray::render::wide {

/// The target of rays to a light, in a volume's frame: a direction, or a position. Each ray ends no
/// farther from it than `reach`.
struct LightPlace {
  bool is_place = false;
  Vec3 at{0, 0, 0};
  double reach = 0;

  bool is_one_direction() const { return !is_place && reach == 0; }
  bool operator==(const LightPlace&) const = default;
};

/// Whether the parts of a surface that are certainly in shadow are computed, for a directional
/// light.
enum class Shadows { unknown, known };

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
  FacetOccluders(Machine machine, std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side);

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
  OccluderHeights heights(Machine machine, const LightPlace& light, Shadows shadows) const;

 private:
  std::shared_ptr<const Facets> facets_;
  StartSide side_;
  std::unique_ptr<FacetBlock[]> blocks_;
  std::vector<std::uint32_t> sources_;
  std::vector<std::uint16_t> sure_;
  BoxLevels levels_;
};

}  // namespace rhoray::render::wide
