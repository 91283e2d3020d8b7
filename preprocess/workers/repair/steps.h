#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "preprocess/repair_surface.h"
#include "preprocess/workers/repair/mesh.h"

namespace rhoray::preprocess::repair {

/// One CGAL algorithm stands behind each of these, in a file of its own.

/// Facets with finite corners, cut into triangles (faces/cut_faces.h).
Soup soup_of(const NeutralSurface& surface, RepairReport& report);

/// Merges points and drops facets that are there twice or have no area.
void clean_soup(Soup& soup, RepairReport& report);

/// Orients and connects the facets; where more than two meet in an edge or sheets meet in a point,
/// points are doubled.
TriangleMesh mesh_of(Soup soup, RepairReport& report);

/// Joins open edges that lie on each other, pairwise.
void stitch(TriangleMesh& mesh, RepairReport& report);

/// Removes facets without area. False when some could not be removed.
bool remove_flat_facets(TriangleMesh& mesh);

/// Closes every ring of open edges by triangles about as large as those around it.
void fill_holes(TriangleMesh& mesh, RepairReport& report);

/// Collapses edges up to a length and flips others to be rid of needles and caps, unless that makes
/// facets cross; the mesh is then as it came.
void remove_needles(TriangleMesh& mesh, double longest_collapsed);

/// Pairs of facets of one mesh that cross.
std::uint64_t count_crossings(const TriangleMesh& mesh);

/// Replaces facets around crossings until there are none, or gives up: nothing.
std::optional<TriangleMesh> with_facets_replaced(TriangleMesh mesh);

/// Cuts facets along their crossings and drops what comes to lie inside, or gives up: nothing.
std::optional<TriangleMesh> with_facets_cut(TriangleMesh mesh);

/// The connected parts.
std::vector<TriangleMesh> parts_of(const TriangleMesh& mesh);
double area_of(const TriangleMesh& mesh);

/// Makes one solid of every group of closed parts that cross each other. Parts that lie inside
/// others stay.
void unite_crossing_parts(std::vector<TriangleMesh>& parts, RepairReport& report);

/// A closed surface around everything.
TriangleMesh wrap(const Soup& soup, double gap, double offset);

/// The one-sided Hausdorff distance, to within `error` (not 0).
double farthest(const TriangleMesh& from, const TriangleMesh& to, double error);

}  // namespace rhoray::preprocess::repair
