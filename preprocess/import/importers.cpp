#include <array>
#include <string_view>

#include "formats/base/error.h"
#include "preprocess/import/readers.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/time_steps.h"
#include "preprocess/input_file.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/subdivide.h"

namespace rhoray::preprocess {
namespace {

template <class Function>
struct Importer {
  std::string_view family;
  Function* read;
};

// One line per extension or kind of folder. foreign_kind.cpp has the same list for programs that
// only need the kind (a test compares the two).
constexpr Importer<NeutralVolume(const std::filesystem::path&, const std::string&)> volume_importers[] = {
    {".nrrd", read_nrrd},
    {".nhdr", read_nrrd},
    {".mhd", read_metaimage},
    {".mha", read_metaimage},
    {".mat", read_matlab},
    {".npy", read_npy},
    {".npz", read_npz},
    {".vti", read_vti},
    {".vtk", read_legacy_vtk_volume},
    {".vtr", read_vtr},
    {".pvti", read_pvti},
    {".pvtr", read_pvtr},
    {".vtkhdf", read_vtkhdf_volume},
    {".hdf", read_vtkhdf_volume},
    {".slc", read_slc},
    {".cube", read_gaussian_cube},
    {".bov", read_bov},
    {".dcm", read_dicom},
    {".ima", read_dicom},
    {".zip", read_dicom},
    {"dicom/", read_dicom},
};
constexpr Importer<NeutralVolume(const std::filesystem::path&, const std::string&)> color_importers[] = {
    {".nrrd", read_nrrd_colors},     {".nhdr", read_nrrd_colors}, {".mhd", read_metaimage_colors},
    {".mha", read_metaimage_colors}, {".nii", read_nifti_colors}, {".nii.gz", read_nifti_colors},
    {".npy", read_npy_colors},       {".npz", read_npz_colors},   {".vti", read_vti_colors},
    {".pvti", read_pvti_colors},
};
/// Formats that may hold several volumes, one for each time step.
constexpr Importer<NeutralVolume(const std::filesystem::path&, const std::string& field, const std::string& time)>
    volume_steps_importers[] = {
        {".nii", read_nifti},
        {".nii.gz", read_nifti},
        {".xdmf", read_xdmf_volume},
        {".xmf", read_xdmf_volume},
};
constexpr Importer<CellMesh(const std::filesystem::path&)> mesh_importers[] = {
    {".vtu", read_vtu},
    {".pvtu", read_pvtu},
    {".vts", read_vts},
    {".pvts", read_pvts},
    {".pts", read_carp},
    {".elem", read_carp},
    {".tet", read_carp},
    {".vtk", read_legacy_vtk_mesh},
    {".bin", read_plot3d},
    {".xyz", read_plot3d},
    {".x", read_plot3d},
    {".q", read_plot3d},
    {".p3d", read_plot3d},
    {".node", read_tetgen_mesh},
    {".ele", read_tetgen_mesh},
    {".vol", read_netgen},
    {".mesh", read_medit},
    {".meshb", read_medit},
    {".vtkhdf", read_vtkhdf_mesh},
    {".hdf", read_vtkhdf_mesh},
};
/// Formats that may hold several time steps.
constexpr Importer<CellMesh(const std::filesystem::path&, const std::string& time)> steps_importers[] = {
    {".e", read_exodus},   {".ex2", read_exodus}, {".exo", read_exodus},     {".exii", read_exodus},
    {".gen", read_exodus}, {".msh", read_gmsh},   {".xdmf", read_xdmf_mesh}, {".xmf", read_xdmf_mesh},
};
constexpr Importer<NeutralSurface(const std::filesystem::path&)> surface_importers[] = {
    {".vtk", read_legacy_vtk_surface},
    {".ply", read_ply},
    {".ply.gz", read_ply},
    {".stl", read_stl},
    {".stl.gz", read_stl},
    {".obj", read_obj},
    {".obj.gz", read_obj},
    {".off", read_off},
    {".tri", read_brainvisa},
    {".poly", read_tetgen_surface},
    {".smesh", read_tetgen_surface},
    {".face", read_tetgen_faces},
};

template <class Function, std::size_t N>
Function* find_importer(const Importer<Function> (&importers)[N], const std::filesystem::path& path) {
  const std::string family = family_of(path);
  for (const Importer<Function>& importer : importers)
    if (importer.family == family) return importer.read;
  return nullptr;
}

template <class Function, std::size_t N>
std::string extensions_of(const Importer<Function> (&importers)[N]) {
  std::string known;
  for (const Importer<Function>& importer : importers) known += concat(" ", importer.family);
  return known;
}

Error no_importer(const std::filesystem::path& path, const char* kind, const std::string& known) {
  return {ErrorCode::unsupported,
          concat(path.string(), ": found extension '", family_of(path), "'; expected, for a ", kind, ", one of", known),
          advice_on(path)};
}

template <class Function, std::size_t N>
Function* importer_for(const Importer<Function> (&importers)[N], const std::filesystem::path& path, const char* kind) {
  if (Function* found = find_importer(importers, path)) return found;
  throw no_importer(path, kind, extensions_of(importers));
}

/// For formats with only one field: refuses a request for another.
void check_field_name(const NeutralVolume& volume, const std::string& field, const std::filesystem::path& path) {
  if (!field.empty() && field != volume.field_name)
    throw Error(ErrorCode::usage, concat(path.string(), ": found no field '", field, "'; expected '", volume.field_name,
                                         "', the only one"));
}

}  // namespace

NeutralVolume read_volume(const std::filesystem::path& path, const VolumeRequest& request) {
  if (request.raw || request.colors) refuse_time_step(request.time, path);
  if (request.raw) {
    NeutralVolume volume = read_raw(path, *request.raw);
    check_field_name(volume, request.field, path);
    return volume;
  }
  if (request.colors) {
    NeutralVolume volume = importer_for(color_importers, path, "volume of colours")(path, request.field);
    check_field_name(volume, request.field, path);
    return volume;
  }
  if (auto* read = find_importer(volume_steps_importers, path)) return read(path, request.field, request.time);
  auto* read = find_importer(volume_importers, path);
  if (read == nullptr)
    throw no_importer(path, "volume", extensions_of(volume_importers) + extensions_of(volume_steps_importers));
  refuse_time_step(request.time, path);
  NeutralVolume volume = read(path, request.field);
  check_field_name(volume, request.field, path);
  return volume;
}

CellMesh read_cells(const std::filesystem::path& path, const MeshRequest& request) {
  if (auto* read = find_importer(steps_importers, path)) return read(path, request.time);
  auto* read = find_importer(mesh_importers, path);
  if (read == nullptr) throw no_importer(path, "mesh", extensions_of(mesh_importers) + extensions_of(steps_importers));
  CellMesh mesh = read(path);
  refuse_time_step(request.time, path);
  return mesh;
}

NeutralMesh read_mesh(const std::filesystem::path& path) {
  return subdivide(read_cells(path, {}), {});
}

NeutralSurface read_surface(const std::filesystem::path& path, const std::filesystem::path& sizes) {
  NeutralSurface surface = importer_for(surface_importers, path, "surface")(path);
  const std::filesystem::path beside = std::filesystem::path(path).replace_extension(".mtr");
  if (!sizes.empty())
    surface.point_sizes = read_tetgen_sizes(sizes, surface.points.size());
  else if (is_there(beside))
    surface.point_sizes = read_tetgen_sizes(beside, surface.points.size());
  return surface;
}

}  // namespace rhoray::preprocess
