#pragma once

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// NanoVDB's ZeroCrossing with every voxel active. For an isovalue, only the difference to it is
/// prepared.
PeerPointer nanovdb_dense();
/// NanoVDB's ZeroCrossing over the leaves that the isosurface can pass through; the others are
/// tiles, which it skips.
PeerPointer nanovdb_narrow();
/// OpenVDB's LevelSetRayIntersector on a level set that levelSetRebuild makes of the isosurface, 3
/// voxels either side.
PeerPointer openvdb_level_set();

}  // namespace rhoray::study
