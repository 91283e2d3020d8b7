#pragma once

#include "render/tets/tet_volume.h"

namespace rhoray::render::wide {

/// True for views that are meshes of tetrahedra.
template <class View>
inline constexpr bool is_mesh = false;
template <class T>
inline constexpr bool is_mesh<TetVolume<T>> = true;

}  // namespace rhoray::render::wide
