#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/shadow/occluder_heights.h"
#include "render/triangles/facets.h"

namespace rhoray::render::wide {

/// Where rays to a light go, in a volume's frame: towards a direction, or to a place; each of them no farther from it
/// than `reach`.
struct LightPlace {
  bool is_place = false;
  Vec3 at{0, 0, 0};
  double reach = 0;

  bool is_one_direction() const { return !is_place && reach == 0; }
  bool operator==(const LightPlace&) const = default;
};

/// Whether it is found out what of a surface lies in shadow for certain, where the light stands in one direction.
enum class Shadows { unknown, known };

/// The facets of a mesh's isosurface that may hold back light which rays of one start side ask about. Sides take turns
/// along a ray: one that starts below the isovalue first meets a facet through which the field rises along it, so of
/// all facets those through which it falls on every way to the light hold nothing back. These are half of most
/// surfaces, and the half on which the rays start.
///
/// Those that are left stand in blocks and in a tree of their own, in the order of Facets.
class FacetOccluders {
 public:
  /// @param facets  of an isosurface
  FacetOccluders(Machine machine, std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side);

  const Facets& facets() const { return *facets_; }

  std::uint32_t count() const { return static_cast<std::uint32_t>(sources_.size()); }
  const FacetBlock* blocks() const { return blocks_.get(); }
  const std::uint32_t* sources() const { return sources_.data(); }  ///< the place of each among Facets
  /// Of each block a bit for each facet through which all rays to the light go in the way that ends the side.
  const std::uint16_t* sure() const { return sure_.data(); }
  const BoxLevels& levels() const { return levels_; }

  /// What they cover as seen from the light, which stands in one direction.
  /// @param shadows  known: the facets' neighbours are found, if they are not yet
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
