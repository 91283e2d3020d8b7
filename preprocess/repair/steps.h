#pragma once

#include <cstdint>
#include <vector>

#include "preprocess/repair/mesh.h"
#include "preprocess/repair_surface.h"

namespace rhoray::preprocess::repair {

/// One CGAL algorithm stands behind each of these, in a file of its own.

/// Facets with finite corners; those with more than three are cut into triangles.
Soup soup_of(const NeutralSurface& surface, RepairReport& report);

/// Merges points and drops facets that are there twice or have no area.
void clean_soup(Soup& soup, RepairReport& report);

/// Orients and connects the facets; where more than two meet in an edge or sheets meet in a point, points are doubled.
TriangleMesh mesh_of(Soup soup, RepairReport& report);

/// Joins open edges that lie on each other, pairwise.
void stitch(TriangleMesh& mesh, RepairReport& report);

/// Removes facets without area. False when some could not be removed.
bool remove_flat_facets(TriangleMesh& mesh);

/// Closes every ring of open edges by triangles about as large as those around it.
void fill_holes(TriangleMesh& mesh, RepairReport& report);

/// Pairs of facets of one mesh that cross.
std::uint64_t count_crossings(const TriangleMesh& mesh);

/// Replaces facets around crossings until there are none. False when some are left; the mesh is then as it came.
bool replace_crossing_facets(TriangleMesh& mesh);

/// Cuts facets along their crossings and drops what comes to lie inside. False when it could not; the mesh is then as
/// it came.
bool cut_at_crossings(TriangleMesh& mesh);

/// The connected parts.
std::vector<TriangleMesh> parts_of(const TriangleMesh& mesh);
double area_of(const TriangleMesh& mesh);

/// Makes one solid of every group of closed parts that cross each other. Parts that lie inside others stay.
void unite_crossing_parts(std::vector<TriangleMesh>& parts, RepairReport& report);

/// A closed surface around everything.
TriangleMesh wrap(const Soup& soup, double gap, double offset);

/// Fills in the distances between two surfaces.
void measure(const TriangleMesh& old_mesh, const TriangleMesh& new_mesh, RepairReport& report);

}  // namespace rhoray::preprocess::repair
