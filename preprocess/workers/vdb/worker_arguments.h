#pragma once

namespace rhoray::preprocess {

/// What the verbs say to the OpenVDB worker:
///
///     info PATH                        hands over what is known of each grid (grid_facts.h)
///     nanovdb PATH FIELD               hands over a grid for rendering (formats/vdb_grid.h)
///     volume PATH FIELD                hands over a neutral volume
///     write PACKED FIELD OUTPUT KIND   writes a packed grid as KIND, .vdb or .nvdb, and reads it again; hands over
///                                      the size of the file (export/counts.h)
inline constexpr const char* vdb_worker = "rhoray-vdb-worker";

}  // namespace rhoray::preprocess
