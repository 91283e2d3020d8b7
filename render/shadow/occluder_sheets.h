#pragma once

#include <cstdint>
#include <vector>

#include "render/query/machine.h"
#include "render/shadow/front_facing.h"
#include "render/shadow/occluder_heights.h"
#include "render/triangles/facet_neighbours.h"

namespace rhoray::render::wide {

/// Of each square, and of what is beyond them.
struct FacetHeights {
  std::vector<float> above;  ///< the height above which no facet stands; -infinity: there is none
  std::vector<float> below;  ///< below which all light is held back; -infinity: not known
};

/// What facets may hold light back, and what they make of sheets.
struct SheetFacets {
  const FrontFacing& seen;
  const std::uint32_t* sources;  ///< the place of each among the surface's
  const std::uint16_t* sure;     ///< of each block a bit for each that has one side turned to the light for certain
  bool rises;                    ///< the field, on the way to the light through these
};

/// The height above which nothing stands.
/// @param margin  in the facets' frame: squares are taken to be larger by that much on all sides
std::vector<float> heights_of_facets(Machine machine, const Squares& squares, double margin, const FrontFacing& facets);

/// The same, and the height below which facets hold back every ray to the light. Facets that have one side turned to it
/// make sheets: where two of them, and no third one, share an edge, and are turned alike (FacetNeighbours), the sheet
/// goes on; every other edge is a rim. How many times a sheet lies over a place, facets that are seen from the other
/// side taken off, changes at rims only, however thin a facet is and wherever rounding moves its corners. So in squares
/// that share sides and have no rims a sheet lies over all places or over none; over all where one of them holds the
/// middle of a facet, and touches only facets that are seen the right way for certain; and what lies below all facets
/// that touch a square lies in shadow there. (Sheet by sheet more would be known where several lie over each other, but
/// finding out which facets make one takes longer than that saves.)
///
/// @param neighbours  of the facets of the surface
FacetHeights heights_of_sheets(Machine machine, const Squares& squares, double margin, const SheetFacets& facets,
                               const FacetNeighbours& neighbours);

}  // namespace rhoray::render::wide
