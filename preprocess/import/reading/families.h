#pragma once

#include <filesystem>
#include <string>

#include "preprocess/import_volume.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// One function per family of foreign formats; importers.cpp maps extensions to them. All refuse
/// with file, location, found and expected.

NeutralVolume read_nrrd(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_metaimage(const std::filesystem::path& path, const std::string& field);
/// @param time  time step, as in ImportVolumeOptions
NeutralVolume read_nifti(const std::filesystem::path& path, const std::string& field, const std::string& time);
NeutralVolume read_matlab(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_npy(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_npz(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_vti(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_vtr(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_pvti(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_pvtr(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_slc(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_gaussian_cube(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_bov(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_dicom(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_legacy_vtk_volume(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_vtkhdf_volume(const std::filesystem::path& path, const std::string& field);
/// @param time  time step, as in ImportVolumeOptions
NeutralVolume read_xdmf_volume(const std::filesystem::path& path, const std::string& field, const std::string& time);
NeutralVolume read_raw(const std::filesystem::path& path, const RawVolume& raw);

// Colours (VolumeRequest::colors).
NeutralVolume read_nrrd_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_metaimage_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_nifti_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_npy_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_npz_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_vti_colors(const std::filesystem::path& path, const std::string& field);
NeutralVolume read_pvti_colors(const std::filesystem::path& path, const std::string& field);

CellMesh read_vtu(const std::filesystem::path& path);
CellMesh read_pvtu(const std::filesystem::path& path);
CellMesh read_vts(const std::filesystem::path& path);
CellMesh read_pvts(const std::filesystem::path& path);
CellMesh read_vtkhdf_mesh(const std::filesystem::path& path);
CellMesh read_carp(const std::filesystem::path& path);
CellMesh read_plot3d(const std::filesystem::path& path);
CellMesh read_legacy_vtk_mesh(const std::filesystem::path& path);
CellMesh read_tetgen_mesh(const std::filesystem::path& path);
CellMesh read_netgen(const std::filesystem::path& path);
CellMesh read_medit(const std::filesystem::path& path);

/// @param time  time step, as in ImportMeshOptions
CellMesh read_exodus(const std::filesystem::path& path, const std::string& time);
CellMesh read_gmsh(const std::filesystem::path& path, const std::string& time);
CellMesh read_xdmf_mesh(const std::filesystem::path& path, const std::string& time);

NeutralSurface read_legacy_vtk_surface(const std::filesystem::path& path);
NeutralSurface read_ply(const std::filesystem::path& path);
NeutralSurface read_stl(const std::filesystem::path& path);
NeutralSurface read_obj(const std::filesystem::path& path);
NeutralSurface read_off(const std::filesystem::path& path);
NeutralSurface read_brainvisa(const std::filesystem::path& path);
NeutralSurface read_tetgen_surface(const std::filesystem::path& path);
NeutralSurface read_tetgen_faces(const std::filesystem::path& path);

/// Requested edge lengths, one per point, from a TetGen .mtr file.
Array<double> read_tetgen_sizes(const std::filesystem::path& path, std::size_t point_count);

/// Writes VTU: appended, compressed, points in double precision. Not atomic: a failure may leave an
/// incomplete file at `path`.
void write_vtu(const NeutralMesh& mesh, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
