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
    quantized,     ///< of a grid: whole numbers of `size` bits, evenly over the field's range
    resampled,     ///< of a mesh: a grid of `size` samples on the longest axis
    resampled_vdb  ///< the same as OpenVDB
  };
  Kind kind = Kind::original;
  int size = 0;

  friend bool operator==(const DataForm&, const DataForm&) = default;
};
std::string text_of(const DataForm& form);  ///< "original", "8 bits", "grid 128", "OpenVDB 128"

/// One way to draw the same picture: a row of the results.
struct Variant {
  std::string group{};                     ///< variants that are one curve, or one question
  std::string name{};                      ///< its own among all of a layer
  std::optional<render::Method> method{};  ///< nothing: the default of the data that it is drawn from
  DataForm data{};
  std::optional<render::Normals> normals{};  ///< instead of the layer's
  int occlusion_samples = 0;                 ///< instead of the scene's; 0: the scene's
  int shrink = 1;                            ///< so many times fewer pixels on a side, enlarged to the picture
  bool has_picture = false;                  ///< is shown in the report

  bool asks_rays() const { return shrink == 1 && occlusion_samples == 0 && !normals; }  ///< can differ in where it hits
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
inline constexpr const char* group_size = "picture size";

/// How many rays a hit the picture is drawn with that occlusion_samples are compared with.
inline constexpr int most_occlusion_samples = 1024;

/// Every variant that applies to a scene of one layer; the first are the levels. Adding a method is a row of a table.
std::vector<Variant> variants_of(const render::Scene& scene, const render::Volume& volume);

}  // namespace rhoray::tools
