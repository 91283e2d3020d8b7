#pragma once

#include "formats/packed_file.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Sends neutral volumes, cells, meshes and surfaces between two processes as packed files of kinds
/// "neutral-volume", "neutral-cells", "neutral-mesh" and "neutral-surface". Reading trusts the
/// other side no more than a file: shapes, kinds and counts are checked.

void send(const NeutralVolume& volume, int descriptor);
void send(const CellMesh& mesh, int descriptor);
void send(const NeutralMesh& mesh, int descriptor);
void send(const NeutralSurface& surface, int descriptor);

/// From the caller of a worker: samples may be in any file that the caller names. They stay in the
/// file's mapping.
NeutralVolume receive_volume(const formats::PackedFile& file);

/// From a worker that was told to read `source`: samples may stay in that file, or in a file that
/// its text names, relative to its folder or by an absolute path. Samples in any other file are
/// refused (ErrorCode::internal). A reader that a hostile file has taken over therefore cannot have
/// other files packed.
NeutralVolume receive_volume(const formats::PackedFile& file, const std::filesystem::path& source);

CellMesh receive_cell_mesh(const formats::PackedFile& file);
NeutralMesh receive_mesh(const formats::PackedFile& file);
NeutralSurface receive_surface(const formats::PackedFile& file);

}  // namespace rhoray::preprocess
