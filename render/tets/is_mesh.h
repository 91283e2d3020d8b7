#pragma once

#include "render/tets/tet_data.h"

namespace rhoray::render::wide {

/// True for views that are meshes of tetrahedra.
template <class View>
inline constexpr bool is_mesh = false;
template <class T>
inline constexpr bool is_mesh<TetData<T>> = true;

}  // namespace rhoray::render::wide
