#include "render/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/document/values.h"

namespace rhoray::render {

namespace {

constexpr double frames_per_time = 25;  // where no number of frames is said

/// The key at or before a time, and how far it is to the next one.
struct Between {
  std::size_t key;
  double share;
};
Between between(const std::vector<double>& times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  if (after == times.begin()) return {0, 0};
  const auto key = static_cast<std::size_t>(after - times.begin()) - 1;
  if (key + 1 == times.size()) return {key, 0};
  return {key, (time - times[key]) / (times[key + 1] - times[key])};
}

/// The cubic with these ends and these rates for the whole way.
template <class T>
T cubic(const T& from, const T& to, const T& rate_from, const T& rate_to, double s) {
  const double a = s * s * (3 - 2 * s);
  return from + (to - from) * a + rate_from * (s * (1 - s) * (1 - s)) - rate_to * (s * s * (1 - s));
}

double slope(const std::vector<double>& times, const std::vector<double>& values, std::size_t from) {
  return (values[from + 1] - values[from]) / (times[from + 1] - times[from]);
}

/// The rate of a monotone cubic at a key: the weighted harmonic mean of the slopes beside it, 0
/// where it turns.
double rate(const std::vector<double>& times, const std::vector<double>& values, std::size_t key) {
  if (key == 0) return slope(times, values, 0);
  if (key + 1 == times.size()) return slope(times, values, key - 1);
  const double before = slope(times, values, key - 1), after = slope(times, values, key);
  if (!(before * after > 0)) return 0;
  const double way_before = times[key] - times[key - 1], way_after = times[key + 1] - times[key];
  const double w1 = 2 * way_after + way_before, w2 = way_after + 2 * way_before;
  return (w1 + w2) / (w1 / before + w2 / after);
}

Vec3 rate(const std::vector<double>& times, const std::vector<Vec3>& values, std::size_t key) {
  const std::size_t from = key == 0 ? 0 : key - 1, to = std::min(key + 1, times.size() - 1);
  return (values[to] - values[from]) / (times[to] - times[from]);
}

const char* angle_in(const KeyframeSpec& key) {
  return key.azimuth_deg ? "azimuth" : key.elevation_deg ? "elevation" : key.zoom ? "zoom" : nullptr;
}
const char* place_in(const KeyframeSpec& key) {
  return key.position ? "position" : key.target ? "target" : key.up ? "up" : nullptr;
}

/// Lets the height of an orthographic picture be fitted, and returns the one that was given.
std::optional<double> take_height(CameraSpec& camera) {
  const std::optional<double> height = std::exchange(camera.orthographic_height, std::nullopt);
  if (height) camera.orthographic = true;
  return height;
}

Place keys_place(const SceneSpec& scene_spec) {
  return Place{scene_spec.document, {}}.at("camera").at("keyframes");
}

std::size_t isosurface_count(const SceneSpec& scene_spec, std::size_t& last) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene_spec.layers.size(); ++i) {
    const LayerSpec& layer = scene_spec.layers[i];
    if (!layer.visible || layer.type != LayerType::isosurface) continue;
    count += layer.isovalues.size();
    last = i;
  }
  return count;
}

int frame_count_of(const SceneSpec& scene_spec, const std::vector<KeyframeSpec>& keys) {
  if (scene_spec.image.frames) return *scene_spec.image.frames;
  const double frames = 1 + std::round(frames_per_time * (keys.back().time - keys.front().time));
  if (!(frames <= limits::frames.hi))
    throw Error(ErrorCode::invalid,
                concat(keys_place(scene_spec).text(), ": need ", frames, " frames at ", frames_per_time,
                       " per unit of time; expected at most ", limits::frames.hi),
                "set \"frames\" of the image");
  return std::max(2, static_cast<int>(frames));
}

}  // namespace

template <class T>
T Track<T>::at(double time) const {
  const auto [key, share] = between(times_, time);
  if (share == 0) return values_[key];
  const double way = times_[key + 1] - times_[key];
  return cubic<T>(values_[key], values_[key + 1], rate(times_, values_, key) * way,
                  rate(times_, values_, key + 1) * way, share);
}
template class Track<double>;
template class Track<Vec3>;

