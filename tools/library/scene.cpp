#include "rhoray/scene.h"

#include <cmath>
#include <utility>

#include "render/document.h"
#include "tools/library/arrays.h"
#include "tools/library/conversions.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

namespace {

double aspect_of(const Size& size) {
  if (size.width < 1 || size.height < 1)
    inside::refuse("a picture of ", size.width, " x ", size.height, " pixels; expected at least 1 x 1");
  return static_cast<double>(size.width) / size.height;
}

render::View inside_of(const View& view, const render::ViewAxes& axes) {
  for (const auto& [name, angle] : {std::pair{"azimuth_deg", view.azimuth_deg}, {"elevation_deg", view.elevation_deg}})
    if (!std::isfinite(angle)) inside::refuse("View::", name, ": found ", angle, "; expected a finite number");
  return {.azimuth_deg = view.azimuth_deg,
          .elevation_deg = view.elevation_deg,
          .zoom = view.zoom,
          .vertical_fov_deg = view.vertical_fov_deg,
          .orthographic = view.is_orthographic,
          .axes = axes};
}

}  // namespace

Method Method::sampled(double step_cells, bool bisects) {
  if (!(step_cells >= 1e-4 && step_cells <= 1e4))
    inside::refuse("Method::sampled: steps of ", step_cells, " cells; expected 0.0001 to 10000");
  Method method;
  method.step_cells_ = step_cells, method.bisects_ = bisects;
  return method;
}

Method Method::paper() {
  return {};
}

Camera fit_camera(const Scene& scene, const Size& size, const View& view, const Watch& watch) {
  return inside::guarded([&] {
    const rhoray::Watch watched = inside::inside_of(watch);
    const double aspect = aspect_of(size);
    const render::ResolvedScene resolved = inside::resolved(scene, {.size = size}, watched);
    const render::ViewAxes axes = render::view_axes({}, resolved);
    return inside::outside_of(
        render::fit_camera_to(render::what_is_shown(resolved, watched).corners, inside_of(view, axes), aspect));
  });
}

Camera fit_camera(const Box3& box, const Size& size, const View& view) {
  return inside::guarded([&] {
    const double aspect = aspect_of(size);
    if (!(box.min.x <= box.max.x && box.min.y <= box.max.y && box.min.z <= box.max.z))
      inside::refuse("fit_camera: the box is empty; expected min <= max");
    if (!inside::is_finite(box.min) || !inside::is_finite(box.max))
      inside::refuse("fit_camera: the box is not finite; expected finite numbers");
    return inside::outside_of(render::fit_camera(inside::inside_of(box), inside_of(view, {}), aspect));
  });
}

}  // namespace rhoray::v0_1
