#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/base/progress.h"

namespace rhoray::preprocess {

struct ExportOptions {
  std::string field{};  ///< name; empty = the first, or all where the format holds several
  bool replace_existing = false;
  std::uint64_t memory_limit_bytes = 0;  ///< of the writing process; 0 = none
  std::string source_name{};             ///< of the packed file in messages; empty: its path
};

struct ExportReport {
  std::uint64_t file_bytes = 0;
  std::uint64_t triangle_count = 0;  ///< of an STL file
  std::vector<std::string> notes;    ///< what the format cannot represent, one sentence each
};

// Export of packed grids to other formats. A file gets its name only when it is complete. A field
// that the grid does not have is refused (ErrorCode::usage).

/// Writes OpenVDB (.vdb) or NanoVDB (.nvdb), by the extension of `output`. Sample (i, j, k) becomes
/// voxel (i, j, k); samples without data are inactive. Floats and integers of at most 16 bits
/// become a grid of floats, other types a grid of doubles. A separate process writes the file,
/// reads it again and compares every sample.
ExportReport export_vdb(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {});

/// Writes VTK image data (.vti, appended): one point array of the grid's type for each field.
/// Spacing, origin and direction are unchanged.
ExportReport export_vti(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {}, const Progress& progress = {});

/// Writes NumPy (.npy, version 1.0): the samples of one field in shape [z, y, x], little-endian, in
/// the grid's type.
ExportReport export_npy(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options = {}, const Progress& progress = {});

/// Writes NIfTI-1 (.nii, little-endian): the samples of one field in the grid's type. The sform
/// holds the geometry in RAS, rounded to single precision. Refuses a geometry that single precision
/// cannot hold (ErrorCode::unsupported).
ExportReport export_nifti(const std::filesystem::path& packed, const std::filesystem::path& output,
                          const ExportOptions& options = {}, const Progress& progress = {});

/// Writes the isosurface as triangles in world axes (binary .stl). Inside each cell these are the
/// polygons of marching cubes (vtkFlyingEdges3D). Vertices lie on edges of the grid, where the
/// field takes the isovalue. Cells without data have no triangles. Seen from lower values, the
/// corners run counter-clockwise. Refuses a surface that single precision cannot hold
/// (ErrorCode::unsupported).
ExportReport export_grid_stl(const std::filesystem::path& packed, double isovalue, const std::filesystem::path& output,
                             const ExportOptions& options = {});

}  // namespace rhoray::preprocess
