// Broken files of every format that is read: each line of the message is the program's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <sstream>

#include "formats/base/text.h"
#include "formats/packed_file.h"
#include "formats/vdb_grid.h"
#include "preprocess/input_file.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using namespace std::string_literals;
using testing::HasSubstr;

struct BrokenFile {
  std::string name, content;
};

/// A word of 4 bytes, lowest byte first.
std::string word(std::uint32_t number) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> 8 * i & 255);
  return bytes;
}

std::string noise(std::size_t size) {
  std::string bytes;
  std::uint32_t state = 26;
  for (std::size_t i = 0; i < size; ++i) {
    state = 1664525 * state + 1013904223;
    bytes += static_cast<char>(state >> 24);
  }
  return bytes;
}

/// Files that start as their readers expect, and then end early or hold invalid data.
std::vector<BrokenFile> broken_files() {
  const std::string nrrd = "NRRD0004\ntype: short\nendian: little\ndimension: 3\n";
  const std::string nrrd_gzip = nrrd + "sizes: 3 4 5\nencoding: gzip\n\n",
                    gzip_beginning = "\x1f\x8b\x08\0\0\0\0\0\0\3"s;
  const std::string vtk = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET ";
  const std::string meta = "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\nElementType = MET_SHORT\n";
  const std::string xml = "<VTKFile version=\"1.0\" byte_order=\"LittleEndian\" type=";
  const std::string dicom = std::string(128, '\0') + "DICM";
  const std::string vdb = word(0x56444220) + word(0), zip = "PK\3\4" + noise(200);
  std::string png = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x10\0\0\0\x10\x08\2\0\0\0"s;
  std::vector<BrokenFile> files{
      {"type.nrrd", nrrd + "sizes: 3 4 5\ntype: shrt\nencoding: raw\n\n"},
      {"value.nrrd", nrrd + "sizes: 3 four 5\nencoding: raw\n\n" + noise(120)},
      {"key.nrrd", nrrd + "sizes: 3 4 5\ncolour: blue\nencoding: raw\n\n" + noise(120)},
      {"cut.nrrd", nrrd},
      {"gzip.nrrd", nrrd_gzip + noise(60)},
      {"packed.nrrd", nrrd_gzip + gzip_beginning + noise(120)},
      {"bzip2.nrrd", nrrd + "sizes: 3 4 5\nencoding: bzip2\n\nBZh9" + noise(120)},
      {"hex.nrrd", nrrd + "sizes: 3 4 5\nencoding: hex\n\n" + std::string(300, 'z')},
      {"text.nrrd", nrrd + "sizes: 3 4 5\nencoding: ascii\n\n1 2 3 four " + std::string(200, ' ')},
      {"version.nrrd", "NRRD0009\ntype: short\n"},
      {"alone.nhdr", nrrd + "sizes: 3 4 5\nencoding: raw\ndata file: missing.raw\n"},
      {"list.nhdr", nrrd + "sizes: 3 4 5\nencoding: raw\ndata file: LIST 2\nmissing.raw\n"},
      {"alone.mhd", meta + "ElementDataFile = missing.raw\n"},
      {"packed.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" + noise(60)},
      {"cut.nii", word(348) + std::string(100, '\0')},
      {"packed.nii.gz", gzip_beginning + noise(200)},
      {"cut.npy", "\x93NUMPY\1\0v\0{'descr': '<i2', 'fortran"s},
      {"zip.npz", zip},
      {"cut.mat", "MATLAB 5.0 MAT-file" + std::string(105, ' ') + "\0\1IM"s + word(15) + word(900) + noise(40)},
      {"hdf5.mat", "MATLAB 7.3 MAT-file" + std::string(493, ' ') + "\x89HDF\r\n\x1a\n"s + noise(60)},
      {"cut.vti", xml + "\"ImageData\"><ImageData WholeExtent=\"0 2 0 3 0 4\"><Piece"},
      {"number.vtr",
       xml + "\"RectilinearGrid\"><RectilinearGrid WholeExtent=\"0 2 0 x 0 4\"></RectilinearGrid></VTKFile>"},
      {"piece.pvti", xml + "\"PImageData\"><PImageData WholeExtent=\"0 2 0 3 0 4\"><Piece Extent=\"0 2 0 3 0 4\" "
                           "Source=\"missing.vti\"/></PImageData></VTKFile>"},
      {"cut.pvtr", xml + "\"PRectilinearGrid\"><PRectilinearGrid"},
      {"number.vtk", vtk + "STRUCTURED_POINTS\nDIMENSIONS 3 4 five\n"},
      {"mesh.vtk", vtk + "UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1"},
      {"surface.vtk", vtk + "POLYDATA\nPOINTS 1 double\n0 0 0\nPOLYGONS 1 4\n3 0 1 2\n"},
      {"cut.dcm", dicom + "\x02\0\0\0UL\4\0\x90"s},
      {"noise.ima", dicom + noise(300)},
      {"pixels.dcm", dicom + "\xe0\x7f\x10\0OW\0\0"s + word(0xffffffff) + noise(100)},
      {"zip.zip", zip},
      {"cut.slc", "11111\n3 4 5 8\n0.5 1"},
      {"cut.cube", "title\nsecond line\n1 1 2 3\n3 0.5 0.1 0\n4 0"},
      {"cut.bov", "DATA_FILE: missing.raw\nDATA_SIZE: 3 4 5\n"},
      {"cut.png", png},
      {"noise.tif", "II*\0\x08\0\0\0"s + noise(100)},
      {"noise.tiff", "MM\0*\0\0\0\x08"s + noise(100)},
      {"cut.jpg", "\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\0"s},
      {"noise.jpeg", "\xff\xd8\xff"s + noise(100)},
      {"cut.bmp", "BM" + noise(20)},
      {"cut.pgm", "P5\n3 4\n255\n\7"},
      {"cut.ppm", "P6\n3 "},
      {"magic.vdb", noise(100)},
      {"version.vdb", vdb + word(999999) + noise(100)},
      {"cut.vdb", vdb + word(224) + word(9) + word(1)},
      {"noise.vdb", vdb + word(224) + word(9) + word(1) + '\1' + noise(400)},
      {"cut.vtu", xml + "\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\""},
      {"piece.pvtu", xml +
                         "\"PUnstructuredGrid\"><PUnstructuredGrid><Piece Source=\"missing.vtu\"/></PUnstructuredGrid>"
                         "</VTKFile>"},
      {"cut.xdmf", "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\"><Domain><Grid Name=\"a\"><Topology"},
      {"alone.xmf",
       "<Xdmf><Domain><Grid><Topology TopologyType=\"Tetrahedron\"><DataItem Dimensions=\"1 4\" Format=\"HDF\">"
       "missing.h5:/cells</DataItem></Topology><Geometry><DataItem Dimensions=\"4 3\">0 0 0 1 0 0 0 1 0 0 0 "
       "1</DataItem>"
       "</Geometry></Grid></Domain></Xdmf>"},
      {"lattice.xmf",
       "<Xdmf><Domain><Grid><Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"5 4 3\"/><Geometry "
       "GeometryType=\"ORIGIN_DXDYDZ\"><DataItem Dimensions=\"3\">0 0"},
      {"cut.vts", xml + "\"StructuredGrid\"><StructuredGrid WholeExtent=\"0 1 0 1"},
      {"cut.pvts", xml + "\"PStructuredGrid\"><PStructuredGrid"},
      {"alone.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1"},
      {"alone.ele", "1 4 0\n1 1 2 3 4\n"},
      {"alone.pts", "2\n0 0 0\n1"},
      {"alone.elem", "1\nTt 0 1 2 3\n"},
      {"alone.tet", "1\n0 1 2 3\n"},
      {"cut.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1"},
      {"cut.vol", "mesh3d\ndimension\n3\nvolumeelements\n1\n7 4 1"},
      {"cut.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0"},
      {"noise.meshb", word(1) + word(2) + noise(100)},
      {"cut.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"},
      {"packed.ply.gz", gzip_beginning + noise(100)},
      {"cut.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0"},
      {"packed.stl.gz", gzip_beginning + noise(100)},
      {"cut.obj", "v 0 0 0\nv 1 0\n"},
      {"packed.obj.gz", gzip_beginning + noise(100)},
      {"cut.off", "OFF\n4 4 0\n0 0 0\n"},
      {"cut.tri", "- 4\n0 0 0 0 0 1\n1 0"},
      {"cut.poly", "4 3 0 0\n1 0 0 0\n2 1 0"},
      {"cut.smesh", "0 3 0 0\n4 0\n"},
      {"cut.face", "1 0\n1 1 2 3\n"}};
  for (const std::string extension : {".e", ".ex2", ".exo", ".exii", ".gen"}) {
    files.push_back({"classic" + extension, "CDF\1\0\0\0\0\0\0\0\x0a\0\0\0\2"s + noise(60)});
    files.push_back({"hdf5" + extension, "\x89HDF\r\n\x1a\n"s + noise(100)});
  }
  for (const std::string extension : {".vtkhdf", ".hdf"}) {
    files.push_back({"noise" + extension, "\x89HDF\r\n\x1a\n"s + noise(100)});
    for (const std::string type : {"ImageData", "UnstructuredGrid"})
      files.push_back({type + extension, "\x89HDF\r\n\x1a\n"s + noise(100) + "VTKHDF" + noise(20) + type + noise(50)});
  }
  for (const std::string extension : {".bin", ".xyz", ".x", ".g", ".q", ".p3d"})
    files.push_back({"cut" + extension, word(2) + word(2) + word(2) + noise(20)});
  return files;
}

