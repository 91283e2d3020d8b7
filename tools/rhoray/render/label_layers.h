#pragma once

#include "render/scene_spec.h"
#include "tools/rhoray/data_choice.h"

namespace rhoray::tools {

/// A scene in which every layer whose type is chosen by the kind of data, and whose data hold
/// labels, is replaced by a surface for each label: an isosurface in a grid, the boundary of the
/// label's cells in a mesh. There, labels that hide others are transparent. Layers that say an
/// isovalue, a method or a field for colours stay.
render::SceneSpec with_label_layers(render::SceneSpec scene_spec, const DataAccess& access);

}  // namespace rhoray::tools
