#include "tools/rhoray/bench/views.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/text.h"
#include "formats/base/word_list.h"
#include "render/ray_caster.h"

namespace rhoray::tools {

namespace {

/// Distance from the camera to the surface in the middle of its picture, or nothing.
std::optional<double> distance_in_the_middle(const render::Dataset& dataset, double isovalue,
                                             const render::Camera& camera) {
  const render::Ray ray = render::camera_rays(dataset, camera, 1, 1).front();
  const render::Hit hit = render::RayCaster(dataset, isovalue, {}).first_crossing(ray);
  if (hit.is_miss()) return std::nullopt;
  return hit.t;
}

render::Camera close_camera(const render::Camera& front, const render::Dataset& dataset,
                            std::optional<double> isovalue) {
  const Box3 box = dataset.bounds();
  const Vec3 size = box.size();
  const Vec3 forward = (front.target - front.position).normalized();
  const double to_box = (front.target - front.position).length() - size.y / 2;
  const double to_surface = isovalue ? distance_in_the_middle(dataset, *isovalue, front).value_or(to_box) : to_box;
  render::Camera camera = front;
  camera.target = front.position + to_surface * forward;
  camera.position = camera.target - 0.4 * std::min({size.x, size.y, size.z}) * forward;
  camera.vertical_fov_deg = 45;
  return camera;
}

}  // namespace

const char* name_of(StudyView view) {
  constexpr std::array names{"front", "from-feet", "close-up", "inside"};
  return names[static_cast<std::size_t>(view)];
}

StudyView study_view_named(const std::string& name) {
  for (const StudyView view : study_views)
    if (name == name_of(view)) return view;
  throw Error(ErrorCode::usage, concat("view '", name, "'; expected front, from-feet, close-up or inside"),
              did_you_mean(name, names_in(study_views, name_of)));
}

render::Camera study_camera(StudyView view, const render::Dataset& dataset, std::optional<double> isovalue,
                            double aspect) {
  const Box3 box = dataset.bounds();
  switch (view) {
    case StudyView::front:
      break;
    case StudyView::from_feet:
      return render::fit_camera(box, {.azimuth_deg = 0, .elevation_deg = -80}, aspect);
    case StudyView::inside: {
      const Vec3 size = box.size();
      return {.position = box.center(),
              .target = box.center() + Vec3(0.5, 0.8, 0.3) * std::max({size.x, size.y, size.z}),
              .vertical_fov_deg = 75};
    }
    case StudyView::close_up:
      return close_camera(study_camera(StudyView::front, dataset, isovalue, aspect), dataset, isovalue);
  }
  return render::fit_camera(box, {.azimuth_deg = 0, .elevation_deg = 0}, aspect);
}

}  // namespace rhoray::tools
