#pragma once

#include "formats/packed_file.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Neutral volumes, cells, meshes and surfaces as packed files of kinds "neutral-volume", "neutral-cells",
/// "neutral-mesh" and "neutral-surface", for the way between two processes. Reading trusts the other side no more than
/// a file: shapes, kinds and counts are checked.

void hand_over(const NeutralVolume& volume, int descriptor);
void hand_over(const CellMesh& mesh, int descriptor);
void hand_over(const NeutralMesh& mesh, int descriptor);
void hand_over(const NeutralSurface& surface, int descriptor);

NeutralVolume take_volume(const formats::PackedFile& file);  ///< samples stay in the file's mapping
CellMesh take_cell_mesh(const formats::PackedFile& file);
NeutralMesh take_mesh(const formats::PackedFile& file);
NeutralSurface take_surface(const formats::PackedFile& file);

}  // namespace rhoray::preprocess
