// Fuzzes our own importers, one format at a time, selected by RHORAY_FUZZ_FORMAT. An input is the
// file, or the file and its companion file, separated by a line `-- next file --`.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "formats/base/checks.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/zip_archive.h"
#include "preprocess/process/messages.h"
#include "preprocess/subdivide.h"
#include "tests/fuzz/harness.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rhoray;
using namespace rhoray::preprocess;
using Path = std::filesystem::path;

constexpr std::string_view next_file = "\n-- next file --\n";

template <class Act>
void attempt(Act&& act) {
  try {
    act();
  } catch (const Error& error) {
    tests::check_refusal(error);
  }
}

/// Sends data through an anonymous file, as from the worker to the subcommand: what a reader sends
/// must be accepted.
template <class Neutral, class Take>
void pass_on(const Neutral& found, Take* take) {
  tests::InputFile file;
  send(found, file.descriptor());
  (void)take(formats::PackedFile::from_descriptor(file.descriptor(), "handed over"));
}

void use(const NeutralVolume& volume) {
  const auto n = volume.sample_count;
  RHORAY_CHECK(n.x > 0 && n.y > 0 && n.z > 0);
  const std::uint64_t texels = static_cast<std::uint64_t>(n.x) * static_cast<std::uint64_t>(n.y) *
                               static_cast<std::uint64_t>(n.z) * static_cast<std::uint64_t>(volume.component_count);
  RHORAY_CHECK(volume.samples.size() == texels * formats::element_bytes(volume.type));
  std::byte all{0};
  for (const std::byte byte : volume.samples) all |= byte;
  [[maybe_unused]] const volatile std::byte kept = all;
  pass_on<NeutralVolume, NeutralVolume(const formats::PackedFile&)>(volume, receive_volume);
}

void use(const NeutralSurface& surface) {
  RHORAY_CHECK(surface.facet_offsets.front() == 0 && surface.facet_offsets.back() == surface.facet_corners.size());
  for (const std::uint64_t corner : surface.facet_corners) RHORAY_CHECK(corner < surface.points.size());
  pass_on(surface, receive_surface);
}

void use(const CellMesh& mesh) {
  RHORAY_CHECK(mesh.cell_offsets.size() == mesh.kinds.size() + 1);
  RHORAY_CHECK(mesh.cell_offsets.back() == mesh.cell_nodes.size());
  for (const NeutralField& field : mesh.point_fields)
    RHORAY_CHECK(field.values.size() == mesh.points.size() * static_cast<std::size_t>(field.component_count));
  pass_on(mesh, receive_cell_mesh);
  (void)subdivide(mesh, {});  // in the process of the subcommand, not of the worker
}

template <auto read>
void volume(const Path& path) {
  use(read(path, ""));
}
template <auto read>
void from_path(const Path& path) {
  use(read(path));
}

void nrrd(const Path& path) {
  attempt([&] { use(read_nrrd(path, "")); });
  attempt([&] { use(read_nrrd_colors(path, "")); });
}
void metaimage(const Path& path) {
  attempt([&] { use(read_metaimage(path, "")); });
  attempt([&] { use(read_metaimage_colors(path, "")); });
}
void nifti(const Path& path) {
  for (const char* time : {"", "last"}) attempt([&] { use(read_nifti(path, "", time)); });
  attempt([&] { use(read_nifti_colors(path, "")); });
}
void npy(const Path& path) {
  attempt([&] { use(read_npy(path, "")); });
  attempt([&] { use(read_npy_colors(path, "")); });
}
void legacy_vtk(const Path& path) {
  attempt([&] { use(read_legacy_vtk_volume(path, "")); });
  attempt([&] { use(read_legacy_vtk_mesh(path)); });
  attempt([&] { use(read_legacy_vtk_surface(path)); });
}
void gmsh(const Path& path) {
  use(read_gmsh(path, ""));
}
/// The grids of a file decide; both readers are tried.
void xdmf(const Path& path) {
  for (const char* time : {"", "first"}) {
    attempt([&] { use(read_xdmf_volume(path, "", time)); });
    attempt([&] { use(read_xdmf_mesh(path, time)); });
  }
}
void tetgen_surface(const Path& path) {
  NeutralSurface surface = read_tetgen_surface(path);
  use(surface);
  attempt([&] {
    surface.point_sizes = read_tetgen_sizes(Path(path).replace_extension(".mtr"), surface.points.size());
    use(surface);
  });
}
void zip(const Path& path) {
  read_zip(path, [](const std::string& name, std::string_view bytes) {
    RHORAY_CHECK(!name.empty() && name.size() < 65536);
    [[maybe_unused]] const volatile std::size_t kept = std::string(bytes).size();
  });
}

