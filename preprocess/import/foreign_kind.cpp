#include <algorithm>
#include <cctype>
#include <fstream>
#include <string>
#include <string_view>

#include "preprocess/import/foreign_file.h"
#include "preprocess/import_mesh.h"

namespace rhoray::preprocess {
namespace {

struct KindByName {
  std::string_view extension;
  ForeignKind kind;
};

// The extensions of importers.cpp, here for programs that only ask; .vtk is answered by the file itself.
constexpr KindByName kinds[] = {
    {".nrrd", ForeignKind::volume},   {".nhdr", ForeignKind::volume}, {".mhd", ForeignKind::volume},
    {".mha", ForeignKind::volume},    {".nii", ForeignKind::volume},  {".nii.gz", ForeignKind::volume},
    {".vti", ForeignKind::volume},    {".vtu", ForeignKind::mesh},    {".node", ForeignKind::mesh},
    {".ele", ForeignKind::mesh},      {".ply", ForeignKind::surface}, {".stl", ForeignKind::surface},
    {".obj", ForeignKind::surface},   {".off", ForeignKind::surface}, {".poly", ForeignKind::surface},
    {".smesh", ForeignKind::surface}, {".tri", ForeignKind::surface},
};

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
  const std::string extension = extension_of(path);
  if (extension == ".vtk") {
    const std::string dataset = legacy_vtk_dataset(path);
    if (dataset == "STRUCTURED_POINTS") return ForeignKind::volume;
    if (dataset == "UNSTRUCTURED_GRID") return ForeignKind::mesh;
    return ForeignKind::unknown;
  }
  const auto found = std::find_if(std::begin(kinds), std::end(kinds),
                                  [&](const KindByName& row) { return row.extension == extension; });
  return found == std::end(kinds) ? ForeignKind::unknown : found->kind;
}

}  // namespace rhoray::preprocess
