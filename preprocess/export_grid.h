#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/progress.h"

namespace rhoray::preprocess {

struct ExportOptions {
  std::string field{};  ///< name; empty = the first, or all where the format holds several
  bool replace_existing = false;
  std::uint64_t memory_limit_bytes = 0;  ///< of the process that writes; 0 = none
};

struct ExportReport {
  std::uint64_t file_bytes = 0;
  std::uint64_t triangle_count = 0;  ///< of an STL file
  std::vector<std::string> notes;    ///< what the format cannot say as it was, one sentence each
};

// Packed grids in the words of others. A file gets its name only when it is whole; a field that the grid does not have
// is refused (ErrorCode::usage).

/// OpenVDB (.vdb) or NanoVDB (.nvdb), by the extension of `output`: sample (i, j, k) is voxel (i, j, k), samples
/// without data are not active. Floats and integers of at most 16 bits become a grid of floats, others one of doubles.
/// Written by a process of its own, which reads the file again and compares every sample.
ExportReport export_vdb(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {});

/// VTK image data (.vti), appended: one point array of the grid's type for each field; spacing, origin and direction as
/// they are.
ExportReport export_vti(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {}, const Progress& progress = {});

/// NumPy (.npy, version 1.0): the samples of one field in shape [z, y, x], little-endian, of the grid's type.
ExportReport export_npy(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {}, const Progress& progress = {});

/// The isosurface as triangles in world axes (binary .stl): inside each cell the polygons of marching cubes
/// (vtkFlyingEdges3D), with vertices where the field takes the isovalue on edges of the grid; none in cells without
/// data. Seen from lower values the corners run counter-clockwise.
ExportReport export_grid_stl(const std::filesystem::path& packed, double isovalue, const std::filesystem::path& output,
                             const ExportOptions& options = {});

}  // namespace rhoray::preprocess