struct Format {
  std::string_view name;
  std::array<const char*, 2> extensions;  ///< of the file and of its companion
  void (*read)(const Path&);
};
constexpr Format formats_known[] = {{"nrrd", {".nhdr", ".raw"}, nrrd},
                                    {"metaimage", {".mhd", ".raw"}, metaimage},
                                    {"nifti", {".nii", ""}, nifti},
                                    {"npy", {".npy", ""}, npy},
                                    {"npz", {".npz", ""}, volume<read_npz>},
                                    {"matlab", {".mat", ""}, volume<read_matlab>},
                                    {"carp", {".elem", ".pts"}, from_path<read_carp>},
                                    {"pvti", {".pvti", ".vti"}, volume<read_pvti>},
                                    {"slc", {".slc", ""}, volume<read_slc>},
                                    {"bov", {".bov", ".raw"}, volume<read_bov>},
                                    {"cube", {".cube", ""}, volume<read_gaussian_cube>},
                                    {"plot3d", {".xyz", ".q"}, from_path<read_plot3d>},
                                    {"ply", {".ply", ""}, from_path<read_ply>},
                                    {"stl", {".stl", ""}, from_path<read_stl>},
                                    {"obj", {".obj", ""}, from_path<read_obj>},
                                    {"off", {".off", ""}, from_path<read_off>},
                                    {"brainvisa", {".tri", ""}, from_path<read_brainvisa>},
                                    {"gmsh", {".msh", ""}, gmsh},
                                    {"medit", {".mesh", ".sol"}, from_path<read_medit>},
                                    {"medit_binary", {".meshb", ".solb"}, from_path<read_medit>},
                                    {"netgen", {".vol", ""}, from_path<read_netgen>},
                                    {"tetgen_mesh", {".node", ".ele"}, from_path<read_tetgen_mesh>},
                                    {"tetgen_surface", {".poly", ".mtr"}, tetgen_surface},
                                    {"tetgen_faces", {".face", ".node"}, from_path<read_tetgen_faces>},
                                    {"legacy_vtk", {".vtk", ""}, legacy_vtk},
                                    {"vti", {".vti", ""}, volume<read_vti>},
                                    {"vtu", {".vtu", ""}, from_path<read_vtu>},
                                    {"xdmf", {".xdmf", ".bin"}, xdmf},
                                    {"zip", {".zip", ""}, zip}};

const Format& chosen_format() {
  const char* name = std::getenv("RHORAY_FUZZ_FORMAT");
  for (const Format& format : formats_known)
    if (name != nullptr && format.name == name) return format;
  std::fputs("RHORAY_FUZZ_FORMAT: expected one of", stderr);
  for (const Format& format : formats_known) std::fprintf(stderr, " %s", format.name.data());
  std::fputs("\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Format& format = chosen_format();
  static const tests::TemporaryFolder folder;
  static const Path path = folder / concat("input", format.extensions[0]);
  static const Path beside = folder / concat("input", format.extensions[1]);
  std::string_view whole(reinterpret_cast<const char*>(data), size);
  const bool may_have_two = format.extensions[1][0] != '\0';
  if (may_have_two) {
    const std::size_t at = whole.find(next_file);
    std::filesystem::remove(beside);
    if (at != std::string_view::npos) tests::write_file(beside, whole.substr(at + next_file.size()));
    whole = whole.substr(0, at);
  }
  tests::write_file(path, whole);
  attempt([&] { format.read(path); });
  return 0;
}

// Teem leaks memory when it refuses a damaged file; in the worker, the process then ends.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libteem\n";
}