/// Requires the program's own message: one line that names the file, and at most a hint.
void expect_our_lines(const RunResult& run, const std::string& command, const std::string& name) {
  EXPECT_EQ(run.out, "") << name;
  EXPECT_TRUE(std::set({3, 4, 5, 7}).contains(run.exit_code)) << name << ": exit code " << run.exit_code;
  std::istringstream lines(run.err);
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("rhoray " + command + ": ")) << name << ": " << run.err;
  EXPECT_THAT(line, HasSubstr(name.substr(0, name.rfind('.'))));  // perhaps of a file beside it
  EXPECT_THAT(line, testing::AnyOf(HasSubstr("expected"), HasSubstr("unsupported file type"),
                                   HasSubstr("does not fit the file type"), HasSubstr("No such file"),
                                   HasSubstr("was stopped by signal")));
  for (const char* mark : {"[nrrd]", "ERROR", "Error:", "openvdb::", "VTK", "Exception", "std::", "0x", "last output"})
    EXPECT_THAT(line, testing::Not(HasSubstr(mark)));
  if (std::getline(lines, line)) {
    EXPECT_TRUE(line.starts_with("hint: ")) << name << ": " << run.err;
  }
  EXPECT_FALSE(std::getline(lines, line)) << name << ": " << run.err;
}

