#include "preprocess/grid/bricks/lattice_choice.h"

#include "formats/base/error.h"
#include "formats/base/invertible.h"

namespace rhoray::preprocess {

formats::BrickLayout bricked_layout(const Index3& sample_count, std::int64_t edge, std::int64_t superbrick) {
  if (edge < 2 || edge > 64) throw Error(ErrorCode::usage, concat("brick edge: found ", edge, "; expected 2 to 64"));
  if (superbrick < 1 || superbrick > 64)
    throw Error(ErrorCode::usage, concat("superbrick edge: found ", superbrick, "; expected 1 to 64"));
  return formats::BrickLayout::bricked(sample_count, edge, superbrick);
}

void check_frame(const Affine& world_from_grid, const std::string& source_name) {
  if (!is_invertible(world_from_grid))
    throw Error(ErrorCode::invalid,
                concat(source_name, ": found grid axes that span a volume of ", world_from_grid.determinant(),
                       "; expected three independent, finite axes, not too small to be inverted, and a finite origin"),
                "give the spacing and the origin as options");
}

}  // namespace rhoray::preprocess
