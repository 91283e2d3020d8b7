#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/ray_caster.h"
#include "render/scene.h"
#include "tools/analysis/border.h"
#include "tools/analysis/errors.h"
#include "tools/analysis/field_truth.h"
#include "tools/rhoray/option_values.h"

namespace rhoray::tools {

/// One question about a volume, and who works on it.
struct Asking {
  const render::Volume& volume;
  render::Mode mode = render::Mode::isosurface;
  double isovalue = 0;
  render::Method method{};
  const render::Clip* clip = nullptr;  ///< what the scene leaves of the volume; null: all
  unsigned threads = 0;                ///< 0 = all cores
  std::stop_token stop{};
};

/// What a scene leaves of a layer; null: all.
const render::Clip* clip_of(const render::Scene& scene, const render::Layer& layer);

/// What a method says of rays in the volume's frame. An interrupt ends it (ErrorCode::interrupted).
std::vector<render::Hit> answers(const Asking& asking, std::span<const render::Ray> rays);

/// The rays of some pixels of a picture, in the volume's frame; t is a distance in the world.
std::vector<render::Ray> rays_of(const render::Volume& volume, const render::Camera& camera, const PictureSize& size,
                                 std::span<const std::uint32_t> pixels);

/// What is true of the pixels of a picture, by the exact judge.
struct Truth {
  PictureSize size;
  std::vector<std::uint32_t> pixels{};  ///< that were looked at, rising; all, or a random sample
  std::vector<render::Ray> rays{};      ///< of these pixels
  std::vector<render::Hit> hits{};
  std::vector<double> cells_per_t{};  ///< of pixels that are hit, else 0
  double cpu_s = 0;                   ///< that the judge took

  std::uint64_t pixel_count() const {
    return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  }
  bool are_all() const { return pixels.size() == pixel_count(); }
  std::uint64_t hit_count() const;
};

struct TruthSpec {
  const render::Volume& volume;
  const render::Scene& scene;  ///< of one layer
  const FieldTruth& field;
  PictureSize size;
  std::uint64_t seed = 1;
  double seconds = 0;  ///< pixels are taken in random order until this time is over
  std::uint64_t most_pixels = 1'000'000;
  unsigned threads = 0;
  std::stop_token stop{};
};
Truth find_truth(const TruthSpec& spec);

/// What a variant said of the truth's rays against what is true.
/// @param hits    values in the truth's unit
/// @param border  of a mesh and the grid that was asked instead; null: there is none
ErrorList errors_against(const Truth& truth, const FieldTruth& field, const render::Layer& layer,
                         std::span<const render::Hit> hits, const ResampledBorder* border = nullptr);

}  // namespace rhoray::tools
