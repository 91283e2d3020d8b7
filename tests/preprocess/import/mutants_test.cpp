// Small files of every family that can be written by hand here, each changed at random in many
// ways, read as programs read them: by a worker, whose end is an error of the caller at worst.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <ostream>
#include <random>

#include "preprocess/import/readers.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/limits.h"
#include "preprocess/process/messages.h"
#include "preprocess/subdivide.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"
#include "tests/support/asked_count.h"
#include "tests/support/memory_file.h"
#include "tests/support/sanitizers.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

enum class Family { volume, mesh, surface };

struct Seed {
  std::string name;  ///< of the file that is read
  Family family;
  std::map<std::string, std::string> files;  ///< by name; one of them is changed each time

  friend void PrintTo(const Seed& seed, std::ostream* to) { *to << seed.name; }
};

std::string int16_bytes() {
  return bytes_of_values(known_values<std::int16_t>());
}

std::string nifti() {
  std::string header(352, '\0');
  const auto put = [&]<class T>(std::size_t at, const std::vector<T>& values) {
    header.replace(at, sizeof(T) * values.size(), bytes_of_values(values));
  };
  put(0, std::vector<std::int32_t>{348});
  put(40, std::vector<std::int16_t>{3, 3, 4, 5, 1, 1, 1, 1});
  put(70, std::vector<std::int16_t>{4, 16});
  put(76, std::vector<float>{1, 2, 3, 4, 0, 0, 0, 0});
  put(108, std::vector<float>{352});
  header.replace(344, 4, std::string("n+1\0", 4));
  return header + int16_bytes();
}

std::string gzipped(const std::string& content) {
  const TemporaryFolder folder;
  const gzFile packed = ::gzopen((folder / "a.gz").c_str(), "wb");
  ::gzwrite(packed, content.data(), static_cast<unsigned>(content.size()));
  ::gzclose(packed);
  return read_file(folder / "a.gz");
}

std::string npy(const char* fortran_order = "False") {
  std::string text = concat("{'descr': '<i2', 'fortran_order': ", fortran_order, ", 'shape': (5, 4, 3), }");
  text.resize(118, ' ');
  return std::string("\x93NUMPY\1\0v\0", 10) + text + int16_bytes();
}

std::string matlab() {
  const auto words = [](const std::vector<std::uint32_t>& numbers) { return bytes_of_values(numbers); };
  const std::string array = words({6, 8, 10, 0, 5, 12, 3, 4, 5, 0, 1U << 16 | 1, 'a', 3, 120}) + int16_bytes();
  std::string text = "MATLAB 5.0 MAT-file";
  text.resize(124, ' ');
  return text + std::string("\0\1IM", 4) + words({14, static_cast<std::uint32_t>(array.size())}) + array;
}

std::string cube() {
  std::string text = "title\nsecond line\n1 1 2 3\n3 0.5 0.1 0\n4 0 0.25 0\n5 0 0 2\n6 6.0 0 0 0\n";
  for (int i = 0; i < size_x; ++i)
    for (int j = 0; j < size_y; ++j)
      for (int k = 0; k < size_z; ++k) text += concat(value_at(i, j, k), k % 6 == 5 ? "\n" : " ");
  return text;
}

std::string slc() {
  const std::string runs = std::string("\x05\x07\x87\x05\x06\x07\x08\x09\x0a\x0b", 10) + '\0';
  std::string text = "11111\n3 4 5 8\n0.5 1 2\n1 0 0 1\n2 1 XiconXY";
  for (int k = 0; k < size_z; ++k) text += concat(runs.size(), " X", runs);
  return text;
}

std::string vtk_image() {
  return "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 2 0 3 0 "
         "4\" "
         "Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 2 0 3 0 4\"><PointData><DataArray type=\"Float32\" "
         "Name=\"a\" format=\"ascii\">" +
         values_in_text() + "</DataArray></PointData></Piece></ImageData></VTKFile>";
}

