#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/query/machine.h"
#include "render/shadow/occluder_heights.h"
#include "render/triangles/facet_neighbours.h"
#include "render/triangles/shadow/front_facing.h"

namespace rhoray::render::wide {

/// Heights of each square, and of what is outside them.
struct FacetHeights {
  /// The height above which there is no facet; -infinity: there is none at all.
  std::vector<float> above;
  std::vector<float> below;  ///< the height below which all light is occluded; -infinity: not known
};

/// Possible occluders, as parts of sheets.
struct SheetFacets {
  const FrontFacing& seen;
  const std::uint32_t* sources;  ///< the index of each in the surface
  /// Per block, one bit per facet: set when the facet certainly faces the light with the given side
  /// (see `rises`).
  const std::uint16_t* sure;
  bool rises;  ///< whether the field rises through these on the way to the light
};

/// Returns the height above which there is nothing.
/// @param margin  in the facets' frame: squares are enlarged by it on all sides
std::vector<float> heights_of_facets(Machine machine, const Squares& squares, double margin, const FrontFacing& facets);

/// Returns the same, and the height below which facets occlude every ray to the light.
///
/// Facets that face the light with the same side form sheets. Where exactly two of them share an
/// edge and have the same orientation (FacetNeighbours), the sheet continues; every other edge is a
/// rim. Count how many times a sheet covers a place, minus the facets seen from the other side.
/// This number changes at rims only, however thin a facet is and wherever rounding moves its
/// corners. In squares that are connected through their sides and have no rims, a sheet therefore
/// covers all places or none. It covers all if one of the squares contains the middle of a facet
/// and touches only facets that are certainly seen from the right side. What is below all facets
/// that touch a square is then in shadow there.
///
/// Treating sheets separately would find more shadow where several overlap, but separating them
/// takes longer than it saves.
///
/// @param neighbours  of the facets of the surface
/// @param stop        ends it between its steps (ErrorCode::interrupted)
FacetHeights heights_of_sheets(Machine machine, const Squares& squares, double margin, const SheetFacets& facets,
                               const FacetNeighbours& neighbours, const std::stop_token& stop = {});

}  // namespace rhoray::render::wide
