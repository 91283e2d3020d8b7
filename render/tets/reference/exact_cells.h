#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/exact/exact_tets.h"
#include "render/tets/reference/walk.h"

/// The cells of a mesh as the input of exact arithmetic. It gets the tetrahedra that the leaf cells
/// along the ray list, or every tetrahedron of the clusters whose boxes the ray hits. Lists extend
/// a millionth of a leaf cell beyond it, and the lattice a little beyond the mesh
/// (preprocess/leaf_lists). Therefore the rounding of the traversal misses none, for rays that
/// start less than 2^28 leaf cells away. Boxes contain their tetrahedra, and none that the ray
/// touches is missed (cluster_walk.h).
///
/// It considers the tetrahedra whose values reach the isovalue, and joins their parts of the ray.
/// This is correct where the cells are a partition with shared faces. Where cells overlap, or
/// points hang in faces, there is no single field. Exact arithmetic may then find a change from one
/// cell to the next that the direct method does not find, because that takes the first change
/// inside any one cell (tests/hard_cases/defective_meshes_test.cpp). `info --stats` reports such
/// meshes.
namespace rhoray::render {

namespace {

template <class View, class MayMatter, class Take>
void take_from_lists(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                     MayMatter&& may_matter, Take&& take) {
  walk_leaves(view, query, ray, counters, may_matter, [&](const CellVisit& visit) {
    ++counters.cells_visited;
    for (const std::uint32_t tet : view.tetrahedra_at(visit.cell)) take(tet);
    return true;
  });
}

template <class View, class MayMatter, class Take>
void take_from_clusters(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                        MayMatter&& may_matter, Take&& take) {
  const formats::CellClustersView& clusters = view.clusters();
  walk_clusters(
      view, BoxRay(ray, clusters.box_unit), query.use_hierarchy, counters, may_matter, [](double) { return true; },
      [&](const ClusterVisit& visit) {
        for (std::uint64_t tet = clusters.first_cell(visit.entry); tet < clusters.end_cell(visit.entry); ++tet)
          take(static_cast<std::uint32_t>(tet));
        return true;
      });
}

/// Returns the tetrahedra of leaf cells or clusters along the ray, each once, in increasing order.
/// @param may_matter  (range of values in a region or tetrahedron): false to skip it
template <class View, class MayMatter>
std::vector<std::uint32_t> tets_along(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters,
                                      MayMatter&& may_matter) {
  std::vector<std::uint32_t> tets;
  const auto take = [&](std::uint32_t tet) {
    const TetValues values = view.values_at(view.sorted_vertices(tet));
    const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
    if (has_data(values) && may_matter(Interval<double>{lo, hi})) tets.push_back(tet);
  };
  if (view.has_clusters())
    take_from_clusters(view, query, ray, counters, may_matter, take);
  else
    take_from_lists(view, query, ray, counters, may_matter, take);
  std::sort(tets.begin(), tets.end());
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  counters.cells_solved += tets.size();
  return tets;
}

template <class View>
std::vector<ExactTet> shown(const View& view, const std::vector<std::uint32_t>& tets) {
  std::vector<ExactTet> out(tets.size());
  for (std::size_t n = 0; n < tets.size(); ++n) {
    const auto vertices = view.sorted_vertices(tets[n]);
    const TetPoints points = view.points_at(vertices);
    for (std::size_t i = 0; i < 4; ++i) out[n].point[i] = Vec3(points[i][0], points[i][1], points[i][2]);
    out[n].value = view.values_at(vertices);
    out[n].id = view.cell_id(tets[n]) << 32 | tets[n];  // in the order of is_preferred
  }
  return out;
}

/// Returns the tetrahedron of a verdict.
template <class Verdict>
std::uint32_t tet_of(const Verdict& verdict) {
  return static_cast<std::uint32_t>(verdict.cell);
}

/// Returns the tetrahedra along the ray whose values reach the isovalue.
template <class View>
std::vector<ExactTet> crossed_cells(const View& view, const RayQuery& query, const Ray& ray, KernelCounters& counters) {
  return shown(view, tets_along(view, query, ray, counters, [&](const Interval<double>& range) {
                 return range.lo <= query.isovalue && query.isovalue <= range.hi;
               }));
}

/// The width of the enclosures of t.
template <class View>
double exact_mesh_width(const View& view, const Ray& ray) {
  return exact_width_cells / view.on_lattice(ray).direction.length();
}

}  // namespace

}  // namespace rhoray::render
