#include "tools/rhoray/scene/clip.h"

#include <utility>

#include "formats/base/error.h"
#include "tools/rhoray/scene/plane_text.h"

namespace rhoray::tools {

namespace {

constexpr const char* keep_inside = "inside";
constexpr const char* keep_outside = "outside";

bool is_box(const Vec3& low, const Vec3& high) {
  return low.x < high.x && low.y < high.y && low.z < high.z;
}

/// Two corners.
ValueKind<Box3> box_value() {
  const std::string expected =
      "two corners [[x, y, z], [x, y, z]]; each coordinate of the first is below that of the second";
  const ValueKind<Vec3> corner = vector_value();
  return {.expected = expected,
          .schema = {{"type", "array"}, {"items", corner.schema}, {"minItems", 2}, {"maxItems", 2}},
          .read = [=](const Json& json, const Reading& at) -> Box3 {
            if (!json.is_array() || json.size() != 2) at.place.refuse(json, expected);
            const Vec3 low = corner.read(json[0], at.at(0)), high = corner.read(json[1], at.at(1));
            if (!is_box(low, high)) at.place.refuse(json, expected);
            return {low, high};
          },
          .write =
              [=](const Box3& box) {
                return Json::array({corner.write(box.min), corner.write(box.max)});
              }};
}

ValueKind<std::vector<render::HalfSpace>> half_spaces_value() {
  constexpr std::size_t most = render::Clip::most_planes;
  const std::string expected = concat("an array of 1 to ", most, " planes");
  return {.expected = expected,
          .schema = {{"type", "array"}, {"items", schema_of(half_space_rows())}, {"minItems", 1}, {"maxItems", most}},
          .read =
              [expected](const Json& json, const Reading& at) {
                if (!json.is_array() || json.empty() || json.size() > most) at.place.refuse(json, expected);
                std::vector<render::HalfSpace> planes;
                for (std::size_t i = 0; i < json.size(); ++i)
                  planes.push_back(read_object(json[i], at.at(i), half_space_rows()));
                return planes;
              },
          .write =
              [](const std::vector<render::HalfSpace>& planes) {
                Json json = Json::array();
                for (const render::HalfSpace& plane : planes) json.push_back(write_object(plane, half_space_rows()));
                return planes.empty() ? Json() : json;
              }};
}

/// Six numbers as two vectors.
std::pair<Vec3, Vec3> two_vectors(const std::string& text, const std::string& expected) {
  std::size_t third_comma = std::string::npos, from = 0;
  for (int comma = 0; comma < 3; ++comma) {
    third_comma = text.find(',', from);
    from = third_comma + 1;
    if (third_comma == std::string::npos)
      throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected));
  }
  std::pair<Vec3, Vec3> vectors;
  try {
    read_value(text.substr(0, third_comma), vectors.first);
    read_value(text.substr(third_comma + 1), vectors.second);
  } catch (const Error&) {
    throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected));
  }
  return vectors;
}

Box3 read_box(const std::string& text) {
  const std::string expected = "six finite numbers x0,y0,z0,x1,y1,z1 with x0 < x1, y0 < y1 and z0 < z1";
  const auto [low, high] = two_vectors(text, expected);
  if (!is_box(low, high)) throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected));
  return {low, high};
}

std::string words_of(const Vec3& a, const Vec3& b) {
  return concat(a.x, ",", a.y, ",", a.z, ",", b.x, ",", b.y, ",", b.z);
}

}  // namespace

ValueKind<Vec3> direction_value() {
  ValueKind<Vec3> kind = vector_value();
  kind.expected = "three numbers [x, y, z], not all 0";
  kind.read = [read = kind.read, expected = kind.expected](const Json& json, const Reading& at) {
    const Vec3 direction = read(json, at);
    if (direction == Vec3(0, 0, 0)) at.place.refuse(json, expected);
    return direction;
  };
  return kind;
}

render::HalfSpace read_half_space(const std::string& text) {
  const std::string expected = "six finite numbers px,py,pz,nx,ny,nz: a point, and a normal that is not 0";
  const auto [point, normal] = two_vectors(text, expected);
  if (normal == Vec3(0, 0, 0)) throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected));
  return {.point = point, .normal = normal};
}