TEST(BrokenFiles, of_every_format_are_refused_in_our_words) {
  const Workbench bench;
  std::set<std::string> extensions;
  for (const BrokenFile& file : broken_files()) {
    write_file(bench / file.name, file.content);
    extensions.insert(file.name.substr(file.name.find('.')));
    expect_our_lines(bench.rhoray({"info", file.name}), "info", file.name);
  }
  for (const preprocess::ForeignFormat& format : preprocess::foreign_formats())
    for (const std::string_view family : format.families)
      EXPECT_TRUE(family.ends_with('/') || extensions.contains(std::string(family))) << family << " is not tested";
}

/// Folders of slices and images, too, and other commands that read foreign files.
TEST(BrokenFiles, are_refused_in_our_words_by_other_commands) {
  const Workbench bench;
  std::filesystem::create_directory(bench / "slices");
  std::filesystem::create_directory(bench / "series");
  for (const BrokenFile& file : broken_files()) {
    write_file(bench / file.name, file.content);
    if (file.name.ends_with(".png") || file.name.ends_with(".pgm"))
      write_file(bench / "slices" / file.name, file.content);
    if (file.name.ends_with(".dcm")) write_file(bench / "series" / file.name, file.content);
  }
  for (const std::string name : {"slices", "series", "gzip.nrrd", "noise.vdb"}) {
    expect_our_lines(bench.rhoray({"pack", name, "-o", "x.rho"}), "pack", name);
    expect_our_lines(bench.rhoray({"render", name, "-o", "x.png"}), "render", name);
  }
  expect_our_lines(bench.rhoray({"import", "hdf5.exo", "-o", "x.vtu"}), "import", "hdf5.exo");
  expect_our_lines(bench.rhoray({"tetrahedralize", "cut.stl", "-o", "x.vtu"}), "tetrahedralize", "cut.stl");
}

TEST(BrokenFiles, show_what_a_library_says_with_v) {
  const Workbench bench;
  for (const BrokenFile& file : broken_files())
    if (file.name == "bzip2.nrrd") write_file(bench / file.name, file.content);
  const RunResult verbose = bench.rhoray({"info", "bzip2.nrrd", "-v"});
  EXPECT_THAT(verbose.err, HasSubstr("library: [nrrd] nrrdLoad: trouble reading"));
  EXPECT_THAT(verbose.err, HasSubstr("\nrhoray info: bzip2.nrrd, samples: found damaged data"));
}

