#include "tools/rhoray/render/plane_options.h"

#include <utility>

#include "formats/base/error.h"
#include "formats/base/read_value.h"
#include "render/scene_spec.h"
#include "tools/rhoray/cli/option_values.h"

namespace rhoray::tools {

namespace {

bool is_box(const Vec3& low, const Vec3& high) {
  return low.x < high.x && low.y < high.y && low.z < high.z;
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

render::HalfSpace read_half_space(const std::string& text) {
  const std::string expected = "six finite numbers px,py,pz,nx,ny,nz: a point, and a normal that is not 0";
  const auto [point, normal] = two_vectors(text, expected);
  if (normal == Vec3(0, 0, 0)) throw Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected));
  return {.point = point, .normal = normal};
}

/// z, z=40, or px,py,pz,nx,ny,nz.
render::LayerSpec read_slice(const std::string& text) {
  render::LayerSpec spec{.type = render::LayerType::slice};
  const std::size_t equals = text.find('=');
  const std::string expected =
      "an axis and a position such as z=40, an axis alone for the middle of the data, or a point and a normal "
      "px,py,pz,nx,ny,nz";
  const auto refuse = [&] { return Error(ErrorCode::usage, concat("found '", text, "'; expected ", expected)); };
  try {
    if (const std::string axis = text.substr(0, equals); axis == "x" || axis == "y" || axis == "z") {
      spec.axis = axis;
      if (equals != std::string::npos) read_value(text.substr(equals + 1), spec.position);
      return spec;
    }
    const render::HalfSpace plane = read_half_space(text);
    spec.point = plane.point, spec.normal = plane.normal;
    return spec;
  } catch (const Error&) {
    throw refuse();
  }
}

}  // namespace

std::vector<Option> clip_options(std::optional<render::ClipSpec>& spec) {
  const auto said = [&spec]() -> render::ClipSpec& { return spec ? *spec : spec.emplace(); };
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
           [said](const std::string&) { said().keep = render::keep_outside; }}};
}

Option slice_option(std::vector<render::LayerSpec>& slices) {
  return with_details(
      {Option::Kind::value, "--slice", "AXIS[=POSITION]...",
       "Show the field on a plane, such as z=40. Without --mode and --iso, only slices are shown",
       [&slices](const std::string& text) { slices.push_back(read_slice(text)); }},
      "z=40 is perpendicular to z at 40 world units, z lies in the middle of the data, px,py,pz,nx,ny,nz is a point "
      "and a normal. May be given several times. --colormap and --range set the colours");
}

std::vector<std::string> clip_words(const render::ClipSpec& spec) {
  std::vector<std::string> words;
  if (spec.box) words.insert(words.end(), {"--clip-box", words_of(spec.box->min, spec.box->max)});
  for (const render::HalfSpace& plane : spec.planes)
    words.insert(words.end(), {"--clip-plane", words_of(plane.point, plane.normal)});
  if (spec.keep == render::keep_outside) words.emplace_back("--cut-away");
  return words;
}

}  // namespace rhoray::tools
