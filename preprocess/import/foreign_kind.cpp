#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/regular_file.h"
#include "preprocess/import/mesh/plot3d_layout.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/input_file.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/worker_names.h"

namespace rhoray::preprocess {
namespace {

/// Families of one kind that one worker reads.
struct Families {
  ForeignKind kind;
  std::string_view worker;
  std::vector<std::string_view> names;
};

/// The families of importers.cpp, for programs that only need the kind. The extensions .vtk and
/// those of PLOT3D have other uses too, so the file's content decides.
const Families known_families[] = {
    {ForeignKind::volume,
     import_worker,
     {".nrrd", ".nhdr", ".mhd", ".mha", ".nii", ".nii.gz", ".vti", ".vtr", ".slc", ".cube", ".bov", ".dcm", ".ima",
      ".zip", "dicom/"}},
    {ForeignKind::volume, slices_worker, {"images/", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm"}},
    {ForeignKind::volume, vdb_worker, {".vdb"}},
    {ForeignKind::mesh,
     import_worker,
     {".vtu", ".pvtu", ".vts", ".node", ".ele", ".e", ".ex2", ".exo", ".exii", ".gen", ".msh", ".vol", ".mesh",
      ".meshb"}},
    {ForeignKind::surface, import_worker, {".ply", ".stl", ".obj", ".off", ".poly", ".smesh", ".face", ".tri"}},
};

struct Advice {
  std::vector<std::string_view> endings;  ///< of the name, in lower case; the first match counts
  std::string_view text;
};

const Advice advices[] = {
    {{".lvs.fld"},
     "SCIRun's samples follow a header; use --raw with their size, type, byte order and offset, such as --raw "
     "64x64x64:int32:be:524"},
    {{".fld"}, "SCIRun's fields are not supported; use the .vtu or .ply made from it"},
    {{".sol", ".solb"}, "it holds only values; name the .mesh or .meshb beside it"},
    {{".xdmf", ".xmf", ".h5", ".hdf5", ".cgns", ".case", ".foam", ".inp", ".bdf", ".nas", ".unv", ".med"},
     "convert it to .vtu, for example with ParaView or meshio"},
    {{".pvti"}, "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vti"},
    {{".pvtr"}, "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vtr"},
    {{".pvts"}, "it only lists pieces of one grid; save the whole grid with ParaView (Save Data) as .vts"},
    {{".pvtp"},
     "it only lists pieces of one surface; save the whole surface with ParaView (Save Data) as .stl or .ply"},
    {{".vtm", ".vtmb", ".pvd"}, "it only lists other files; name one of them, a .vtu or .vti"},
    {{".step", ".stp", ".iges", ".igs", ".brep", ".geo"},
     "it describes a shape, not a mesh; mesh it with Gmsh (gmsh -3) and use the .msh"},
    {{".vol.gz", ".msh.gz", ".ply.gz", ".stl.gz"}, "decompress it first: gunzip"},
    {{"index.json"},
     "vtk.js data sets are not supported; decompress the .gz in the folder data and use --raw NXxNYxNZ:TYPE"},
    {{".hdr"}, "use a .nii file, which holds the header and the samples of such a pair"},
};

constexpr std::string_view plot3d_extensions[] = {".bin", ".xyz", ".x", ".g", ".q", ".p3d"};

template <class List, class Value>
bool contains(const List& list, const Value& value) {
  return std::find(std::begin(list), std::end(list), value) != std::end(list);
}

bool is_plot3d(const std::filesystem::path& path) {
  if (!contains(plot3d_extensions, extension_of(path))) return false;
  try {
    return !plot3d_layouts(ForeignFile(path)).empty();
  } catch (const Error&) {  // missing, a folder, or empty
    return false;
  }
}

const Families* families_of(const std::filesystem::path& path) {
  const std::string family = family_of(path);
  const auto* found = std::find_if(std::begin(known_families), std::end(known_families),
                                   [&](const Families& row) { return contains(row.names, family); });
  return found == std::end(known_families) ? nullptr : found;
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
  const Families* row = families_of(path);
  if (row == nullptr) return is_plot3d(path) ? ForeignKind::mesh : ForeignKind::unknown;
  return row->kind;
}

std::string extensions_of(ForeignKind kind) {
  std::string names;
  for (const Families& row : known_families)
    for (const std::string_view name : row.names)
      if (row.kind == kind && name.front() == '.') names += concat(names.empty() ? "" : " ", name);
  if (kind == ForeignKind::mesh) names += " .vtk PLOT3D";
  if (kind == ForeignKind::surface) names += " .vtk";
  if (kind == ForeignKind::volume) names += " .vtk, folders of DICOM images or of pictures";
  return names;
}

std::string_view worker_for(const std::filesystem::path& path) {
  const Families* row = families_of(path);
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
    if (!contains(headers, extension_of(other))) continue;
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
  for (const auto& [endings, text] : advices)
    for (const std::string_view ending : endings)
      if (name.ends_with(ending)) return std::string(text);
  return {};
}

}  // namespace rhoray::preprocess
