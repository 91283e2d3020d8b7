#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/interval.h"
#include "formats/base/vector.h"
#include "preprocess/neutral.h"
#include "render/camera.h"

namespace rhoray::study {

/// The input of every system.
struct PeerData {
  const preprocess::NeutralVolume* grid = nullptr;  ///< plain samples (plain_grid.h)
  const preprocess::NeutralMesh* mesh = nullptr;    ///< or tetrahedra with one field
  Box3 bounds;                                      ///< in the world, as the cameras see it
  Interval<double> range;                           ///< of the values
  /// The same data, packed by `rhoray pack` without options
  std::filesystem::path packed_file;
  std::string field;  ///< the field of that file; empty: the first
};

struct PeerView {
  render::Camera camera;
  int width = 0, height = 0;

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// CPU milliseconds that a system needs before its first picture.
struct Preparation {
  double once_ms = 0;        ///< for every data set
  double extraction_ms = 0;  ///< for every isovalue: making triangles
  double build_ms = 0;       ///< for every isovalue: what is then traced or drawn
};

/// One system that shows an isosurface, or the largest values along rays, on one thread.
class Peer {
 public:
  virtual ~Peer() = default;

  virtual std::string name() const = 0;
  virtual std::string does() const = 0;  ///< in a few words

  /// Called once for every isovalue; for largest values once, with any isovalue.
  virtual Preparation prepare(const PeerData& data, double isovalue) = 0;

  /// Makes the rays of the view and a shaded picture. This is timed.
  virtual void draw(const PeerView& view) = 0;

  /// The answers for the pixels of the view, rows from the top. For an isosurface, the distance
  /// along the ray (infinity: nothing; NaN: a hit at an unknown distance). For largest values, the
  /// value (NaN: no data). Not timed.
  virtual std::vector<double> answers(const PeerView& view) = 0;

  /// Megabytes of the prepared data, as the library counts them; nothing where it does not count
  /// them.
  virtual std::optional<double> prepared_mb() const { return std::nullopt; }

  /// Hash of the last picture, if the same program always makes the same one; otherwise empty.
  virtual std::string picture_hash() const { return {}; }
};
using PeerPointer = std::unique_ptr<Peer>;

/// CPU milliseconds that act() takes, on all threads of this process.
double cpu_ms_of(const std::function<void()>& act);

}  // namespace rhoray::study
