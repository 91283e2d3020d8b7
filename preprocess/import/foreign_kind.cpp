#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

#include "formats/base/regular_file.h"
#include "preprocess/import/mesh/plot3d_layout.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/input_file.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/worker_names.h"

namespace rhoray::preprocess {
namespace {

struct KindByName {
  std::string_view family;
  ForeignKind kind;
  std::string_view worker = import_worker;
};

// The families of importers.cpp, for programs that only need the kind. The extensions .vtk and
// those of PLOT3D have other uses too, so the file's content decides.
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
    {".vdb", ForeignKind::volume, vdb_worker},
    {".vtu", ForeignKind::mesh},
    {".pvtu", ForeignKind::mesh},
    {".vts", ForeignKind::mesh},
    {".node", ForeignKind::mesh},
    {".ele", ForeignKind::mesh},
    {".ply", ForeignKind::surface},
    {".stl", ForeignKind::surface},
    {".obj", ForeignKind::surface},
    {".off", ForeignKind::surface},
    {".poly", ForeignKind::surface},
    {".smesh", ForeignKind::surface},
    {".e", ForeignKind::mesh},
    {".ex2", ForeignKind::mesh},
    {".exo", ForeignKind::mesh},
    {".exii", ForeignKind::mesh},
    {".gen", ForeignKind::mesh},
    {".msh", ForeignKind::mesh},
    {".vol", ForeignKind::mesh},
    {".mesh", ForeignKind::mesh},
    {".meshb", ForeignKind::mesh},
    {".face", ForeignKind::surface},
    {".tri", ForeignKind::surface},
};

struct Advice {
  std::string_view ending;  ///< end of the name, in lower case; the first matching row counts
  std::string_view text;
};

constexpr std::string_view convert = "convert it to .vtu, for example with ParaView or meshio";
constexpr std::string_view name_a_piece = "it only lists other files; name one of them, a .vtu or .vti";
constexpr std::string_view mesh_it = "it describes a shape, not a mesh; mesh it with Gmsh (gmsh -3) and use the .msh";
constexpr std::string_view unpack_it = "decompress it first: gunzip";
constexpr Advice advices[] = {
    {".lvs.fld",
     "SCIRun's samples follow a header; use --raw with their size, type, byte order and offset, such as --raw "
     "64x64x64:int32:be:524"},
    {".fld", "SCIRun's fields are not supported; use the .vtu or .ply made from it"},
    {".sol", "it holds only values; name the .mesh or .meshb beside it"},
    {".solb", "it holds only values; name the .mesh or .meshb beside it"},
    {".xdmf", convert},
    {".xmf", convert},
    {".h5", convert},
    {".hdf5", convert},
    {".cgns", convert},
    {".case", convert},
    {".foam", convert},
    {".inp", convert},
    {".bdf", convert},
    {".nas", convert},
    {".unv", convert},
    {".med", convert},
    {".pvti", "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vti"},
    {".pvtr", "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vtr"},
    {".pvts", "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vts"},
    {".pvtp", "it only lists pieces of one surface; save the whole surface with ParaView (Save Data) as .stl or .ply"},
    {".vtm", name_a_piece},
    {".vtmb", name_a_piece},
    {".pvd", name_a_piece},
    {".step", mesh_it},
    {".stp", mesh_it},
    {".iges", mesh_it},
    {".igs", mesh_it},
    {".brep", mesh_it},
    {".geo", mesh_it},
    {".vol.gz", unpack_it},
    {".msh.gz", unpack_it},
    {".ply.gz", unpack_it},
    {".stl.gz", unpack_it},
    {"index.json",
     "vtk.js data sets are not supported; decompress the .gz in the folder data and use --raw NXxNYxNZ:TYPE"},
    {".hdr", "use a .nii file, which holds the header and the samples of such a pair"},
};

constexpr std::string_view plot3d_extensions[] = {".bin", ".xyz", ".x", ".g", ".q", ".p3d"};

bool is_plot3d(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (std::find(std::begin(plot3d_extensions), std::end(plot3d_extensions), extension) == std::end(plot3d_extensions))
    return false;
  try {
    return !plot3d_layouts(ForeignFile(path)).empty();
  } catch (const Error&) {  // missing, a folder, or empty
    return false;
  }
}

const KindByName* row_of(const std::filesystem::path& path) {
  const std::string family = family_of(path);
  const auto found =
      std::find_if(std::begin(kinds), std::end(kinds), [&](const KindByName& row) { return row.family == family; });
  return found == std::end(kinds) ? nullptr : found;
}

/// The word after DATASET in the first lines of a legacy VTK file, in upper case; empty if there is
/// none.
std::string legacy_vtk_dataset(const std::filesystem::path& path) {
  std::string head = first_bytes(path, 4096);
  if (!head.starts_with("# vtk DataFile")) return {};
  std::size_t at = head.find('\n');
  if (at != std::string::npos) at = head.find('\n', at + 1);  // any title
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
    if (dataset == "UNSTRUCTURED_GRID" || dataset == "STRUCTURED_GRID") return ForeignKind::mesh;
    if (dataset == "POLYDATA") return ForeignKind::surface;
    return ForeignKind::unknown;
  }
  const KindByName* row = row_of(path);
  if (row == nullptr) return is_plot3d(path) ? ForeignKind::mesh : ForeignKind::unknown;
  return row->kind;
}

std::string extensions_of(ForeignKind kind) {
  std::string names;
  for (const KindByName& row : kinds)
    if (row.kind == kind && row.family.front() == '.') names += concat(names.empty() ? "" : " ", row.family);
  if (kind == ForeignKind::mesh) names += " .vtk PLOT3D";
  if (kind == ForeignKind::surface) names += " .vtk";
  if (kind == ForeignKind::volume) names += " .vtk, folders of DICOM images or of pictures";
  return names;
}

std::string_view worker_for(const std::filesystem::path& path) {
  const KindByName* row = row_of(path);
  return row == nullptr ? import_worker : row->worker;
}

namespace {

/// The header in the same folder that says where the samples are: one that names this file, or its
/// numbered series.
std::filesystem::path header_that_names(const std::filesystem::path& path) {
  constexpr std::string_view headers[] = {".nhdr", ".nrrd", ".mhd", ".bov"};
  const std::string name = path.filename().string(), numbered = path.stem().string() + ".%";
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  for (const std::filesystem::path& other : files_in(folder)) {
    if (std::find(std::begin(headers), std::end(headers), extension_of(other)) == std::end(headers)) continue;
    const std::string head = first_bytes(other, 8192);
    if (head.find(name) != std::string::npos || head.find(numbered) != std::string::npos) return other;
  }
  return {};
}

}  // namespace

std::string advice_on(const std::filesystem::path& path) {
  if (const std::filesystem::path header = header_that_names(path); !header.empty())
    return concat("it holds only samples; name their header, ", header.string());
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char letter) { return static_cast<char>(std::tolower(static_cast<unsigned char>(letter))); });
  const auto found = std::find_if(std::begin(advices), std::end(advices),
                                  [&](const Advice& row) { return name.ends_with(row.ending); });
  return found == std::end(advices) ? std::string() : std::string(found->text);
}

}  // namespace rhoray::preprocess
