#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/lower_case.h"
#include "formats/base/regular_file.h"
#include "preprocess/import/mesh/plot3d_layout.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/input_file.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/worker_names.h"

namespace rhoray::preprocess {
namespace {

const ForeignFormat formats_read[] = {
    {"NRRD", ForeignKind::volume, {".nrrd", ".nhdr"}, import_worker, true},
    {"MetaImage", ForeignKind::volume, {".mhd", ".mha"}, import_worker, true},
    {"NIfTI-1", ForeignKind::volume, {".nii", ".nii.gz"}, import_worker},
    {"NumPy", ForeignKind::volume, {".npy", ".npz"}, import_worker},
    {"MATLAB", ForeignKind::volume, {".mat"}, import_worker},
    {"VTK image data", ForeignKind::volume, {".vti"}, import_worker},
    {"VTK rectilinear grid", ForeignKind::volume, {".vtr"}, import_worker},
    {"VTK image data in pieces", ForeignKind::volume, {".pvti"}, import_worker, true},
    {"VTK rectilinear grid in pieces", ForeignKind::volume, {".pvtr"}, import_worker, true},
    {"Legacy VTK", ForeignKind::volume, {".vtk"}, import_worker},
    {"VTKHDF image data", ForeignKind::volume, {".vtkhdf", ".hdf"}, import_worker},
    {"XDMF", ForeignKind::volume, {".xdmf", ".xmf"}, import_worker, true},
    {"DICOM", ForeignKind::volume, {".dcm", ".ima", ".zip", "dicom/"}, import_worker},
    {"VolVis SLC", ForeignKind::volume, {".slc"}, import_worker},
    {"Gaussian cube", ForeignKind::volume, {".cube"}, import_worker},
    {"Brick of values", ForeignKind::volume, {".bov"}, import_worker, true},
    {"Pictures",
     ForeignKind::volume,
     {"images/", ".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm"},
     slices_worker},
    {"OpenVDB", ForeignKind::volume, {".vdb"}, vdb_worker},
    {"VTK unstructured grid", ForeignKind::mesh, {".vtu"}, import_worker},
    {"VTK unstructured grid in pieces", ForeignKind::mesh, {".pvtu"}, import_worker, true},
    {"VTK structured grid", ForeignKind::mesh, {".vts"}, import_worker},
    {"VTK structured grid in pieces", ForeignKind::mesh, {".pvts"}, import_worker, true},
    {"Legacy VTK", ForeignKind::mesh, {".vtk"}, import_worker},
    {"VTKHDF unstructured grid", ForeignKind::mesh, {".vtkhdf", ".hdf"}, import_worker},
    {"XDMF", ForeignKind::mesh, {".xdmf", ".xmf"}, import_worker, true},
    {"TetGen", ForeignKind::mesh, {".node", ".ele"}, import_worker, true},
    {"CARP", ForeignKind::mesh, {".pts", ".elem", ".tet"}, import_worker, true},
    {"Exodus", ForeignKind::mesh, {".e", ".ex2", ".exo", ".exii", ".gen"}, import_worker},
    {"Gmsh", ForeignKind::mesh, {".msh"}, import_worker},
    {"Netgen", ForeignKind::mesh, {".vol"}, import_worker},
    {"Medit", ForeignKind::mesh, {".mesh", ".meshb"}, import_worker, true},
    {"PLOT3D", ForeignKind::mesh, {".bin", ".xyz", ".x", ".g", ".q", ".p3d"}, import_worker, true},
    {"PLY", ForeignKind::surface, {".ply", ".ply.gz"}, import_worker},
    {"STL", ForeignKind::surface, {".stl", ".stl.gz"}, import_worker},
    {"Wavefront OBJ", ForeignKind::surface, {".obj", ".obj.gz"}, import_worker},
    {"OFF", ForeignKind::surface, {".off"}, import_worker},
    {"Legacy VTK", ForeignKind::surface, {".vtk"}, import_worker},
    {"BrainVisa", ForeignKind::surface, {".tri"}, import_worker},
    {"TetGen", ForeignKind::surface, {".poly", ".smesh", ".face"}, import_worker, true},
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
    {{".vtkhdf"}, "only image data and unstructured grids in VTKHDF are read; save it with ParaView as .vtu or .vti"},
    {{".h5", ".hdf5", ".hdf"},
     "HDF5 by itself says nothing of meshes and volumes; name the .xdmf or .xmf file that describes it, or convert it "
     "to "
     ".vtu, .vti or .nrrd with the program that wrote it"},
    {{".cgns"}, "CGNS is not read; convert it to .vtu, for example with ParaView or meshio"},
    {{".case"}, "EnSight is not read; convert it to .vtu, for example with ParaView"},
    {{".foam"}, "OpenFOAM is not read; convert it to .vtu, for example with foamToVTK or ParaView"},
    {{".inp", ".bdf", ".nas", ".unv", ".med"},
     "files of this finite element program are not read; convert it to .vtu, for example with meshio"},
    {{".pvtp"},
     "it only lists pieces of one surface; save the whole surface with ParaView (Save Data) as .stl or .ply"},
    {{".vtm", ".vtmb", ".pvd"}, "it only lists other files; name one of them, a .vtu or .vti"},
    {{".step", ".stp", ".iges", ".igs", ".brep", ".geo"},
     "it describes a shape, not a mesh; mesh it with Gmsh (gmsh -3) and use the .msh"},
    {{".gz"}, "decompress it first: gunzip"},
    {{"index.json"},
     "vtk.js data sets are not supported; decompress the .gz in the folder data and use --raw NXxNYxNZ:TYPE"},
    {{".hdr"}, "use a .nii file, which holds the header and the samples of such a pair"},
};

template <class List, class Value>
bool contains(const List& list, const Value& value) {
  return std::find(std::begin(list), std::end(list), value) != std::end(list);
}

bool holds_plot3d(const std::filesystem::path& path) {
  try {
    return !plot3d_layouts(ForeignFile(path)).empty();
  } catch (const Error&) {  // missing, a folder, or empty
    return false;
  }
}

const ForeignFormat* format_of(const std::filesystem::path& path) {
  const std::string family = family_of(path);
  const auto* found = std::find_if(std::begin(formats_read), std::end(formats_read),
                                   [&](const ForeignFormat& row) { return contains(row.families, family); });
  return found == std::end(formats_read) ? nullptr : found;
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

/// Returns the kind of a VTKHDF file. The file contains the name of its group and its attribute
/// Type as text, mostly near the beginning.
ForeignKind kind_of_vtkhdf(const std::filesystem::path& path) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n", group = "VTKHDF";
  constexpr std::size_t near_beginning = 1 << 16;
  const std::string head = first_bytes(path, near_beginning);
  if (!head.starts_with(signature)) return ForeignKind::unknown;
  const auto kind_in = [&](std::string_view text) {
    if (text.find(group) == text.npos) return ForeignKind::unknown;
    if (text.find("UnstructuredGrid") != text.npos) return ForeignKind::mesh;
    return text.find("ImageData") != text.npos ? ForeignKind::volume : ForeignKind::unknown;
  };
  if (const ForeignKind kind = kind_in(head); kind != ForeignKind::unknown) return kind;
  return kind_in(ForeignFile(path).text());
}

/// Returns the kind of an XDMF file, as the type of its first Topology says: the grids of volumes
/// are rectilinear. Mesh for all others, whose reader says what is wrong.
ForeignKind kind_of_xdmf(const std::filesystem::path& path) {
  if (first_bytes(path, 1).empty()) return ForeignKind::mesh;
  const ForeignFile file(path);
  std::string_view text = file.text();
  constexpr std::string_view topology = "<Topology";
  for (std::size_t at = text.find(topology); at != text.npos; at = text.find(topology)) {
    text.remove_prefix(at);
    const std::string tag = lower_case(text.substr(0, text.find('>')));
    if (tag.find("type=") != tag.npos)
      return tag.find("3drectmesh") != tag.npos || tag.find("3dcorectmesh") != tag.npos ? ForeignKind::volume
                                                                                        : ForeignKind::mesh;
    text.remove_prefix(topology.size());
  }
  return ForeignKind::mesh;
}

}  // namespace

std::string_view name_of(ForeignKind kind) {
  constexpr std::string_view names[] = {"volume", "mesh", "surface", "unknown"};
  return names[static_cast<std::size_t>(kind)];
}

ForeignKind foreign_kind(const std::filesystem::path& path) {
  if (extension_of(path) == ".vtk") {
    const std::string dataset = legacy_vtk_dataset(path);
    if (dataset == "STRUCTURED_POINTS" || dataset == "RECTILINEAR_GRID") return ForeignKind::volume;
    if (dataset == "UNSTRUCTURED_GRID" || dataset == "STRUCTURED_GRID") return ForeignKind::mesh;
    if (dataset == "POLYDATA") return ForeignKind::surface;
    return ForeignKind::unknown;
  }
  const ForeignFormat* format = format_of(path);
  if (format != nullptr && format->name.starts_with("VTKHDF")) return kind_of_vtkhdf(path);
  if (format != nullptr && format->name == "XDMF") return kind_of_xdmf(path);
  if (format == nullptr || (format->name == "PLOT3D" && !holds_plot3d(path))) return ForeignKind::unknown;
  return format->kind;
}

std::span<const ForeignFormat> foreign_formats() {
  return formats_read;
}

std::string extensions_of(ForeignKind kind) {
  std::string names;
  for (const ForeignFormat& format : formats_read)
    for (const std::string_view family : format.families)
      if (format.kind == kind && family.front() == '.') names += concat(names.empty() ? "" : " ", family);
  if (kind == ForeignKind::volume) names += ", folders of DICOM images or of pictures";
  return names;
}

std::string_view worker_for(const std::filesystem::path& path) {
  const ForeignFormat* format = format_of(path);
  return format == nullptr ? import_worker : format->worker;
}

std::uint64_t bytes_of_single_file(const std::filesystem::path& path) {
  const ForeignFormat* format = format_of(path);
  std::error_code ignored;
  if (format == nullptr || format->reads_other_files) return 0;
  const std::uintmax_t bytes = std::filesystem::file_size(path, ignored);
  return ignored ? 0 : bytes;
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
  const std::string name = lower_case(path.filename().string());
  for (const auto& [endings, text] : advices)
    for (const std::string_view ending : endings)
      if (name.ends_with(ending)) return std::string(text);
  return {};
}

}  // namespace rhoray::preprocess
