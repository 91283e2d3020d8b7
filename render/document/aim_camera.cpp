#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "formats/base/box_corners.h"
#include "formats/base/error.h"
#include "render/document/clip.h"
#include "render/document/lights.h"
#include "render/document/resolve.h"
#include "render/document/styles.h"
#include "render/document/values.h"

namespace rhoray::render {

namespace {

/// Width of a colour bar with numbers of five digits, or of a legend with a short word, as a share
/// of the picture's height. Annotations of narrow pictures shrink: the height counts as at most 1.2
/// times the width.
constexpr double width_of_scale = 0.14, tallest_shape = 1.2;

/// Keeps free where the colour bar and the legend stand. The legend stands on the left, unless the
/// bar does.
void keep_sides_free(const AnnotationsSpec& annotations, double aspect, View& view) {
  const bool is_bar_left = annotations.color_bar && annotations.color_bar->position == "left";
  const double width = width_of_scale * std::min(1 / aspect, tallest_shape);
  if (annotations.color_bar) (is_bar_left ? view.free_left : view.free_right) = width;
  if (annotations.legend.value_or(false)) (is_bar_left ? view.free_right : view.free_left) = width;
}

/// Counts the scales beside the shown data: colour bar and legend.
int count_of_scales(const AnnotationsSpec& annotations) {
  return (annotations.color_bar ? 1 : 0) + (annotations.legend.value_or(false) ? 1 : 0);
}

/// The boxes around parts of a layer, before clipping.
std::vector<std::array<Vec3, 8>> boxes_of(const Layer& layer, const ResolvedScene& plan, const Watch& watch) {
  if (layer.mode == Mode::isosurface || layer.mode == Mode::triangles)
    return plan.datasets[layer.dataset].shown_boxes(layer.isovalue, watch);
  const Box3 bounds = bounds_of(layer, plan);
  if (bounds.isEmpty()) return {};
  return {corners_of(bounds)};
}

/// The corners of what is left of a box; none where nothing is.
std::vector<Vec3> left_of(const std::optional<Clip>& clip, const std::array<Vec3, 8>& corners) {
  Box3 box;
  for (const Vec3& corner : corners) box.extendBy(corner);
  if (!clip || leaves_whole(*clip, box)) return {corners.begin(), corners.end()};
  const Box3 left = what_is_left(*clip, box);
  if (left.isEmpty()) return {};
  const std::array<Vec3, 8> of_left = corners_of(left);
  return {of_left.begin(), of_left.end()};
}

/// The view, without a target and free sides.
View view_of(const SceneSpec& scene_spec, const ResolvedScene& plan) {
  const CameraSpec& spec = scene_spec.camera;
  View view = named_view(spec.view.value_or("iso"), view_axes(scene_spec, plan));
  view.azimuth_deg = spec.azimuth_deg.value_or(view.azimuth_deg);
  view.elevation_deg = spec.elevation_deg.value_or(view.elevation_deg);
  view.zoom = spec.zoom.value_or(spec.position ? view.zoom : default_zoom(plan));
  view.vertical_fov_deg = spec.fov_deg.value_or(view.vertical_fov_deg);
  view.orthographic = spec.orthographic_height ? true : spec.orthographic.value_or(false);
  return view;
}

/// Returns the points that the camera is fitted to: the drawn box, or else the shown data.
std::vector<Vec3> points_to_fit(const Shown& shown, const ResolvedScene& plan) {
  if (!plan.annotations.box.value_or(false)) return shown.corners;
  const std::array<Vec3, 8> corners = corners_of(shown.box);
  return {corners.begin(), corners.end()};
}

/// The size of a picture for which none is given, and whose camera is fitted (PictureSpec::size).
PictureSize size_for(std::span<const Vec3> points, View view, const AnnotationsSpec& annotations) {
  constexpr PictureSize usual{};
  constexpr double pixels = static_cast<double>(usual.width) * usual.height;
  constexpr double narrowest = 2.0 / 3, widest = 2;
  view.zoom = 1;
  const double shape =
      seen_aspect(points, fit_camera_to(points, view, static_cast<double>(usual.width) / usual.height));
  const double scales = width_of_scale * count_of_scales(annotations);
  double aspect = shape + scales;
  if (aspect < 1 / tallest_shape) aspect = shape / (1 - tallest_shape * scales);
  aspect = std::clamp(aspect, narrowest, widest);
  const auto even = [](double length) { return 2 * static_cast<int>(std::lround(length / 2)); };
  return {even(std::sqrt(pixels * aspect)), even(std::sqrt(pixels / aspect))};
}

}  // namespace

ViewAxes view_axes(const SceneSpec& scene_spec, const ResolvedScene& plan) {
  if (scene_spec.camera.up_axis) return axes_with_up(*scene_spec.camera.up_axis);
  const auto any_of = [&](auto&& is) { return std::any_of(plan.datasets.begin(), plan.datasets.end(), is); };
  if (any_of([](const Dataset& dataset) { return dataset.space() != formats::Space::unknown; }))
    return axes_of(plan.space == formats::Space::ras ? ViewFrame::anatomical_ras : ViewFrame::anatomical_lps);
  return axes_of(any_of([](const Dataset& dataset) { return !dataset.is_y_up(); }) ? ViewFrame::engineering_z_up
                                                                                   : ViewFrame::engineering_y_up);
}

double default_zoom(const ResolvedScene& plan) {
  constexpr double zoom_with_box = 0.9;
  return plan.annotations.box.value_or(false) ? zoom_with_box : View{}.zoom;
}

Shown what_is_shown(const ResolvedScene& plan, const Watch& watch) {
  Shown shown;
  for (const Layer& layer : plan.scene.layers) {
    const std::optional<Clip>& clip = plan.scene.clip;
    for (const auto& box : boxes_of(layer, plan, watch))
      for (const Vec3& corner : left_of(layer.clipped ? clip : std::nullopt, box)) shown.corners.push_back(corner);
  }
  if (shown.corners.empty())
    for (const Layer& layer : plan.scene.layers)
      for (const Vec3& corner : corners_of(plan.datasets[layer.dataset].bounds())) shown.corners.push_back(corner);
  for (const Vec3& corner : shown.corners) shown.box.extendBy(corner);
  return shown;
}

void place_camera(const SceneSpec& scene_spec, const FindShown& find_shown, const std::optional<Vec3>& middle,
                  ResolvedScene& plan) {
  const CameraSpec& spec = scene_spec.camera;
  const bool is_document = !scene_spec.document.empty();
  at_place(root(scene_spec).at("camera"), [&] {
    View view = view_of(scene_spec, plan);
    view.target = middle;

    const double aspect = static_cast<double>(plan.frame.width) / plan.frame.height;
    keep_sides_free(plan.annotations, aspect, view);
    const bool is_given = spec.position && spec.target && spec.up && (!view.orthographic || spec.orthographic_height);
    Camera& camera = plan.scene.camera;
    if (is_given)
      camera = fit_camera(plan.datasets[0].bounds(), view, aspect);
    else
      camera = fit_camera_to(points_to_fit(find_shown(), plan), view, aspect);
    camera.position = spec.position.value_or(camera.position);
    camera.target = spec.target.value_or(camera.target);
    camera.up = spec.up.value_or(camera.up);
    camera.orthographic_height = spec.orthographic_height.value_or(camera.orthographic_height);
    if (spec.orthographic_height && spec.zoom)
      plan.notes.push_back("zoom has no effect: the orthographic height is given");
    const Vec3 forward = camera.target - camera.position;
    if (!std::isfinite(forward.length()))
      throw Error(ErrorCode::usage, "the camera is too far from its target; expected a distance below 1e154");
    if (!(forward.cross(camera.up).length() > 0))
      throw Error(ErrorCode::usage, "the camera has no direction: position, target and up lie on one line",
                  is_document ? "give another \"up\" or \"target\"" : "give another --camera-up or --camera-target");
  });
}

namespace {

void place_lights(const SceneSpec& scene_spec, const FindShown& find_shown, ResolvedScene& plan) {
  const ShownBox shown = [&] { return find_shown().box; };
  Scene& scene = plan.scene;
  scene.lights = choose_lights(scene_spec, scene.camera, view_axes(scene_spec, plan));
  scene.occlusion = choose_occlusion(scene_spec, shown);
  scene.fog = choose_fog(scene_spec.effects.fog, scene.camera, scene.background, shown);
  for (const std::string& note : light_notes(scene, plan.datasets)) plan.notes.push_back(note);
  const bool has_surface = std::any_of(scene.layers.begin(), scene.layers.end(), [](const Layer& layer) {
    return layer.mode != Mode::mip && layer.mode != Mode::slice;
  });
  if (!has_surface && (scene_spec.lights || scene_spec.effects.occlusion))
    plan.notes.push_back("lights and occlusion have no effect: no layer is a surface");
}

/// Rays of an eye inside data start on the side that the field has there.
void note_camera_inside(ResolvedScene& plan) {
  if (plan.scene.camera.orthographic) return;
  for (std::size_t v = 0; v < plan.datasets.size(); ++v)
    if (plan.datasets[v].bounds().intersects(plan.scene.camera.position))
      plan.notes.push_back(concat("the camera is inside ", plan.data[v].file.string(), "; rays start inside the data"));
}

}  // namespace

void aim_camera(const SceneSpec& scene_spec, ResolvedScene& plan, const Watch& watch) {
  std::optional<Shown> shown;
  const FindShown find_shown = [&]() -> const Shown& {
    if (!shown) shown = what_is_shown(plan, watch);
    return *shown;
  };
  const CameraSpec& camera = scene_spec.camera;
  const bool is_fitted =
      !camera.position && !camera.target && !camera.up && !camera.orthographic_height && !camera.keyframes;
  if (!scene_spec.image.size && is_fitted)
    at_place(root(scene_spec).at("camera"), [&] {
      const PictureSize size = size_for(points_to_fit(find_shown(), plan), view_of(scene_spec, plan), plan.annotations);
      plan.frame.width = size.width, plan.frame.height = size.height;
    });
  aim_camera(scene_spec, find_shown, plan);
}

void aim_camera(const SceneSpec& scene_spec, const FindShown& find_shown, ResolvedScene& plan) {
  place_camera(scene_spec, find_shown, std::nullopt, plan);
  place_lights(scene_spec, find_shown, plan);
  if (scene_spec.camera.position) note_camera_inside(plan);
  if (plan.annotations.box.value_or(false)) plan.annotated_box = find_shown().box;
}

}  // namespace rhoray::render
