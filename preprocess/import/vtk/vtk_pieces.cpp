#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <cstring>
#include <set>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/vtk_errors.h"
#include "preprocess/import/vtk/vtk_mesh.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// The files that a PVTU file names, in its order.
std::vector<std::filesystem::path> sources_of(const std::filesystem::path& path) {
  const VtkErrors errors;
  const auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(path.c_str()));
  errors.check(path);
  vtkXMLDataElement* grid = root == nullptr ? nullptr : root->FindNestedElementWithName("PUnstructuredGrid");
  if (grid == nullptr) refuse_input(path, "element VTKFile", "no element PUnstructuredGrid that ends", "one");
  std::vector<std::filesystem::path> sources;
  std::set<std::string> names;
  for (int i = 0; i < grid->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* piece = grid->GetNestedElement(i);
    if (std::strcmp(piece->GetName(), "Piece") != 0) continue;
    const std::string place = concat("element Piece ", sources.size());
    const char* source = piece->GetAttribute("Source");
    if (source == nullptr || *source == '\0')
      refuse_input(path, place, "no attribute Source", "the name of a VTU file");
    if (!names.insert(source).second) refuse_input(path, place, concat("'", source, "' once more"), "each piece once");
    const std::filesystem::path file = path.parent_path() / source;
    if (!std::filesystem::exists(file))
      refuse_input(path, place, concat("no file ", file.string()), "each piece beside it", ErrorCode::unreadable);
    sources.push_back(file);
  }
  if (sources.empty()) refuse_input(path, "element PUnstructuredGrid", "no pieces", "at least one");
  return sources;
}

}  // namespace

CellMesh read_pvtu(const std::filesystem::path& path) {
  check_vtk_xml(path, "PUnstructuredGrid");
  MeshPieces pieces;
  for (const std::filesystem::path& source : sources_of(path)) add_vtu(pieces, source);
  return pieces.finish(path);
}

}  // namespace rhoray::preprocess
