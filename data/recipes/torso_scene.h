#pragma once

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// A torso from hips to neck as formulas, in millimetres: x to the patient's left, y to the back, z
/// up (the front is -y).
///
/// Each function is negative inside its body, positive outside and zero on the surface. It grows at
/// least about as fast as the distance from the surface. Close to the surface, dividing it by the
/// length of its gradient gives the distance.
namespace torso {

double skin(const Vec3& p);
double heart(const Vec3& p);
double left_lung(const Vec3& p);
double right_lung(const Vec3& p);
double bone(const Vec3& p);      ///< spine, ribs, sternum, collar bones, hip bones
double rib_cage(const Vec3& p);  ///< the surface that the ribs lie on; a closed egg

inline constexpr Vec3 heart_centre{16, -24, 372};
inline constexpr Vec3 left_lung_centre{92, 10, 375};  ///< sees every point of its lung's surface
inline constexpr Vec3 right_lung_centre{-86, 12, 385};
inline constexpr Vec3 body_centre{0, 2, 330};  ///< sees every point of the skin
Vec3 heart_axis();                             ///< of length 1, from base to apex

/// Contains the skin and some air around it.
inline const Box3 frame{Vec3(-215, -150, -20), Vec3(215, 150, 660)};

}  // namespace torso

}  // namespace rhoray::recipes