void Sweep::check_keys() const {
  const Place place = keys_place(scene_spec_);
  if (keys_.size() < 2)
    throw Error(ErrorCode::invalid, concat(place.text(), ": found ", keys_.size(), "; expected at least 2 key frames"));
  const KeyframeSpec* of_angles = nullptr;
  const KeyframeSpec* of_places = nullptr;
  const KeyframeSpec* of_perspective = nullptr;
  const KeyframeSpec* of_orthographic = nullptr;
  std::size_t ignored = 0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const KeyframeSpec& key = keys_[i];
    if (i > 0 && !(key.time > keys_[i - 1].time))
      throw Error(ErrorCode::invalid,
                  concat(place.at(i).at("time").text(), ": found ", key.time, "; expected a time after ",
                         keys_[i - 1].time, ", the time of the previous key"));
    if (angle_in(key) != nullptr && of_angles == nullptr) of_angles = &key;
    if (place_in(key) != nullptr && of_places == nullptr) of_places = &key;
    if (key.fov_deg && of_perspective == nullptr) of_perspective = &key;
    if (key.orthographic_height && of_orthographic == nullptr) of_orthographic = &key;
    if (of_perspective != nullptr && of_orthographic != nullptr)
      throw Error(ErrorCode::invalid, concat(place.at(i).text(),
                                             ": \"fov\" and \"ortho_height\" are both in key frames; expected either "
                                             "perspective or orthographic cameras"));
    if (of_angles != nullptr && of_places != nullptr)
      throw Error(ErrorCode::invalid,
                  concat(place.at(i).text(), ": \"", place_in(*of_places), "\" and \"", angle_in(*of_angles),
                         "\" are both in key frames; expected either angles or positions"));
    if (key.isovalue && isosurface_count(scene_spec_, ignored) != 1)
      throw Error(ErrorCode::invalid,
                  concat(place.at(i).at("isovalue").text(), ": the scene shows ",
                         isosurface_count(scene_spec_, ignored), " isosurfaces; expected exactly one"));
  }
}

Sweep::Sweep(const SceneSpec& scene_spec)
    : scene_spec_(scene_spec), keys_(scene_spec.camera.keyframes.value_or(std::vector<KeyframeSpec>{})) {
  if (!scene_spec.camera.keyframes)
    throw Error(scene_spec.document.empty() ? ErrorCode::usage : ErrorCode::invalid,
                "several frames need a scene document with \"keyframes\" of the camera");
  check_keys();
  isosurface_count(scene_spec, isovalue_layer_);
  frame_count_ = frame_count_of(scene_spec, keys_);
  for (const KeyframeSpec& key : keys_) {
    const auto add = [&](auto& track, const auto& value) {
      if (value) track.add(key.time, *value);
    };
    add(azimuth_, key.azimuth_deg);
    add(elevation_, key.elevation_deg);
    if (key.zoom) log_zoom_.add(key.time, std::log(*key.zoom));
    add(fov_, key.fov_deg);
    if (key.orthographic_height) log_height_.add(key.time, std::log(*key.orthographic_height));
    add(isovalue_, key.isovalue);
    add(position_, key.position);
    add(target_, key.target);
    add(up_, key.up);
  }
}

double Sweep::time_of(int frame) const {
  const double first = keys_.front().time, last = keys_.back().time;
  if (frame == 0 || frame_count_ == 1) return first;
  return frame == frame_count_ - 1 ? last : first + (last - first) * frame / (frame_count_ - 1);
}

SceneSpec Sweep::spec_at(double time) const {
  SceneSpec scene_spec = scene_spec_;
  CameraSpec& camera = scene_spec.camera;
  camera.keyframes.reset();
  scene_spec.image.frames.reset();
  const auto set = [time](auto& member, const auto& track) {
    if (!track.is_empty()) member = track.at(time);
  };
  set(camera.azimuth_deg, azimuth_);
  set(camera.elevation_deg, elevation_);
  if (!log_zoom_.is_empty()) camera.zoom = std::exp(log_zoom_.at(time));
  set(camera.fov_deg, fov_);
  if (!log_height_.is_empty()) camera.orthographic_height = std::exp(log_height_.at(time));
  set(camera.position, position_);
  set(camera.target, target_);
  set(camera.up, up_);
  if (!isovalue_.is_empty()) scene_spec.layers[isovalue_layer_].isovalues = {concat(isovalue_.at(time))};
  return scene_spec;
}

void Sweep::check_isovalues(const ResolvedScene& plan) const {
  for (std::size_t l = 0; l < plan.scene.layers.size(); ++l) {
    if (plan.origins[l].spec != isovalue_layer_) continue;
    const formats::FieldSummary& field = plan.datasets[plan.scene.layers[l].dataset].field();
    for (std::size_t i = 0; i < keys_.size(); ++i)
      if (keys_[i].isovalue && !field.range.contains(*keys_[i].isovalue))
        throw Error(ErrorCode::invalid, concat(keys_place(scene_spec_).at(i).at("isovalue").text(), ": isovalue ",
                                               *keys_[i].isovalue, " is outside the range ", field.range.lo, " to ",
                                               field.range.hi, " of field '", field.name, "'"));
  }
}

