#include "rhoray/accuracy.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"
#include "render/accuracy.h"
#include "tools/library/conversions.h"
#include "tools/library/guarded.h"
#include "tools/library/picture.h"

namespace rhoray::v0_1 {

namespace {

CheckedPixels outside_of(const render::CheckedPixels& pixels) {
  return {.pixels = pixels.pixels,
          .shown = pixels.shown,
          .missed = pixels.missed,
          .false_hits = pixels.false_hits,
          .beyond_bound = pixels.beyond_bound,
          .error_of_99 = pixels.kept_by_99,
          .largest_error = pixels.largest};
}

void check(const Goal& goal) {
  if (!goal.max_error && !goal.budget_ms) inside::refuse("Goal: no numbers; expected max_error or budget_ms");
  for (const auto& [name, value] : {std::pair{"max_error", goal.max_error}, {"budget_ms", goal.budget_ms}})
    if (value && !(*value > 0 && std::isfinite(*value)))
      inside::refuse("Goal::", name, ": found ", *value, "; expected a finite number above 0");
}

}  // namespace

MethodChoice choose_method(const Scene& scene, std::size_t layer, const Size& size, const Goal& goal,
                           const Watch& watch) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(watch);
    check(goal);
    render::ResolvedScene resolved = inside::resolved_with_camera(scene, {.size = size}, watched);
    resolved.frame.machine = inside::machine_of(goal.machine, "Goal::machine");
    if (layer >= resolved.scene.layers.size())
      inside::refuse("choose_method: layer ", layer, " of ", resolved.scene.layers.size());
    const render::Mode mode = resolved.scene.layers[layer].mode;
    if (mode != render::Mode::isosurface && mode != render::Mode::mip)
      inside::refuse("choose_method: layer ", layer, " is neither an isosurface nor a projection");
    const render::Choice choice =
        render::choose_method(resolved, layer, {.max_error = goal.max_error, .budget_ms = goal.budget_ms},
                              std::min(goal.threads, available_cores()), watched);
    return MethodChoice{.method = inside::outside_of(choice.chosen.method),
                        .error = choice.chosen.error,
                        .predicted_ms = choice.chosen.foreseen_ms,
                        .meets_goal = choice.meets_goal,
                        .sentence = choice.sentence};
  });
}

SelfCheck self_check(const Scene& scene, const Picture& picture, const SelfCheckOptions& options) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(options.watch);
    const render::Framebuffer& pixels = picture.implementation().pixels;
    const Size size = picture.size();
    if (pixels.pixel_count() == 0 || pixels.width != size.width || pixels.height != size.height)
      inside::refuse("self_check: the picture is empty or a window; expected a whole picture");
    if (options.pixels < 1) inside::refuse("SelfCheckOptions::pixels: found 0; expected at least 1");
    const render::ResolvedScene resolved = inside::resolved_with_camera(scene, {.size = size}, watched);
    if (const std::string why = render::why_not_checkable(resolved); !why.empty()) inside::refuse("self_check: ", why);
    const bool is_projection = resolved.scene.layers[0].mode == render::Mode::mip;
    if (is_projection ? pixels.value.empty() : pixels.depth.empty())
      inside::refuse("self_check: the picture has no channel `", is_projection ? "value" : "depth",
                     "`; ask for it in RenderOptions::channels");
    const render::SelfCheck check = render::check_picture(
        resolved, pixels, {.pixels = options.pixels, .seed = options.seed, .limit = {}, .watch = watched},
        std::min(options.threads, available_cores()));
    return SelfCheck{.random = outside_of(check.random),
                     .edges = outside_of(check.edges),
                     .promise = check.limit,
                     .broken = check.broken};
  });
}

}  // namespace rhoray::v0_1