std::string vtk_image_appended() {
  return "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"><ImageData "
         "WholeExtent=\"0 2 0 3 0 4\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 2 0 3 0 4\"><PointData>"
         "<DataArray type=\"Int16\" Name=\"a\" format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData>"
         "<AppendedData encoding=\"raw\">_" +
         bytes_of_values(std::vector<std::uint64_t>{int16_bytes().size()}) + int16_bytes() +
         "</AppendedData></VTKFile>";
}

std::string vtk_rectilinear() {
  const auto axis = [](const char* numbers) {
    return concat("<DataArray type=\"Float32\" Name=\"x\" format=\"ascii\">", numbers, "</DataArray>");
  };
  return "<VTKFile type=\"RectilinearGrid\" version=\"0.1\"><RectilinearGrid WholeExtent=\"0 2 0 3 0 4\"><Piece "
         "Extent=\"0 2 0 3 0 4\"><PointData><DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">" +
         values_in_text() + "</DataArray></PointData><Coordinates>" + axis("0 1 3") + axis("0 1 2 5") +
         axis("0 1 2 3 9") + "</Coordinates></Piece></RectilinearGrid></VTKFile>";
}

const std::string four_points = "0 0 0 1 0 0 0 1 0 0 0 1";

std::string vtk_unstructured() {
  return "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
         "NumberOfCells=\"1\"><PointData><DataArray type=\"Float64\" Name=\"a\" format=\"ascii\">1 2 3 "
         "4</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">" +
         four_points +
         "</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 "
         "3</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray "
         "type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
}

std::string vtk_structured() {
  return "<VTKFile type=\"StructuredGrid\" version=\"0.1\"><StructuredGrid WholeExtent=\"0 1 0 1 0 1\"><Piece "
         "Extent=\"0 1 "
         "0 1 0 1\"><PointData><DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">1 2 3 4 5 6 7 8</DataArray>"
         "</PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 "
         "1 "
         "1 0 0 0 1 1 0 1 0 1 1 1 1 1</DataArray></Points></Piece></StructuredGrid></VTKFile>";
}

std::string parallel_grid() {
  return "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\"><PUnstructuredGrid "
         "GhostLevel=\"0\"><PPointData><PDataArray "
         "type=\"Float64\" Name=\"a\"/></PPointData><PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/>"
         "</PPoints><Piece Source=\"piece.vtu\"/></PUnstructuredGrid></VTKFile>";
}

std::string parallel_image() {
  return "<VTKFile type=\"PImageData\" version=\"0.1\"><PImageData WholeExtent=\"0 2 0 3 0 4\" GhostLevel=\"0\"><Piece "
         "Extent=\"0 2 0 3 0 4\" Source=\"piece.vti\"/></PImageData></VTKFile>";
}

std::string legacy(const std::string& rest) {
  return "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET " + rest;
}

