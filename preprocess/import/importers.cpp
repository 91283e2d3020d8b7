#include <array>
#include <string_view>

#include "formats/base/trouble.h"
#include "preprocess/import/families.h"
#include "preprocess/import/foreign_names.h"
#include "preprocess/subdivide.h"

namespace rhoray::preprocess {
namespace {

template <class Function>
struct Importer {
  std::string_view family;
  Function* read;
};

// One line for each extension, or kind of folder; foreign_kind.cpp says the same to those who only ask (a test compares
// the two).
constexpr Importer<NeutralVolume(const std::filesystem::path&, const std::string&)> volume_importers[] = {
    {".nrrd", read_nrrd},
    {".nhdr", read_nrrd},
    {".mhd", read_metaimage},
    {".mha", read_metaimage},
    {".nii", read_nifti},
    {".nii.gz", read_nifti},
    {".vti", read_vti},
    {".vtk", read_legacy_vtk_volume},
    {".vtr", read_vtr},
    {".slc", read_slc},
    {".cube", read_gaussian_cube},
    {".bov", read_bov},
    {".dcm", read_dicom},
    {".ima", read_dicom},
    {".zip", read_dicom},
    {"dicom/", read_dicom},
};
constexpr Importer<CellMesh(const std::filesystem::path&)> mesh_importers[] = {
    {".vtu", read_vtu},
    {".vtk", read_legacy_vtk_mesh},
    {".node", read_tetgen_mesh},
    {".ele", read_tetgen_mesh},
};
constexpr Importer<NeutralSurface(const std::filesystem::path&)> surface_importers[] = {
    {".ply", read_ply},
    {".stl", read_stl},
    {".obj", read_obj},
    {".off", read_off},
    {".tri", read_brainvisa},
    {".poly", read_tetgen_surface},
    {".smesh", read_tetgen_surface},
};

template <class Function, std::size_t N>
Function* importer_for(const Importer<Function> (&importers)[N], const std::filesystem::path& path, const char* kind) {
  const std::string family = family_of(path);
  std::string known;
  for (const Importer<Function>& importer : importers) {
    if (importer.family == family) return importer.read;
    known += concat(known.empty() ? "" : " ", importer.family);
  }
  throw Error(Trouble::unsupported,
              concat(path.string(), ": found extension '", family, "'; expected, for a ", kind, ", one of ", known));
}

/// Formats that hold one field without choice: asking for another is refused.
void check_field_name(const NeutralVolume& volume, const std::string& field, const std::filesystem::path& path) {
  if (!field.empty() && field != volume.field_name)
    throw Error(Trouble::usage, concat(path.string(), ": found no field '", field, "'; expected '", volume.field_name,
                                       "', the only one"));
}

}  // namespace

NeutralVolume read_volume(const std::filesystem::path& path, const VolumeRequest& request) {
  NeutralVolume volume =
      request.raw ? read_raw(path, *request.raw) : importer_for(volume_importers, path, "volume")(path, request.field);
  check_field_name(volume, request.field, path);
  return volume;
}

CellMesh read_cells(const std::filesystem::path& path, const MeshRequest& request) {
  CellMesh mesh = importer_for(mesh_importers, path, "mesh")(path);
  if (!request.time.empty())
    throw Error(Trouble::usage,
                concat(path.string(), ": found no time steps; expected some, for '", request.time, "'"));
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
  else if (std::filesystem::exists(beside))
    surface.point_sizes = read_tetgen_sizes(beside, surface.points.size());
  return surface;
}

}  // namespace rhoray::preprocess
