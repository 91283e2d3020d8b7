#pragma once

#include "tools/lab/peers/peer.h"

namespace rhoray::study {

/// NanoVDB's ZeroCrossing with every voxel active: nothing is prepared for an isovalue but the difference to it.
PeerPointer nanovdb_dense();
/// The same over the leaves that the isosurface can pass through; the others are tiles, which it leaps over.
PeerPointer nanovdb_narrow();
/// OpenVDB's LevelSetRayIntersector on a level set that levelSetRebuild makes of the isosurface, 3 voxels either side.
PeerPointer openvdb_level_set();

}  // namespace rhoray::study