std::vector<Seed> seeds() {
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  const std::string nrrd = "NRRD0004\ntype: short\nendian: little\ndimension: 3\nsizes: 3 4 5\nspacings: 1 2 3\n";
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementSpacing = 1 2 3\nElementType = MET_SHORT\n";
  const std::string binary_ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
      bytes_of_values(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) + '\3' +
      bytes_of_values(std::vector<std::int32_t>{0, 1, 2});
  const std::string binary_stl = std::string(80, ' ') + bytes_of_values(std::vector<std::uint32_t>{1}) +
                                 bytes_of_values(std::vector<float>{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) +
                                 std::string(2, '\0');
  const std::string text_stl =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
      "a\n";
  const std::string medit =
      "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\nTetrahedra\n1\n1 2 3 4 "
      "7\nEnd\n";
  const std::string medit_values = "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n4\n1 1\n1\n2\n3\n4\nEnd\n";
  const std::string netgen =
      "mesh3d\ndimension\n3\ngeomtype\n0\nsurfaceelements\n1\n1 1 1 0 3 1 2 3\nvolumeelements\n1\n7 4 1 3 2 "
      "4\npoints\n4\n" +
      points + "endmesh\n";
  const std::string gmsh_2 =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n"
      "3 4 2 10 20 1 2 3 4\n$EndElements\n$NodeData\n1\n\"T\"\n1\n0.5\n3\n0\n1\n2\n1 7.5\n2 8.25\n$EndNodeData\n";
  const std::string gmsh_4 =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n20 0 0 0 1 1 1 0 0\n$EndEntities\n$Nodes\n1 4 1 4\n3 "
      "20 0 "
      "4\n1\n2\n3\n4\n" +
      points + "$EndNodes\n$Elements\n1 1 1 1\n3 20 4 1\n1 1 2 3 4\n$EndElements\n";
  const std::string plot3d =
      bytes_of_values(std::vector<std::int32_t>{2, 2, 2}) +
      bytes_of_values(std::vector<float>{0, 1, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1});
  const std::string picture = "P5\n3 4\n255\n" + std::string(12, '\7');
  return {
      {"attached.nrrd", Family::volume, {{"attached.nrrd", nrrd + "encoding: raw\n\n" + int16_bytes()}}},
      {"packed.nrrd", Family::volume, {{"packed.nrrd", nrrd + "encoding: gzip\n\n" + gzipped(int16_bytes())}}},
      {"text.nrrd", Family::volume, {{"text.nrrd", nrrd + "encoding: ascii\n\n" + values_in_text()}}},
      {"a.nhdr", Family::volume, {{"a.nhdr", nrrd + "encoding: raw\ndata file: a.raw\n"}, {"a.raw", int16_bytes()}}},
      {"a.mhd", Family::volume, {{"a.mhd", meta + "ElementDataFile = a.raw\n"}, {"a.raw", int16_bytes()}}},
      {"a.mha", Family::volume, {{"a.mha", meta + "ElementDataFile = LOCAL\n" + int16_bytes()}}},
      {"a.nii", Family::volume, {{"a.nii", nifti()}}},
      {"a.nii.gz", Family::volume, {{"a.nii.gz", gzipped(nifti())}}},
      {"a.cube", Family::volume, {{"a.cube", cube()}}},
      {"a.slc", Family::volume, {{"a.slc", slc()}}},
      {"a.bov",
       Family::volume,
       {{"a.bov", "DATA_FILE: a.raw\nDATA_SIZE: 3 4 5\nDATA_FORMAT: SHORT\nVARIABLE: a\nBRICK_SIZE: 6 8 10\n"},
        {"a.raw", int16_bytes()}}},
      {"a.npy", Family::volume, {{"a.npy", npy()}}},
      {"fortran.npy", Family::volume, {{"fortran.npy", npy("True")}}},
      {"a.mat", Family::volume, {{"a.mat", matlab()}}},
      {"a.vti", Family::volume, {{"a.vti", vtk_image()}}},
      {"appended.vti", Family::volume, {{"appended.vti", vtk_image_appended()}}},
      {"a.vtr", Family::volume, {{"a.vtr", vtk_rectilinear()}}},
      {"volume.vtk",
       Family::volume,
       {{"volume.vtk", legacy("STRUCTURED_POINTS\nDIMENSIONS 3 4 5\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 60\n"
                              "SCALARS a float 1\nLOOKUP_TABLE default\n") +
                           values_in_text()}}},
      {"a.pgm", Family::volume, {{"a.pgm", picture}}},
      {"a.pvti", Family::volume, {{"a.pvti", parallel_image()}, {"piece.vti", vtk_image()}}},
      {"a.vtu", Family::mesh, {{"a.vtu", vtk_unstructured()}}},
      {"a.vts", Family::mesh, {{"a.vts", vtk_structured()}}},
      {"a.pvtu", Family::mesh, {{"a.pvtu", parallel_grid()}, {"piece.vtu", vtk_unstructured()}}},
      {"a.xdmf", Family::mesh, {{"a.xdmf", xdmf_mesh()}, {"a.bin", bytes_of_values(std::vector<float>{1, 2, 3, 4})}}},
      {"hdf5.xdmf", Family::mesh, {{"hdf5.xdmf", xdmf_hdf5()}, {"a.h5", hdf5()}}},
      {"volume.xmf", Family::volume, {{"volume.xmf", xdmf_volume()}, {"a.bin", int16_bytes()}}},
      {"mesh.vtk",
       Family::mesh,
       {{"mesh.vtk", legacy("UNSTRUCTURED_GRID\nPOINTS 4 double\n" + four_points +
                            "\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\nSCALARS a double 1\nLOOKUP_TABLE "
                            "default\n1 2 3 4\n")}}},
      {"a.node",
       Family::mesh,
       {{"a.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"}, {"a.ele", "1 4 0\n1 1 2 3 4\n"}}},
      {"a.elem", Family::mesh, {{"a.elem", "2\nTt 0 1 2 3 7\nTt 0 1 3 2 8\n"}, {"a.pts", "4\n" + points}}},
      {"a.mesh", Family::mesh, {{"a.mesh", medit}, {"a.sol", medit_values}}},
      {"a.vol", Family::mesh, {{"a.vol", netgen}}},
      {"two.msh", Family::mesh, {{"two.msh", gmsh_2}}},
      {"four.msh", Family::mesh, {{"four.msh", gmsh_4}}},
      {"a.xyz", Family::mesh, {{"a.xyz", plot3d}}},
      {"text.ply",
       Family::surface,
       {{"text.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 4\nproperty list uchar int vertex_indices\nend_header\n" +
             points + faces}}},
      {"binary.ply", Family::surface, {{"binary.ply", binary_ply}}},
      {"text.stl", Family::surface, {{"text.stl", text_stl}}},
      {"binary.stl", Family::surface, {{"binary.stl", binary_stl}}},
      {"a.ply.gz", Family::surface, {{"a.ply.gz", gzipped(binary_ply)}}},
      {"a.obj",
       Family::surface,
       {{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2/1 3//2 4\nf -1 1 3\n"}}},
      {"a.off", Family::surface, {{"a.off", "OFF\n4 4 0\n" + points + faces}}},
      {"a.tri",
       Family::surface,
       {{"a.tri", "- 4\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n- 4 4 4\n0 2 1\n0 1 3\n1 2 3\n2 0 3\n"}}},
      {"a.poly",
       Family::surface,
       {{"a.poly",
         "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n4 0\n1\n3 1 3 2\n1\n3 1 2 4\n1\n3 2 3 4\n1\n3 1 4 3\n0\n0\n"}}},
      {"surface.vtk",
       Family::surface,
       {{"surface.vtk", legacy("POLYDATA\nPOINTS 4 double\n" + four_points + "\nPOLYGONS 4 16\n" + faces)}}}};
}

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t count) {
  return static_cast<std::size_t>(random() % std::max<std::size_t>(count, 1));
}

void flip_bytes(std::string& content, Random& random) {
  for (std::size_t left = 1 + below(random, 4); left > 0; --left)
    content[below(random, content.size())] = static_cast<char>(random());
}

void cut_off(std::string& content, Random& random) {
  content.resize(below(random, content.size()));
}

void repeat_part(std::string& content, Random& random) {
  const std::size_t from = below(random, content.size());
  content.insert(below(random, content.size()), content.substr(from, below(random, 64)));
}

/// Numbers at which counts, sizes and indices break.
void change_number(std::string& content, Random& random) {
  constexpr std::string_view numbers[] = {
      "0",          "1",          "-1",         "2147483647",           "2147483648",
      "4294967295", "4294967296", "65536",      "9223372036854775807",  "1e308",
      "nan",        "-0.0",       "1000000000", "18446744073709551615", "1e-320"};
  std::vector<std::pair<std::size_t, std::size_t>> runs;
  for (std::size_t at = 0; at < content.size(); ++at) {
    const std::size_t begin = at;
    while (at < content.size() && content[at] >= '0' && content[at] <= '9') ++at;
    if (at > begin) runs.emplace_back(begin, at - begin);
  }
  if (runs.empty()) return flip_bytes(content, random);
  const auto [begin, count] = runs[below(random, runs.size())];
  content.replace(begin, count, numbers[below(random, std::size(numbers))]);
}

/// The same in binary headers.
void change_word(std::string& content, Random& random) {
  constexpr std::uint64_t words[] = {
      0, 1, 0x7fffffff, 0x80000000, 0xffffffff, ~std::uint64_t{0}, std::uint64_t{1} << 63};
  const std::size_t size = std::size_t{1} << below(random, 4);
  if (content.size() < size) return flip_bytes(content, random);
  const std::uint64_t word = words[below(random, std::size(words))];
  std::memcpy(content.data() + below(random, std::min<std::size_t>(content.size() - size + 1, 512)), &word, size);
}

std::map<std::string, std::string> mutant_of(const Seed& seed, Random& random) {
  constexpr void (*changes[])(std::string&, Random&) = {flip_bytes,    cut_off,       repeat_part,
                                                        change_number, change_number, change_word};
  std::map<std::string, std::string> files = seed.files;
  auto chosen = files.begin();
  std::advance(chosen, static_cast<std::ptrdiff_t>(below(random, files.size())));
  for (std::size_t left = 1 + below(random, 2); left > 0 && !chosen->second.empty(); --left)
    changes[below(random, std::size(changes))](chosen->second, random);
  return files;
}

constexpr std::uint64_t cap_bytes = std::uint64_t{1} << 30;

/// By the verbs that programs call: a worker program is started for each file.
void read(const Seed& seed, const std::filesystem::path& path) {
  ImportVolumeOptions volume;
  ImportMeshOptions mesh;
  volume.memory_limit_bytes = mesh.memory_limit_bytes = cap_bytes;
  switch (seed.family) {
    case Family::volume:
      import_volume(path, volume);
      return;
    case Family::mesh:
      import_mesh(path, mesh);
      return;
    case Family::surface:
      import_surface(path, {}, mesh);
  }
}

/// What became of some mutants.
struct Counts {
  int read = 0, refused = 0, crashes = 0;
  std::uint64_t largest_bytes = 0;  ///< in memory, of a reading process
};

void hand_over_what_is_read(const Seed& seed, const std::filesystem::path& path, int output) {
  switch (seed.family) {
    case Family::volume:
      return send(read_volume(path, {}), output);
    case Family::mesh:
      return send(read_cells(path, {}), output);
    case Family::surface:
      return send(read_surface(path, {}), output);
  }
}

void take_what_was_read(const Seed& seed, const std::filesystem::path& path, const formats::PackedFile& answer) {
  switch (seed.family) {
    case Family::volume:
      receive_volume(answer, path);
      return;
    case Family::mesh:
      subdivide(receive_cell_mesh(answer), {});
      return;
    case Family::surface:
      receive_surface(answer);
  }
}

/// The same without starting a program, which takes most of the time: a copy of this process reads
/// under the limits of a worker, and this process takes what it hands over.
void read_in_copy(const Seed& seed, const std::filesystem::path& path, Counts& counts) {
  const MemoryFile output;
  WorkerRequest request;
  request.memory_limit_bytes = cap_bytes;
  const WorkerLimits limits = limits_for(request);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(STDERR_FILENO);
    ::setrlimit(RLIMIT_CORE, &limits.core);
    ::setrlimit(RLIMIT_FSIZE, &limits.file_size);
    if (!tests::sanitized) ::setrlimit(RLIMIT_DATA, &limits.memory);
    ::alarm(10);
    ::setenv("RHORAY_DOING", "reading", 1);
    ::setenv("RHORAY_OUTPUT_FD", concat(output.descriptor()).c_str(), 1);
    ::_exit(worker_main([&](int, int descriptor) { hand_over_what_is_read(seed, path, descriptor); }));
  }
  int status = 0;
  rusage used{};
  while (::wait4(child, &status, 0, &used) < 0) {
  }
  counts.largest_bytes = std::max(counts.largest_bytes, static_cast<std::uint64_t>(used.ru_maxrss) << 10);
  if (WIFSIGNALED(status)) throw Error(ErrorCode::invalid, concat("was stopped by signal ", WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) throw Error(static_cast<ErrorCode>(WEXITSTATUS(status)), "the reader's refusal");
  take_what_was_read(seed, path, formats::PackedFile::from_descriptor(output.descriptor(), "answer"));
}

/// @param number  of the mutant, from which all chance comes
void try_mutant(const Seed& seed, std::uint64_t number, Counts& counts) {
  constexpr std::uint64_t few = 20;  // one of so many by the worker program itself
  Random random(number * 1009 + std::hash<std::string>{}(seed.name));
  const std::map<std::string, std::string> files = mutant_of(seed, random);
  const TemporaryFolder folder;
  for (const auto& [name, content] : files) write_file(folder / name, content);
  const auto start = std::chrono::steady_clock::now();
  try {
    const bool by_slices_worker = seed.name == "a.pgm";  // its readers are in no library of this program
    if (number % few == 0 || by_slices_worker)
      read(seed, folder / seed.name);
    else
      read_in_copy(seed, folder / seed.name, counts);
    ++counts.read;
  } catch (const Error& error) {
    ++counts.refused;
    const std::string fact = error.what();
    // A library's crash ends with its worker.
    if (fact.find("was stopped by signal") != std::string::npos) ++counts.crashes;
    EXPECT_EQ(fact.find("signal 14"), std::string::npos) << seed.name << ", mutant " << number << ": 10 s were too few";
    EXPECT_NE(static_cast<int>(error.code()), static_cast<int>(ErrorCode::internal))
        << seed.name << ", mutant " << number << ": " << fact;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15)) << seed.name << ", mutant " << number;
  std::map<std::string, std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    left[entry.path().filename()] = read_file(entry.path());
  EXPECT_TRUE(left == files) << seed.name << ", mutant " << number << ": something was written";
}

/// Mutants of each family. Of slices fewer: the worker that reads one loads OpenImageIO, which takes
/// longer than all else.
std::uint64_t count_of_mutants(bool is_slice) {
  const std::uint64_t count = asked_count("RHORAY_MUTANTS", 200);
  return is_slice ? count / 5 : count;
}

class Mutants : public testing::TestWithParam<Seed> {
 protected:
  void SetUp() override { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }
};

TEST_P(Mutants, end_in_a_volume_a_mesh_a_surface_or_an_error) {
  const Seed& seed = GetParam();
  const bool is_slice = seed.name == "a.pgm";  // refused if it is alone, but looked at
  {
    const TemporaryFolder folder;
    for (const auto& [name, content] : seed.files) write_file(folder / name, content);
    if (!is_slice) {
      EXPECT_NO_THROW(read(seed, folder / seed.name)) << "the seed itself must be sound";
    }
  }
  Counts counts;
  const std::uint64_t mutant_count = count_of_mutants(is_slice);
  for (std::uint64_t number = 0; number < mutant_count; ++number) try_mutant(seed, number, counts);
  EXPECT_LT(counts.largest_bytes, cap_bytes + (cap_bytes >> 1)) << "of private memory and of mapped libraries";
  EXPECT_EQ(static_cast<std::uint64_t>(counts.read + counts.refused), mutant_count);
  EXPECT_GT(counts.refused, 0) << "the changes did not reach what is read";
  std::printf("%s: %d read, %d refused, %d readers crashed, at most %.0f MiB\n", seed.name.c_str(), counts.read,
              counts.refused, counts.crashes, static_cast<double>(counts.largest_bytes) / 0x1p20);
}

INSTANTIATE_TEST_SUITE_P(Families, Mutants, testing::ValuesIn(seeds()), [](const auto& test) {
  std::string name = test.param.name;
  std::replace_if(
      name.begin(), name.end(), [](char letter) { return letter == '.'; }, '_');
  return name;
});

}  // namespace
}  // namespace rhoray::preprocess
