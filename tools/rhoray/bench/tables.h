#pragma once

#include <vector>

#include "tools/analysis/table.h"
#include "tools/rhoray/bench/parts.h"

namespace rhoray::tools {

// One table each. Repetitions are interleaved over the rows; every row is run once before it is
// timed. Times are medians, with smallest and largest beside them; rows with pictures carry the
// hash of the picture.

/// The paper's Table 1: share of traversal, intersection and shading, and frames per second.
Table phases_table(const BenchOptions& options, const Step& step);
/// The paper's Table 2: frames per second, speed-up and efficiency from 1 thread to all.
Table threads_table(const BenchOptions& options, const Step& step);
/// The paper's four views (views.h): rays per second and core cycles per ray.
Table views_table(const BenchOptions& options, const Step& step);
/// The first picture after a change of isovalue or view, and what the change takes before its first
/// pixel (change_ms, CPU milliseconds).
Table isovalue_table(const BenchOptions& options, const Step& step);
/// Memory of the process after frames of a scene, without the mapped file.
Table memory_table(const BenchOptions& options, const Step& step);
/// Opening a packed file, with and without reading its checksums. The page cache is warm.
Table open_table(const BenchOptions& options, const Step& step);
/// The viewer: the time from a client's request to its picture while the camera and the isovalue
/// are dragged, on this machine and over a slow line.
Table viewer_table(const BenchOptions& options, const Step& step);
/// Packing a volume or a mesh, compared with reading and writing the bytes once.
Table pack_table(const BenchOptions& options, const Step& step);

/// The cost of every effect, for a file or a scene document. Each effect that applies is switched
/// on alone over the plain picture of the same layers and camera, and timed just after it, round
/// after round. Then the paper's Tables 4 and 1, with its numbers beside ours. For a file, the
/// options about layers are those of the other tables. A document's layers define what is shown, so
/// these options are refused (ErrorCode::usage).
std::vector<Table> effects_tables(const BenchOptions& options, const Step& step);

}  // namespace rhoray::tools
