#include "preprocess/mesh/subdivide/cell_kinds.h"

#include <algorithm>

#include "formats/base/checks.h"
#include "formats/base/text.h"

namespace rhoray::preprocess {
namespace {

using enum CellKind;

constexpr CellFace tetrahedron_faces[] = {{3, {0, 2, 1}}, {3, {0, 1, 3}}, {3, {1, 2, 3}}, {3, {0, 3, 2}}};

// A voxel's corners are ordered along x, then y, then z; a hexahedron's run around.
constexpr CellFace voxel_faces[] = {{4, {0, 4, 6, 2}}, {4, {1, 3, 7, 5}}, {4, {0, 1, 5, 4}},
                                    {4, {2, 6, 7, 3}}, {4, {0, 2, 3, 1}}, {4, {4, 5, 7, 6}}};
constexpr CellFace hexahedron_faces[] = {{4, {0, 4, 7, 3}}, {4, {1, 2, 6, 5}}, {4, {0, 1, 5, 4}},
                                         {4, {3, 7, 6, 2}}, {4, {0, 3, 2, 1}}, {4, {4, 5, 6, 7}}};
constexpr CellFace wedge_faces[] = {
    {3, {0, 2, 1}}, {3, {3, 4, 5}}, {4, {0, 1, 4, 3}}, {4, {1, 2, 5, 4}}, {4, {2, 0, 3, 5}}};
constexpr CellFace pyramid_faces[] = {
    {4, {0, 3, 2, 1}}, {3, {0, 1, 4}}, {3, {1, 2, 4}}, {3, {2, 3, 4}}, {3, {3, 0, 4}}};
constexpr CellFace pentagonal_prism_faces[] = {{5, {0, 4, 3, 2, 1}}, {5, {5, 6, 7, 8, 9}}, {4, {0, 1, 6, 5}},
                                               {4, {1, 2, 7, 6}},    {4, {2, 3, 8, 7}},    {4, {3, 4, 9, 8}},
                                               {4, {4, 0, 5, 9}}};
constexpr CellFace hexagonal_prism_faces[] = {{6, {0, 5, 4, 3, 2, 1}}, {6, {6, 7, 8, 9, 10, 11}}, {4, {0, 1, 7, 6}},
                                              {4, {1, 2, 8, 7}},       {4, {2, 3, 9, 8}},         {4, {3, 4, 10, 9}},
                                              {4, {4, 5, 11, 10}},     {4, {5, 0, 6, 11}}};

constexpr CellFrame tetrahedron_frame{4, tetrahedron_faces, false};
constexpr CellFrame voxel_frame{8, voxel_faces, false};
constexpr CellFrame hexahedron_frame{8, hexahedron_faces, false};
constexpr CellFrame wedge_frame{6, wedge_faces, true};
constexpr CellFrame pyramid_frame{5, pyramid_faces, false};
constexpr CellFrame pentagonal_prism_frame{10, pentagonal_prism_faces, true};
constexpr CellFrame hexagonal_prism_frame{12, hexagonal_prism_faces, true};

constexpr KindOfCell kinds[] = {
    {tetrahedron, "tetrahedron", "tetrahedra", tetrahedron, 4},
    {voxel, "voxel", "voxels", voxel, 8},
    {hexahedron, "hexahedron", "hexahedra", hexahedron, 8},
    {wedge, "wedge", "wedges", wedge, 6},
    {pyramid, "pyramid", "pyramids", pyramid, 5},
    {pentagonal_prism, "pentagonal prism", "pentagonal prisms", pentagonal_prism, 10},
    {hexagonal_prism, "hexagonal prism", "hexagonal prisms", hexagonal_prism, 12},
    {quadratic_tetrahedron, "quadratic tetrahedron", "quadratic tetrahedra", tetrahedron, 10},
    {quadratic_hexahedron, "quadratic hexahedron", "quadratic hexahedra", hexahedron, 20},
    {quadratic_wedge, "quadratic wedge", "quadratic wedges", wedge, 15},
    {quadratic_pyramid, "quadratic pyramid", "quadratic pyramids", pyramid, 13},
    {triquadratic_hexahedron, "triquadratic hexahedron", "triquadratic hexahedra", hexahedron, 27},
    {quadratic_linear_wedge, "quadratic-linear wedge", "quadratic-linear wedges", wedge, 12},
    {biquadratic_quadratic_wedge, "biquadratic-quadratic wedge", "biquadratic-quadratic wedges", wedge, 18},
    {biquadratic_quadratic_hexahedron, "biquadratic-quadratic hexahedron", "biquadratic-quadratic hexahedra",
     hexahedron, 24},
    {triquadratic_pyramid, "triquadratic pyramid", "triquadratic pyramids", pyramid, 19},
    {polyhedron, "polyhedron", "polyhedra", polyhedron, 0},
    {lagrange_tetrahedron, "Lagrange tetrahedron", "Lagrange tetrahedra", tetrahedron, 0},
    {lagrange_hexahedron, "Lagrange hexahedron", "Lagrange hexahedra", hexahedron, 0},
    {lagrange_wedge, "Lagrange wedge", "Lagrange wedges", wedge, 0},
    {lagrange_pyramid, "Lagrange pyramid", "Lagrange pyramids", pyramid, 0},
    {quadratic_pyramid_14, "quadratic pyramid of 14 nodes", "quadratic pyramids of 14 nodes", pyramid, 14},
    {quadratic_tetrahedron_14, "quadratic tetrahedron of 14 nodes", "quadratic tetrahedra of 14 nodes", tetrahedron,
     14},
};

}  // namespace

const CellFrame& frame_of(CellKind linear_kind) {
  switch (linear_kind) {
    case tetrahedron:
      return tetrahedron_frame;
    case voxel:
      return voxel_frame;
    case hexahedron:
      return hexahedron_frame;
    case wedge:
      return wedge_frame;
    case pyramid:
      return pyramid_frame;
    case pentagonal_prism:
      return pentagonal_prism_frame;
    case hexagonal_prism:
      return hexagonal_prism_frame;
    default:
      break;
  }
  RHORAY_CHECK(false && "a linear kind with a frame");
  return tetrahedron_frame;
}

const KindOfCell& description_of(CellKind kind) {
  const auto* found = std::find_if(std::begin(kinds), std::end(kinds), [&](const auto& k) { return k.kind == kind; });
  RHORAY_CHECK(found != std::end(kinds));
  return *found;
}

std::string with_commas(std::uint64_t number) {
  std::string text = concat(number);
  for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
  return text;
}

std::string counted(std::uint64_t count, CellKind kind) {
  const KindOfCell& description = description_of(kind);
  return concat(with_commas(count), " ", count == 1 ? description.singular : description.plural);
}

}  // namespace rhoray::preprocess
