#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "formats/base/progress.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "render/ray_caster.h"
#include "render/scene.h"
#include "render/scene_spec.h"

/// The true hits of a picture, and errors against them, for tools that measure how accurate a
/// method is.
namespace rhoray::render {

struct Quantiles {
  double median = 0, p99 = 0, largest = 0;
};
/// Quantiles of the finite values; nothing if there are none.
std::optional<Quantiles> quantiles_of(std::vector<double> values);

/// A share of the examined pixels, with the 95 % confidence interval of the share of all pixels
/// (Wilson's interval). If all pixels were examined, the three numbers are equal.
struct Share {
  double found = 0, low = 0, high = 0;
};
Share share_of(std::uint64_t count, std::uint64_t looked_at, bool are_all);

// Values of ErrorList::errors for rays without a numeric error.
inline constexpr float nothing_there = std::numeric_limits<float>::quiet_NaN();  ///< true miss
inline constexpr float is_missed = std::numeric_limits<float>::infinity();
inline constexpr float is_false = -std::numeric_limits<float>::infinity();

/// Errors of a variant, ray by ray, or one of the three values above. For an isosurface they are in
/// cells along the ray, for a largest value in the field's unit.
struct ErrorList {
  std::vector<float> errors;
  std::vector<double> value_errors;  ///< in the field's unit, for rays that hit and should
  /// For copies of a mesh as a grid, ray by ray: 1 where the border between the two causes the
  /// error, not the samples. Empty where there is no such border.
  std::vector<std::uint8_t> is_border{};
};

/// Statistics of these errors.
struct ErrorCounts {
  std::uint64_t rays = 0, true_hits = 0, missed = 0, false_hits = 0;
  std::optional<Quantiles> error{};  ///< for rays that hit and should, except those at a border
  std::optional<Quantiles> value_error{};

  /// Share of the rays that hit or should hit and have at most this error. Missed and false rays
  /// exceed every limit.
  double within(double limit) const;
  std::uint64_t beyond(double limit) const;  ///< number of the other rays
  /// The error that this share of the rays does not exceed; infinity where too many are missed or
  /// false.
  double kept_by(double share) const;
  std::vector<float> sorted{};  ///< errors of rays that hit and should

  /// Errors caused by the border of a resampled mesh: missed and false hits, and rays that hit and
  /// should.
  struct Border {
    std::uint64_t missed = 0, false_hits = 0, off = 0;

    friend bool operator==(const Border&, const Border&) = default;
  };
  std::optional<Border> border{};  ///< only if there is such a border
};
ErrorCounts count_errors(const ErrorList& list);

/// What rays are traced through, how, and with which resources.
struct TraceSpec {
  const Dataset& dataset;
  Mode mode = Mode::isosurface;
  double isovalue = 0;
  Method method{};
  const Clip* clip = nullptr;  ///< the region of the scene; null: no clipping
  unsigned threads = 0;        ///< 0: all cores
  Watch watch{};
  std::optional<Machine> machine{};  ///< none: chosen_machine()
};

/// The clip region that a scene applies to a layer; null: none.
const Clip* clip_of(const Scene& scene, const Layer& layer);

/// Traces rays in the data's frame with a method.
std::vector<Hit> trace_rays(const TraceSpec& spec, std::span<const Ray> rays);

/// The lengths of a dataset's cells along rays, to measure distances in cells.
class CellLengths {
 public:
  explicit CellLengths(const Dataset& dataset);

  /// Number of cells that a ray passes while t grows by 1, at a hit. For a grid these are its cells
  /// along the ray. For a mesh it is the reciprocal of the longest edge of the tetrahedron hit. For
  /// OpenVDB these are voxels.
  double cells_per_t(const Ray& ray, const Hit& hit) const;

 private:
  std::optional<formats::BrickGrid> grid_;
  std::optional<formats::TetMesh> mesh_;
};

/// The true hits of a picture's pixels, computed in exact arithmetic.
struct Truth {
  PictureSize size;
  /// Examined pixels in ascending order: all, or a random sample.
  std::vector<std::uint32_t> pixels{};
  std::vector<Ray> rays{};  ///< of these pixels
  std::vector<Hit> hits{};
  std::vector<double> cells_per_t{};  ///< for pixels that are hit, else 0
  double cpu_s = 0;                   ///< of the exact computation

  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  }
  bool are_all() const { return pixels.size() == pixel_count(); }
  std::uint64_t hit_count() const;
};

struct TruthSpec {
  const Dataset& dataset;
  const Scene& scene;  ///< of one layer
  PictureSize size;
  std::uint64_t seed = 1;
  double seconds = 0;  ///< pixels are taken in random order until this time is over
  std::uint64_t most_pixels = 1'000'000;
  unsigned threads = 0;
  Watch watch{};
};
Truth find_truth(const TruthSpec& spec);

/// Compares hits on the truth's rays with the true ones. For a largest value, value_errors are
/// errors; for an isosurface there are none.
/// @param hits  values in the truth's unit
ErrorList errors_against(const Truth& truth, Mode mode, std::span<const Hit> hits);

}  // namespace rhoray::render
