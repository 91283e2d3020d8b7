#pragma once

#include <tbb/task_group.h>

#include <optional>
#include <type_traits>
#include <utility>

#include "formats/base/floating_point.h"

namespace rhoray::preprocess {

/// Returns act(), called in the default floating-point environment (formats/base/floating_point.h), which holds for all
/// parallel loops of oneTBB in it as well: oneTBB runs tasks in the environment that their context has captured, and
/// contexts of loops take that of the context around them. Without one of their own that is the environment in which
/// the calling thread first used oneTBB.
template <class Act>
std::invoke_result_t<const Act&> in_default_floating_point(const Act& act) {
  const DefaultFloatingPoint default_floating_point;
  tbb::task_group_context context(tbb::task_group_context::bound,
                                  tbb::task_group_context::default_traits | tbb::task_group_context::fp_settings);
  tbb::task_group group(context);
  std::optional<std::invoke_result_t<const Act&>> result;
  group.run_and_wait([&] { result.emplace(act()); });
  return std::move(*result);
}

}  // namespace rhoray::preprocess