void Sweep::set_isovalue(double isovalue, ResolvedScene& plan) const {
  for (std::size_t l = 0; l < plan.scene.layers.size(); ++l)
    if (plan.origins[l].spec == isovalue_layer_) plan.scene.layers[l].isovalue = isovalue;
}

/// Finds what is shown at the keys, and the camera distance of all frames of a camera given by
/// angles.
void Sweep::find_reach(ResolvedScene& plan) {
  shown_ = Shown();
  const auto add = [&](const Shown& shown) {
    shown_->box.extendBy(shown.box);
    shown_->corners.insert(shown_->corners.end(), shown.corners.begin(), shown.corners.end());
  };
  if (isovalue_.is_empty())
    add(what_is_shown(plan));
  else
    for (const KeyframeSpec& key : keys_) {
      set_isovalue(isovalue_.at(key.time), plan);
      add(what_is_shown(plan));
    }
  constexpr int most_looked_at = 720;  // a full turn by half degrees
  const int step = 1 + frame_count_ / most_looked_at;
  for (int frame = 0; frame < frame_count_; frame += step) {
    SceneSpec scene_spec = spec_at(time_of(frame));
    scene_spec.camera.zoom = 1;
    take_height(scene_spec.camera);
    place_camera(
        scene_spec, [&]() -> const Shown& { return *shown_; }, shown_->box.center(), plan);
    const Camera& camera = plan.scene.camera;
    distance_ = std::max(distance_, (camera.position - camera.target).length());
    orthographic_height_ = std::max(orthographic_height_, camera.orthographic_height);
  }
}

void Sweep::plan_frame(int frame, ResolvedScene& plan) {
  const double time = time_of(frame);
  if (!shown_) {
    if (!isovalue_.is_empty()) check_isovalues(plan);
    find_reach(plan);
  }
  SceneSpec scene_spec = spec_at(time);
  if (!isovalue_.is_empty()) set_isovalue(isovalue_.at(time), plan);
  const FindShown find_shown = [&]() -> const Shown& { return *shown_; };
  const CameraSpec& camera = scene_spec.camera;
  if (!camera.position && !camera.target && !camera.up) place_around(scene_spec, plan);
  aim_camera(scene_spec, find_shown, plan);
}

/// Gives a camera of angles its position: the direction and the free sides of one that is fitted to
/// this frame, at the distance of all frames.
void Sweep::place_around(SceneSpec& scene_spec, ResolvedScene& plan) const {
  CameraSpec& said = scene_spec.camera;
  const std::optional<double> height = take_height(said), zoom = said.zoom;
  said.zoom = zoom.value_or(default_zoom(plan));
  const Vec3 middle = shown_->box.center();
  place_camera(
      scene_spec, [&]() -> const Shown& { return *shown_; }, middle, plan);
  const Camera& fitted = plan.scene.camera;
  const Vec3 to_eye = fitted.position - fitted.target;
  // The middle is beside the target by a share of the picture's width there.
  double scale = distance_ / to_eye.length();
  if (fitted.orthographic) {
    said.orthographic_height = height.value_or(orthographic_height_ / *said.zoom);
    scale = *said.orthographic_height / fitted.orthographic_height;
    said.zoom = height ? zoom : std::nullopt;
  }
  said.target = middle + (fitted.target - middle) * scale;
  said.position = *said.target + to_eye.normalized() * distance_;
  said.up = fitted.up;
}

std::optional<std::filesystem::path> numbered(const std::filesystem::path& pattern, int number) {
  const std::string name = pattern.filename().string();
  const std::size_t at = name.find('%');
  if (at == name.npos || name.find('%', at + 1) != name.npos) return std::nullopt;
  std::size_t end = at + 1;
  const bool has_zeros = end < name.size() && name[end] == '0';
  while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
  const std::string width = name.substr(at + 1, end - at - 1);
  if (end >= name.size() || name[end] != 'd' || width.size() > 2 || (!width.empty() && !has_zeros)) return std::nullopt;
  std::string digits = concat(number);
  const std::size_t wanted = width.empty() ? 0 : static_cast<std::size_t>(std::stoi(width));
  if (digits.size() < wanted) digits.insert(0, wanted - digits.size(), '0');
  return pattern.parent_path() / (name.substr(0, at) + digits + name.substr(end + 1));
}

}  // namespace rhoray::render
