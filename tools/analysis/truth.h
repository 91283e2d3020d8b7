#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/ray_caster.h"
#include "render/scene.h"
#include "render/scene_spec.h"
#include "tools/analysis/border.h"
#include "tools/analysis/errors.h"
#include "tools/analysis/field_truth.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

/// A query on a volume, and its resources.
struct Asking {
  const render::Dataset& dataset;
  render::Mode mode = render::Mode::isosurface;
  double isovalue = 0;
  render::Method method{};
  const render::Clip* clip = nullptr;  ///< the region of the scene; null: no clipping
  unsigned threads = 0;                ///< 0: all cores
  std::stop_token stop{};
};

/// The clip region that a scene applies to a layer; null: none.
const render::Clip* clip_of(const render::Scene& scene, const render::Layer& layer);

/// Traces rays in the data's frame with a method. An interrupt ends it (ErrorCode::interrupted).
std::vector<render::Hit> answers(const Asking& asking, std::span<const render::Ray> rays);

/// The rays of some pixels of a picture, in the data's frame; t is a distance in the world.
std::vector<render::Ray> rays_of(const render::Dataset& dataset, const render::Camera& camera,
                                 const render::PictureSize& size, std::span<const std::uint32_t> pixels);

/// The true hits of a picture's pixels, computed in exact arithmetic.
struct Truth {
  render::PictureSize size;
  /// Examined pixels in ascending order: all, or a random sample.
  std::vector<std::uint32_t> pixels{};
  std::vector<render::Ray> rays{};  ///< of these pixels
  std::vector<render::Hit> hits{};
  std::vector<double> cells_per_t{};  ///< for pixels that are hit, else 0
  double cpu_s = 0;                   ///< of the exact computation

  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  }
  bool are_all() const { return pixels.size() == pixel_count(); }
  std::uint64_t hit_count() const;
};

struct TruthSpec {
  const render::Dataset& dataset;
  const render::Scene& scene;  ///< of one layer
  const FieldTruth& field;
  render::PictureSize size;
  std::uint64_t seed = 1;
  double seconds = 0;  ///< pixels are taken in random order until this time is over
  std::uint64_t most_pixels = 1'000'000;
  unsigned threads = 0;
  std::stop_token stop{};
};
Truth find_truth(const TruthSpec& spec);

/// Compares a variant's hits on the truth's rays with the true ones.
/// @param hits    values in the truth's unit
/// @param border  between a mesh and the grid that was traced instead; null: there is none
ErrorList errors_against(const Truth& truth, const FieldTruth& field, const render::Layer& layer,
                         std::span<const render::Hit> hits, const ResampledBorder* border = nullptr);

}  // namespace rhoray::tools
