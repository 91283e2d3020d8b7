#pragma once

namespace rhoray::preprocess {

/// Programs of their own, and the commands that the verbs send to them. Each sends back a packed
/// file (messages.h, counts.h).

///     volume PATH FIELD TIME [NX NY NZ TYPE BIG_ENDIAN SKIPPED_BYTES]
///         sends a neutral volume; TIME may be empty; `colors` likewise
///     cells PATH TIME
///         sends a cell mesh; TIME may be empty
///     surface PATH SIZES
///         sends a neutral surface; SIZES may be empty
///     write-vtu PATH
///         receives a neutral mesh and sends what it reads again
///     write-stl PACKED FIELD ISOVALUE PATH
///         writes the isosurface of a packed grid; sends the numbers of
///         triangles written and left out (export/stl_file.h)
inline constexpr const char* import_worker = "rhoray-import-worker";

/// Accepts only `volume` and `colors`, for pictures.
inline constexpr const char* slices_worker = "rhoray-slices-worker";

///     info PATH
///         sends what is known of each grid (workers/vdb/facts.h)
///     nanovdb PATH FIELD
///         sends a grid for rendering (formats/vdb_grid.h)
///     volume PATH FIELD TIME
///         sends a neutral volume; TIME is empty
///     write PACKED FIELD OUTPUT KIND
///         writes a packed grid as KIND, .vdb or .nvdb, and reads it again; sends the file's size
inline constexpr const char* vdb_worker = "rhoray-vdb-worker";

}  // namespace rhoray::preprocess
