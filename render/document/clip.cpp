#include "render/document/clip.h"

#include <utility>

#include "formats/base/error.h"
#include "render/document/slices.h"

namespace rhoray::render {

namespace {

/// Two corners.
ValueKind<Box3> box_value() {
  const std::string expected =
      "two corners [[x, y, z], [x, y, z]]; each coordinate of the first is below that of the second";
  const ValueKind<Vec3> corner = vector_value();
  return {.expected = expected,
          .schema = [corner]() -> Json {
            return {{"type", "array"}, {"items", corner.schema()}, {"minItems", 2}, {"maxItems", 2}};
          },
          .read = [=](const Json& json, const Reading& at) -> Box3 {
            if (!json.is_array() || json.size() != 2) at.place.refuse(json, expected);
            const Vec3 low = corner.read(json[0], at.at(0)), high = corner.read(json[1], at.at(1));
            if (!(low.x < high.x && low.y < high.y && low.z < high.z)) at.place.refuse(json, expected);
            return {low, high};
          },
          .write =
              [=](const Box3& box) {
                return Json::array({corner.write(box.min), corner.write(box.max)});
              }};
}

ValueKind<std::vector<HalfSpace>> half_spaces_value() {
  constexpr std::size_t most = Clip::most_planes;
  return list_of(half_space_rows(), concat("an array of 1 to ", most, " planes"), {1, most});
}

}  // namespace

const std::vector<Row<HalfSpace>>& half_space_rows() {
  static const std::vector<Row<HalfSpace>> rows{
      required(row("point", &HalfSpace::point, vector_value(), "A point of the plane, in world units")),
      required(row("normal", &HalfSpace::normal, direction_value(),
                   "Normal of the plane, of any length; it points into the region"))};
  return rows;
}

const std::vector<Row<ClipSpec>>& clip_rows() {
  static const std::vector<Row<ClipSpec>> rows{
      row("box", &ClipSpec::box, box_value(), "Box that bounds the region, in world axes"),
      row("planes", &ClipSpec::planes, half_spaces_value(),
          "Planes that bound the region; it lies on the normal's side of each"),
      row("keep", &ClipSpec::keep, word_value({keep_inside, keep_outside}),
          "\"inside\", the default: only the inside of the region is shown; \"outside\": only the rest")};
  return rows;
}

std::optional<Clip> choose_clip(const std::optional<ClipSpec>& spec, const Place& place) {
  if (!spec) return std::nullopt;
  if (!spec->box && spec->planes.empty() && place.document.empty())
    throw Error(ErrorCode::usage, "--cut-away: no clip region given; expected --clip-box or --clip-plane");
  if (!spec->box && spec->planes.empty())
    throw Error(ErrorCode::invalid, concat(place.text(), ": has no region; expected \"box\" or \"planes\""));
  return Clip{.box = spec->box, .planes = spec->planes, .cuts_away = spec->keep == keep_outside};
}

std::optional<ClipSpec> clip_spec(const std::optional<Clip>& clip) {
  if (!clip) return std::nullopt;
  return ClipSpec{.box = clip->box, .planes = clip->planes, .keep = clip->cuts_away ? keep_outside : keep_inside};
}

Box3 bounds_of(const Layer& layer, const ResolvedScene& plan) {
  const Box3 bounds = plan.datasets[layer.dataset].bounds();
  return layer.mode == Mode::slice ? part_of_plane(layer.plane, bounds) : bounds;
}

std::vector<std::string> clip_notes(const ResolvedScene& plan, const Place& place) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i)
    if (bounds_of(plan.scene.layers[i], plan).isEmpty())
      notes.push_back(concat(
          "layer ", i, ": ",
          text_of_slice_outside(plan.scene.layers[i].plane, plan.datasets[plan.scene.layers[i].dataset].bounds())));
  if (!plan.scene.clip) return notes;
  const std::string subject = place.document.empty() ? "clip" : place.text();
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const Layer& layer = plan.scene.layers[i];
    const Box3 bounds = bounds_of(layer, plan);
    if (bounds.isEmpty()) continue;
    if (layer.clipped && what_is_left(*plan.scene.clip, bounds).isEmpty())
      notes.push_back(concat(subject, ": layer ", i, " is clipped away completely"));
  }
  return notes;
}

}  // namespace rhoray::render