TEST(BrokenFiles, name_the_line_of_a_header) {
  const Workbench bench;
  for (const BrokenFile& file : broken_files()) write_file(bench / file.name, file.content);
  const auto err = [&](const std::string& name) { return bench.rhoray({"info", name}).err; };
  EXPECT_THAT(err("type.nrrd"), HasSubstr("type.nrrd, line 6: found a second key 'type'; expected each key once"));
  EXPECT_THAT(err("value.nrrd"),
              HasSubstr("line 5: found 'sizes: 3 four 5'; expected a value that the key 'sizes' takes"));
  EXPECT_THAT(err("key.nrrd"), HasSubstr("line 6: found 'colour: blue'; expected a key of NRRD files"));
  EXPECT_THAT(err("cut.nrrd"), HasSubstr("header: found no key 'sizes'"));
  EXPECT_THAT(err("version.nrrd"), HasSubstr("found 'NRRD0009'; expected NRRD0001 to NRRD0005"));
  EXPECT_THAT(err("alone.nhdr"), HasSubstr("key data file: found no file 'missing.raw'"));
  EXPECT_THAT(err("version.vdb"), HasSubstr("byte 8: found version 999999 of the format; expected at most "));
}

/// Real files, cut and with bytes overwritten in the middle.
TEST(BrokenFiles, of_real_data_are_refused_in_our_words) {
  const char* shared = std::getenv("RHORAY_SHARED_DATA");
  if (shared == nullptr) GTEST_SKIP() << "RHORAY_SHARED_DATA names no folder";
  const std::filesystem::path folder(shared);
  const Workbench bench;
  for (const char* file : {"vdb/oiio_sphere.vdb", "unstructured/biplane_rms_pressure_bs.exo",
                           "unstructured/disk_out_ref.ex2", "unstructured/can.vtu", "unstructured/office.binary.vtk"}) {
    const std::string content = read_file(folder / file), name = std::filesystem::path(file).filename();
    write_file(bench / name, content.substr(0, content.size() / 2));
    expect_our_lines(bench.rhoray({"info", name}), "info", name);
    std::string damaged = content;
    damaged.replace(content.size() / 3, 200, noise(200));
    write_file(bench / name, damaged);
    const RunResult run = bench.rhoray({"info", name});
    if (run.exit_code != 0) expect_our_lines(run, "info", name);
  }
}

/// A file that is made from damaged data has a valid seal, which hides the damage.
TEST(DamagedPackedFile, is_not_converted) {
  const Workbench bench;
  bench.make_box();
  bench.make_ball();
  for (const char* name : {"box.rho", "ball.rho"}) {
    std::string bytes = read_file(bench / name);
    bytes[bytes.size() / 2] ^= 0x40;
    write_file(bench / name, bytes);
    ASSERT_EQ(bench.rhoray({"verify", name}).exit_code, 4) << name;
  }
  const std::vector<std::vector<std::string>> commands{{"export", "ball.rho", "-o", "out.npy"},
                                                       {"export", "ball.rho", "-o", "out.nii"},
                                                       {"export", "box.rho", "-o", "out.stl"},
                                                       {"export", "box.rho", "-o", "out.vtu"},
                                                       {"resample", "box.rho", "--size", "8", "-o", "out.rho"},
                                                       {"info", "box.rho", "--stats"}};
  for (const std::vector<std::string>& words : commands) {
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 4) << words[0] << " " << words.back() << run.out;
    EXPECT_THAT(run.err, HasSubstr("are damaged (array")) << words[0];
    EXPECT_FALSE(std::filesystem::exists(bench / words.back())) << words.back();
  }
}

/// `verify` refuses a kind that it cannot check. The kind "vdb" only passes between processes: its
/// readers follow a tree without checking it.
TEST(PackedFile, of_a_kind_that_no_file_has_is_refused) {
  const Workbench bench;
  formats::VdbGridDescription grid;
  grid.field = {.name = "f", .unit = {}, .type = formats::ElementType::F32, .range = {0, 1}, .histogram = {1}};
  const formats::FileDescription vdb = formats::describe(grid);
  for (const char* kind : {"vdb", "foo"}) {
    formats::FileDescription description = vdb;
    description.kind = kind;
    formats::PackedFileWriter writer(bench / "kind.rho", description,
                                     {{.name = "nanovdb", .type = formats::ElementType::U8, .shape = {64}}},
                                     {.replace_existing = true});
    writer.write_all("nanovdb", std::span<const std::uint8_t>(std::vector<std::uint8_t>(64)));
    writer.commit();
    const RunResult checked = bench.rhoray({"verify", "kind.rho", "--deep"});
    EXPECT_EQ(checked.exit_code, 7) << checked.out;
    EXPECT_THAT(checked.err, HasSubstr(concat("kind '", kind, "'; expected"))) << checked.err;
    const RunResult drawn = bench.rhoray({"render", "kind.rho"});
    EXPECT_EQ(drawn.exit_code, 7) << drawn.out;
    EXPECT_THAT(drawn.err, HasSubstr(concat("kind '", kind, "'; expected"))) << drawn.err;
  }
}

}  // namespace
}  // namespace rhoray::tests
