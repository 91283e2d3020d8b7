#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::tools {

/// The data that a variant is rendered from: the original, or a copy made for the study.
struct DataForm {
  enum class Kind {
    original,
    /// Values rounded to 2^`size` steps, evenly over the field's range; whole numbers in a grid.
    quantized,
    resampled,     ///< for a mesh: a grid with `size` samples on the longest axis
    resampled_vdb  ///< the same as OpenVDB
  };
  Kind kind = Kind::original;
  int size = 0;

  friend bool operator==(const DataForm&, const DataForm&) = default;
};
std::string text_of(const DataForm& form);  ///< "original", "8 bits", "grid 128", "OpenVDB 128"

/// Effects that are computed from a number of samples.
enum class SampledEffect {
  none,
  occlusion,     ///< rays from a hit into its surroundings
  soft_shadows,  ///< rays from a hit towards an area light
  edges          ///< rays through an edge pixel (antialiasing)
};

/// One way to render the same picture: a row of the results.
struct Variant {
  std::string group{};  ///< variants that form one curve, or answer one question
  std::string name{};   ///< unique among all variants of a layer
  /// Nothing: the default for the data that it is rendered from.
  std::optional<render::Method> method{};
  DataForm data{};
  std::optional<render::Normals> normals{};  ///< instead of the layer's
  SampledEffect effect = SampledEffect::none;
  int samples = 0;  ///< of that effect, instead of the scene's
  /// factor by which the picture's sides are reduced; enlarged again afterwards
  int shrink = 1;
  bool has_picture = false;  ///< shown in the report

  /// True if hits may differ.
  bool asks_rays() const { return shrink == 1 && effect == SampledEffect::none && !normals; }
};

// Names of groups that reports use.
inline constexpr const char* group_levels = "level";
inline constexpr const char* group_published = "published methods";
inline constexpr const char* group_linear = "sampled, linear";
inline constexpr const char* group_bisect = "sampled, bisection";
inline constexpr const char* group_samples = "sampled";
inline constexpr const char* group_bits = "fewer bits";
inline constexpr const char* group_grids = "resampled to a grid";
inline constexpr const char* group_vdb = "resampled to OpenVDB";
inline constexpr const char* group_normals = "normals";
inline constexpr const char* group_occlusion = "occlusion samples";
inline constexpr const char* group_shadows = "soft shadow samples";
inline constexpr const char* group_edges = "samples at edges";
inline constexpr const char* group_size = "picture size";

/// Number of samples of the picture that an effect's other variants are compared with.
int most_samples(SampledEffect effect);

/// True for a light whose shadows have soft edges.
bool is_soft(const render::Light& light);

/// Returns every variant that applies to a scene of one layer; the levels come first. To add a
/// method, add a row to a table.
/// @param antialiasing  as in render::FrameOptions
std::vector<Variant> variants_of(const render::Scene& scene, const render::Dataset& dataset, int antialiasing);

}  // namespace rhoray::tools
