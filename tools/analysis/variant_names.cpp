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
     "Rhoray's level for a first look: a cell is crossed where the field's side differs at the ray's entry and exit, "
     "and "
     "the place is found by one secant step, in single precision."},
    {grid_surfaces, group_levels, "`float`, `double`",
     "Rhoray's levels for work: the cubic that the trilinear field is along the ray inside a cell, its roots "
     "bracketed, "
     "in single and in double precision."},
    {mesh_surfaces, group_levels, "`float`, `double`",
     "Rhoray's levels for work: tetrahedra are met through edges that neighbours share, so that no ray slips between "
     "them, in single and in double precision."},
    {projections, group_levels, "`double`",
     "Rhoray's level for work: in a cell the largest value along the ray by the critical points of its polynomial."},
    {all, group_levels, "`certified`",
     "Every answer comes with a proven bound of its error; what single precision cannot prove is done in double, what "
     "that cannot prove by exact arithmetic."},
    {all, group_levels, "`exact`", "Every decision by exact arithmetic. By definition it has no error."},
    {grid_surfaces, group_published, "`paper`",
     "The cubic solved in closed form: Parker et al., Interactive Ray Tracing for Volume Visualization, 1999, "
     "appendix A."},
    {mesh_surfaces, group_published, "`paper`, `slack`",
     "Each tetrahedron alone, by barycentric coordinates that may not be negative: Parker et al. 1999, appendix B; "
     "`slack` lets them be so by that much, as is often done against gaps."},
    {projections, group_published, "`face`",
     "The largest value on a cell's faces stands for that inside: Parker et al. 1999, section 4.3."},
    {surfaces, group_linear, "`sampled:S+linear`",
     "The field every S cells along the ray; where its side changes the place is found by one linear step. So do most "
     "renderers of volumes."},
    {surfaces, group_bisect, "`sampled:S+bisect`", "The same, the place found by bisection."},
    {projections, group_samples, "`sampled:S+linear`",
     "The largest of the field's values every S cells along the ray."},
    {grid_surfaces | projections, group_bits, "8 bits, 16 bits",
     "A copy of the data whose values are rounded to 2^8 or 2^16 steps, evenly over the field's range."},
    {mesh_surfaces, group_bits, "8 bits, 16 bits",
     "A copy of the mesh whose values are rounded to 2^8 or 2^16 steps, evenly over the field's range. They are kept "
     "as "
     "floating-point numbers: what would be saved is not."},
    {all, group_grids, "grid N", "The mesh sampled on a grid, N samples on its longest axis, trilinear between them."},
    {all, group_vdb, "OpenVDB N", "The same grid as OpenVDB."},
    {surfaces, group_normals, "smooth, flat normals",
     "What lights the surface: the gradient of each cell (flat), or a gradient that is linear in the cell between "
     "means "
     "at its points (smooth). Neither moves the surface."},
    {surfaces, group_occlusion, "N rays a hit",
     "Ambient occlusion by that many rays, against a picture with 1024 rays a hit."},
    {surfaces, group_shadows, "N rays to a light",
     "Shadows of lights that have a size by that many rays, against a picture with 1024 rays to each light."},
    {all, group_edges, "N samples a pixel",
     "Antialiasing by at most that many rays through a pixel at an edge, against a picture with 64."},
    {all, group_size, "1/2, 1/4 of the size",
     "A smaller picture drawn large, linear between pixels: how coarse steps of a progressive picture look."}};

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
