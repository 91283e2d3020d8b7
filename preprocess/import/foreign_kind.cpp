#include <algorithm>
#include <cctype>
#include <fstream>
#include <string>
#include <string_view>

#include "preprocess/import/foreign_file.h"
#include "preprocess/import/foreign_names.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/import_mesh.h"

namespace rhoray::preprocess {
namespace {

struct KindByName {
  std::string_view family;
  ForeignKind kind;
  std::string_view worker = import_worker;
};

// The families of importers.cpp, here for programs that only ask; .vtk is answered by the file itself.
constexpr KindByName kinds[] = {
    {".nrrd", ForeignKind::volume},
    {".nhdr", ForeignKind::volume},
    {".mhd", ForeignKind::volume},
    {".mha", ForeignKind::volume},
    {".nii", ForeignKind::volume},
    {".nii.gz", ForeignKind::volume},
    {".vti", ForeignKind::volume},
    {".vtr", ForeignKind::volume},
    {".slc", ForeignKind::volume},
    {".cube", ForeignKind::volume},
    {".bov", ForeignKind::volume},
    {".dcm", ForeignKind::volume},
    {".ima", ForeignKind::volume},
    {".zip", ForeignKind::volume},
    {"dicom/", ForeignKind::volume},
    {"images/", ForeignKind::volume, slices_worker},
    {".png", ForeignKind::volume, slices_worker},
    {".tif", ForeignKind::volume, slices_worker},
    {".tiff", ForeignKind::volume, slices_worker},
    {".jpg", ForeignKind::volume, slices_worker},
    {".jpeg", ForeignKind::volume, slices_worker},
    {".bmp", ForeignKind::volume, slices_worker},
    {".pgm", ForeignKind::volume, slices_worker},
    {".ppm", ForeignKind::volume, slices_worker},
    {".vtu", ForeignKind::mesh},
    {".node", ForeignKind::mesh},
    {".ele", ForeignKind::mesh},
    {".ply", ForeignKind::surface},
    {".stl", ForeignKind::surface},
    {".obj", ForeignKind::surface},
    {".off", ForeignKind::surface},
    {".poly", ForeignKind::surface},
    {".smesh", ForeignKind::surface},
    {".tri", ForeignKind::surface},
};

const KindByName* row_of(const std::filesystem::path& path) {
  const std::string family = family_of(path);
  const auto found =
      std::find_if(std::begin(kinds), std::end(kinds), [&](const KindByName& row) { return row.family == family; });
  return found == std::end(kinds) ? nullptr : found;
}

/// The word after DATASET in the first lines of a legacy VTK file, in capitals; empty when there is none.
std::string legacy_vtk_dataset(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(4096, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  if (!head.starts_with("# vtk DataFile")) return {};
  std::size_t at = head.find('\n');
  if (at != std::string::npos) at = head.find('\n', at + 1);  // a title of any kind
  if (at == std::string::npos) return {};
  std::transform(head.begin(), head.end(), head.begin(),
                 [](char letter) { return static_cast<char>(std::toupper(static_cast<unsigned char>(letter))); });
  constexpr std::string_view spaces = " \t\r\n", keyword = "DATASET";
  at = head.find(keyword, at);
  if (at == std::string::npos) return {};
  at = std::min(head.find_first_not_of(spaces, at + keyword.size()), head.size());
  return head.substr(at, head.find_first_of(spaces, at) - at);
}

}  // namespace

ForeignKind foreign_kind(const std::filesystem::path& path) {
  if (extension_of(path) == ".vtk") {
    const std::string dataset = legacy_vtk_dataset(path);
    if (dataset == "STRUCTURED_POINTS" || dataset == "RECTILINEAR_GRID") return ForeignKind::volume;
    if (dataset == "UNSTRUCTURED_GRID") return ForeignKind::mesh;
    return ForeignKind::unknown;
  }
  const KindByName* row = row_of(path);
  return row == nullptr ? ForeignKind::unknown : row->kind;
}

std::string_view worker_for(const std::filesystem::path& path) {
  const KindByName* row = row_of(path);
  return row == nullptr ? import_worker : row->worker;
}

}  // namespace rhoray::preprocess