const std::vector<Row<render::HalfSpace>>& half_space_rows() {
  static const std::vector<Row<render::HalfSpace>> rows{
      required(row("point", &render::HalfSpace::point, vector_value(), "A point of the plane, in world units")),
      required(row("normal", &render::HalfSpace::normal, direction_value(),
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

std::vector<Option> clip_options(std::optional<ClipSpec>& spec) {
  const auto said = [&spec]() -> ClipSpec& { return spec ? *spec : spec.emplace(); };
  return {with_details({Option::Kind::value, "--clip-box", "X0,Y0,Z0,X1,Y1,Z1",
                        "Show only the inside of this box, in world units",
                        [said](const std::string& text) { said().box = read_box(text); }},
                       "Surfaces are cut open, not capped"),
          with_details({Option::Kind::value, "--clip-plane", "PX,PY,PZ,NX,NY,NZ...",
                        "Show only the normal's side of a plane. 0,0,40,0,0,1 shows what lies above z = 40",
                        [said](const std::string& text) {
                          if (said().planes.size() == render::Clip::most_planes)
                            throw Error(ErrorCode::usage,
                                        concat("too many planes; expected at most ", render::Clip::most_planes));
                          said().planes.push_back(read_half_space(text));
                        }},
                       concat("May be given up to ", render::Clip::most_planes, " times")),
          {Option::Kind::flag, "--cut-away", "", "Hide the inside of the clip region, and show the rest",
           [said](const std::string&) { said().keep = keep_outside; }}};
}

std::optional<render::Clip> choose_clip(const std::optional<ClipSpec>& spec, const Place& place) {
  if (!spec) return std::nullopt;
  if (!spec->box && spec->planes.empty() && place.document.empty())
    throw Error(ErrorCode::usage, "--cut-away: no clip region given; expected --clip-box or --clip-plane");
  if (!spec->box && spec->planes.empty())
    throw Error(ErrorCode::invalid, concat(place.text(), ": has no region; expected \"box\" or \"planes\""));
  return render::Clip{.box = spec->box, .planes = spec->planes, .cuts_away = spec->keep == keep_outside};
}

std::optional<ClipSpec> clip_spec(const std::optional<render::Clip>& clip) {
  if (!clip) return std::nullopt;
  return ClipSpec{.box = clip->box, .planes = clip->planes, .keep = clip->cuts_away ? keep_outside : keep_inside};
}

std::vector<std::string> clip_words(const ClipSpec& spec) {
  std::vector<std::string> words;
  if (spec.box) words.insert(words.end(), {"--clip-box", words_of(spec.box->min, spec.box->max)});
  for (const render::HalfSpace& plane : spec.planes)
    words.insert(words.end(), {"--clip-plane", words_of(plane.point, plane.normal)});
  if (spec.keep == keep_outside) words.emplace_back("--cut-away");
  return words;
}

Box3 bounds_of(const render::Layer& layer, const ResolvedScene& plan) {
  const Box3 bounds = plan.volumes[layer.volume].bounds();
  return layer.mode == render::Mode::slice ? part_of_plane(layer.plane, bounds) : bounds;
}

std::vector<std::string> clip_notes(const ResolvedScene& plan, const Place& place) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i)
    if (bounds_of(plan.scene.layers[i], plan).isEmpty())
      notes.push_back(concat(
          "layer ", i, ": ",
          text_of_slice_outside(plan.scene.layers[i].plane, plan.volumes[plan.scene.layers[i].volume].bounds())));
  if (!plan.scene.clip) return notes;
  const std::string subject = place.document.empty() ? "clip" : place.text();
  for (std::size_t i = 0; i < plan.scene.layers.size(); ++i) {
    const render::Layer& layer = plan.scene.layers[i];
    const Box3 bounds = bounds_of(layer, plan);
    if (bounds.isEmpty()) continue;
    if (layer.clipped && what_is_left(*plan.scene.clip, bounds).isEmpty())
      notes.push_back(concat(subject, ": layer ", i, " is clipped away completely"));
  }
  return notes;
}

}  // namespace rhoray::tools
