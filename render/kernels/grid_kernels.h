#pragma once

#include "render/kernels/grid_certified.h"
#include "render/kernels/grid_crossing.h"
#include "render/kernels/grid_judged.h"
#include "render/kernels/grid_maximum.h"
#include "render/kernels/grid_sampled.h"
#include "render/kernels/kernel_of.h"

/// The table of a grid's kernels. The sources beside this header instantiate kernels_for, some views each.
namespace rhoray::render {

template <class View>
Kernels kernels_for(const View& view, Method::Way way) {
  Kernels kernels{.first_crossing = kernel_of<View, first_crossing_of_ray<View>>,
                  .largest_value = kernel_of<View, largest_value_on_ray<View>>,
                  .queue_entries = largest_queue_size(view.lattice(), view.level_count())};
  switch (way) {
    case Method::Way::sampled:
      kernels.first_crossing = kernel_of<View, sampled_crossing_of_ray<View>>;
      kernels.largest_value = kernel_of<View, sampled_maximum_on_ray<View>>;
      break;
    case Method::Way::certified:
      kernels.first_crossing = kernel_of<View, certified_first_crossing<View>>;
      kernels.largest_value = kernel_of<View, certified_largest_value<View>>;
      break;
    case Method::Way::judged:
      kernels.first_crossing = kernel_of<View, judged_first_crossing<View>>;
      kernels.largest_value = kernel_of<View, judged_largest_value<View>>;
      break;
    case Method::Way::direct:
    case Method::Way::preview:
    case Method::Way::paper:
    case Method::Way::slack:
      break;
  }
  return kernels;
}

}  // namespace rhoray::render
