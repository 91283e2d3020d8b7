#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "formats/base/vector.h"
#include "render/document/resolve.h"
#include "render/scene_spec.h"

namespace rhoray::render {

/// A number or a point that key frames name at some times. Before the first time and after the last
/// it stays.
///
/// Between them a number follows the monotone cubic through all of them (F. Fritsch and R. Carlson,
/// SIAM J. Numer. Anal. 17, 1980): exact at the keys, without a jump of its rate, and never beyond
/// the two numbers that it lies between. A point follows a cubic through all of them whose
/// direction at each is that from the key before to the key after (Catmull and Rom, with the keys'
/// own times).
template <class T>
class Track {
 public:
  void add(double time, const T& value) { times_.push_back(time), values_.push_back(value); }  ///< times rise
  bool is_empty() const { return times_.empty(); }
  T at(double time) const;

 private:
  std::vector<double> times_;
  std::vector<T> values_;
};
extern template class Track<double>;
extern template class Track<Vec3>;

/// A camera, and perhaps an isovalue, that move from key frame to key frame; frames lie at even
/// times from the first key to the last. What no key names stays as the document says.
///
/// A camera of angles goes round the middle of what is shown at one distance, the nearest at which
/// every frame fits it at zoom 1, beside colour bar and legend (fit_camera). One of places is where
/// they say. Zoom and the height of an orthographic picture follow their logarithms.
class Sweep {
 public:
  /// Refuses fewer than 2 keys, times that do not rise, angles and places side by side, fields of
  /// view and orthographic heights side by side, and an isovalue where there is not one isosurface
  /// alone (ErrorCode::invalid, with the place); frames without keys.
  explicit Sweep(const SceneSpec& scene_spec);

  int frame_count() const { return frame_count_; }
  double time_of(int frame) const;

  /// The requested scene of one frame alone.
  SceneSpec spec_at(double time) const;

  /// Makes a plan of spec_at any time that of a frame: its isovalue, its camera, and what depends
  /// on it. Refuses isovalues of keys that lie outside their field's range.
  void plan_frame(int frame, ResolvedScene& plan);

 private:
  void check_keys() const;
  void check_isovalues(const ResolvedScene& plan) const;
  void set_isovalue(double isovalue, ResolvedScene& plan) const;
  void find_reach(ResolvedScene& plan);
  void place_around(SceneSpec& scene_spec, ResolvedScene& plan) const;

  SceneSpec scene_spec_;
  std::vector<KeyframeSpec> keys_;
  int frame_count_;
  std::size_t isovalue_layer_ = 0;  ///< index into SceneSpec::layers
  Track<double> azimuth_, elevation_, fov_, isovalue_;
  Track<double> log_zoom_, log_height_;
  Track<Vec3> position_, target_, up_;
  std::optional<Shown> shown_;                     ///< at any of the keys
  double distance_ = 0, orthographic_height_ = 0;  ///< of a camera of angles, at zoom 1
};

/// The name of a numbered picture: %d, or %04d with as many zeros, becomes the number. Nothing
/// where there is no such place, or another percent sign.
std::optional<std::filesystem::path> numbered(const std::filesystem::path& pattern, int number);

}  // namespace rhoray::render
