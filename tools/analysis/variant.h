#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/load.h"
#include "render/scene.h"

namespace rhoray::tools {

/// What a variant is drawn from: the data as they are, or a copy made for the study.
struct DataForm {
  enum class Kind {
    original,
    quantized,     ///< values rounded to 2^`size` steps, evenly over the field's range; of a grid whole numbers
    resampled,     ///< of a mesh: a grid of `size` samples on the longest axis
    resampled_vdb  ///< the same as OpenVDB
  };
  Kind kind = Kind::original;
  int size = 0;

  friend bool operator==(const DataForm&, const DataForm&) = default;
};
std::string text_of(const DataForm& form);  ///< "original", "8 bits", "grid 128", "OpenVDB 128"

/// What is found out by a number of samples.
enum class SampledEffect {
  none,
  occlusion,     ///< rays of a hit into its surroundings
  soft_shadows,  ///< rays of a hit towards a light that has a size
  edges          ///< rays through a pixel at an edge (antialiasing)
};

/// One way to draw the same picture: a row of the results.
struct Variant {
  std::string group{};                     ///< variants that are one curve, or one question
  std::string name{};                      ///< its own among all of a layer
  std::optional<render::Method> method{};  ///< nothing: the default of the data that it is drawn from
  DataForm data{};
  std::optional<render::Normals> normals{};  ///< instead of the layer's
  SampledEffect effect = SampledEffect::none;
  int samples = 0;           ///< of that effect, instead of the scene's
  int shrink = 1;            ///< so many times fewer pixels on a side, enlarged to the picture
  bool has_picture = false;  ///< is shown in the report

  /// Can differ in where it hits.
  bool asks_rays() const { return shrink == 1 && effect == SampledEffect::none && !normals; }
};

// Names of groups that reports look for.
inline constexpr const char* group_levels = "level";
inline constexpr const char* group_published = "published";
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

/// How many samples the picture is drawn with that others of an effect are compared with.
int most_samples(SampledEffect effect);

/// True of a light whose shadows have soft edges.
bool is_soft(const render::Light& light);

/// Every variant that applies to a scene of one layer; the first are the levels. Adding a method is a row of a table.
/// @param antialiasing  as in render::FrameOptions
std::vector<Variant> variants_of(const render::Scene& scene, const render::Volume& volume, int antialiasing);

}  // namespace rhoray::tools
