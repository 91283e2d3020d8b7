#include "tools/analysis/variant_names.h"

#include <algorithm>

#include "tools/analysis/variant.h"

namespace rhoray::tools {

namespace {

enum Applies : unsigned { grid_surfaces = 1, mesh_surfaces = 2, projections = 4, surfaces = 3, all = 7 };

struct Words {
  unsigned applies;
  const char *group, *name, *meaning;
};

constexpr Words words[] = {
    {grid_surfaces, group_levels, "`preview`",
     "Rhoray's fast level: a cell is hit if the field's side differs between the ray's entry and exit; one secant step "
     "in single precision gives the position."},
    {grid_surfaces, group_levels, "`float`, `double`",
     "Rhoray's standard levels: the trilinear field along the ray in a cell is a cubic, whose roots are bracketed, in "
     "single and in double precision."},
    {mesh_surfaces, group_levels, "`float`, `double`",
     "Rhoray's standard levels: rays cross tetrahedra through edges shared by neighbours, so no ray slips between "
     "them; in single and in double precision."},
    {projections, group_levels, "`double`",
     "Rhoray's standard level: the largest value along the ray in a cell, from the critical points of its polynomial."},
    {all, group_levels, "`certified`",
     "Every answer has a proven error bound. What single precision cannot prove is computed in double precision, and "
     "what that cannot prove in exact arithmetic."},
    {all, group_levels, "`exact`", "Every decision in exact arithmetic. By definition it has no error."},
    {grid_surfaces, group_published, "`paper`",
     "The cubic solved in closed form: Parker et al., Interactive Ray Tracing for Volume Visualization, 1999, "
     "appendix A."},
    {mesh_surfaces, group_published, "`paper`, `slack`",
     "Each tetrahedron alone, by barycentric coordinates that must not be negative: Parker et al. 1999, appendix B; "
     "`slack` allows them to be negative by this much, as is often done against gaps."},
    {projections, group_published, "`face`",
     "The largest value on a cell's faces is used for the inside: Parker et al. 1999, section 4.3."},
    {surfaces, group_linear, "`sampled:S+linear`",
     "The field every S cells along the ray; where its side changes, one linear step gives the position. Most volume "
     "renderers do this."},
    {surfaces, group_bisect, "`sampled:S+bisect`", "The same, with bisection for the position."},
    {projections, group_samples, "`sampled:S+linear`",
     "The largest of the field's values every S cells along the ray."},
    {grid_surfaces | projections, group_bits, "8 bits, 16 bits",
     "A copy of the data whose values are rounded to 2^8 or 2^16 steps, evenly over the field's range."},
    {mesh_surfaces, group_bits, "8 bits, 16 bits",
     "A copy of the mesh whose values are rounded to 2^8 or 2^16 steps, evenly over the field's range. They are stored "
     "as floating-point numbers, so this copy saves no memory."},
    {all, group_grids, "grid N",
     "The mesh resampled on a grid with N samples on its longest axis, trilinear between them."},
    {all, group_vdb, "OpenVDB N", "The same grid as OpenVDB."},
    {mesh_surfaces, group_normals, "smooth, flat normals",
     "Normals of the surface: the gradient of each cell (flat), or a gradient that is linear in the cell between "
     "averages at its points (smooth). Neither moves the surface."},
    {grid_surfaces, group_normals, "smooth, exact normals",
     "Normals of the surface: the gradient of the trilinear field (exact), or one interpolated between central "
     "differences at the samples (smooth). Neither moves the surface."},
    {surfaces, group_occlusion, "N rays a hit",
     "Ambient occlusion with this many rays, compared with a picture with 1024 rays per hit."},
    {surfaces, group_shadows, "N rays to a light",
     "Soft shadows with this many rays, compared with a picture with 1024 rays to each light."},
    {all, group_edges, "N samples a pixel",
     "Antialiasing with at most this many rays per edge pixel, compared with a picture with 64."},
    {all, group_size, "1/2, 1/4 of the size",
     "A smaller picture enlarged, linear between pixels: how coarse steps of a progressive picture look."}};

}  // namespace

std::vector<std::pair<std::string, std::string>> variant_words(const std::vector<std::string>& groups, bool is_mesh,
                                                               bool is_projection) {
  const unsigned kind = is_projection ? projections : is_mesh ? mesh_surfaces : grid_surfaces;
  std::vector<std::pair<std::string, std::string>> rows;
  for (const Words& row : words)
    if ((row.applies & kind) != 0 && std::find(groups.begin(), groups.end(), row.group) != groups.end())
      rows.emplace_back(row.name, row.meaning);
  return rows;
}

}  // namespace rhoray::tools
