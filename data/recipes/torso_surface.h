#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/recipes/triangulate_star.h"
#include "preprocess/neutral.h"

namespace rhoray::recipes {

/// Regions of the torso, stored in the cell field "region" after tetrahedralizing.
enum class Tissue { torso = 1, heart = 2, lungs = 3 };

struct TorsoSurface {
  struct Part {
    std::string name;  ///< "skin", "heart", "left_lung", "right_lung"
    Triangulation triangulation;
  };
  std::vector<Part> parts;
  preprocess::NeutralSurface surface;  ///< all parts, with seeds and requested sizes
};

/// Requested edge length at a point: `finest` in the heart, growing with the distance from it.
double wanted_size(const Vec3& p, double finest);

/// Makes skin, heart and lungs as closed triangle surfaces that do not touch. TetGen with quality
/// 1.4 makes `cell_count` tetrahedra from them, within a quarter, for 5,000 to 4,000,000. Refuses
/// counts below 4,500 and above 20 million.
TorsoSurface make_torso_surface(std::uint64_t cell_count);

/// Writes NAME.smesh and NAME.mtr and, if requested, NAME_skin.ply and the other parts.
void write_torso_surface(const TorsoSurface& torso, const std::filesystem::path& path, bool each_as_ply,
                         bool replace_existing);

}  // namespace rhoray::recipes
