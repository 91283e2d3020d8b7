// Inputs that are pipes or devices: reading them might never end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

/// Runs `rhoray` with these words. The exit code is 124 if it does not end by itself.
RunResult in_time(const Workbench& bench, const std::string& words) {
  return bench.shell("timeout -k 1 20 rhoray " + words);
}

void make_pipe(const Workbench& bench, const char* name) {
  if (::mkfifo((bench / name).c_str(), 0600) != 0) throw std::runtime_error("no pipe");
}

void expect_refusal(const Workbench& bench, const std::string& words, const std::string& fact) {
  SCOPED_TRACE(words);
  const auto before = bench.contents();
  const RunResult run = in_time(bench, words);
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr(fact));
  EXPECT_LE(std::count(run.err.begin(), run.err.end(), '\n'), 2) << "a line of fact and a hint:\n" << run.err;
  EXPECT_EQ(bench.contents(), before);
}

TEST(SpecialFiles, are_refused_by_every_subcommand) {
  const Workbench bench;
  bench.make_ball();
  ASSERT_EQ(bench.rhoray({"render", "ball.rho", "--size", "8x8", "-q", "-o", "a.png"}).exit_code, 0);
  for (const char* name : {"p.rho", "p.nrrd", "p.nhdr", "p.vtk", "p.vtu", "p.vdb", "p.off", "p.png", "p.json", "p.g",
                           "p.raw", "p.dcm", "p"})
    make_pipe(bench, name);
  for (const char* words : {"info p.rho",
                            "info p.nrrd",
                            "info p.vtk",
                            "info p.g",
                            "info p",
                            "info p.dcm",
                            "info p.vdb",
                            "verify p.rho",
                            "render p.rho -o x.png",
                            "render p -o x.png",
                            "render p.json -o x.png",
                            "render p.vdb -o x.png",
                            "render p.vtk -o x.png",
                            "render ball.rho --iso 60 --texture p.rho -o x.png",
                            "pack p.nrrd -o x.rho",
                            "pack p.nhdr -o x.rho",
                            "pack p.vtu -o x.rho",
                            "pack p.off -o x.rho",
                            "pack p.png -o x.rho",
                            "pack p.raw --raw 8x8x8:uint8 -o x.rho",
                            "pack p.vdb -o x.rho",
                            "pack p.nrrd --color -o x.rho",
                            "import p.vtu -o x.vtu",
                            "tetrahedralize p.off -o x.vtu",
                            "resample p.rho --size 8 -o x.rho",
                            "resample p.vtu --size 8 -o x.rho",
                            "export p.rho -o x.vti",
                            "validate p.rho --iso 1",
                            "compare p.png a.png",
                            "compare a.png p.png",
                            "bench views p.rho",
                            "bench pack p.vtu --scratch .",
                            "accuracy p.rho -o out"})
    expect_refusal(bench, words, ": found a pipe; expected a file");
  for (const char* words : {"info /dev/zero", "render /dev/zero -o x.png", "verify /dev/null",
                            "pack /dev/zero --raw 8x8x8:uint8 -o x.rho", "compare a.png /dev/zero"})
    expect_refusal(bench, words, ": found a device; expected a file");
}

/// A header, a scene, an option or a folder names a pipe.
TEST(SpecialFiles, are_refused_where_another_file_names_them) {
  const Workbench bench;
  bench.make_ball();
  make_pipe(bench, "p");
  make_pipe(bench, "p.vtu");
  make_pipe(bench, "p.gz");
  make_pipe(bench, "p.rho");
  write_file(bench / "a.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: p\n");
  write_file(bench / "b.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: gzip\ndata file: p.gz\n");
  write_file(bench / "c.nhdr",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 2\nencoding: raw\ndata file: LIST 2\np\np\n");
  write_file(bench / "a.mhd",
             "ObjectType = Image\nNDims = 3\nDimSize = 8 8 8\nElementType = MET_UCHAR\nElementDataFile = p\n");
  write_file(bench / "a.bov", "DATA_FILE: p\nDATA_SIZE: 8 8 8\nDATA_FORMAT: BYTE\nVARIABLE: a\n");
  write_file(bench / "a.pvtu",
             "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\"><PUnstructuredGrid GhostLevel=\"0\"><PPoints>"
             "<PDataArray type=\"Float32\" NumberOfComponents=\"3\"/></PPoints><Piece Source=\"p.vtu\"/>"
             "</PUnstructuredGrid></VTKFile>");
  write_file(bench / "a.xdmf",
             "<Xdmf><Domain><Grid><Topology TopologyType=\"Tetrahedron\"><DataItem Dimensions=\"1 4\" "
             "NumberType=\"Int\">0 1 2 3</DataItem></Topology><Geometry><DataItem Dimensions=\"4 3\" "
             "Format=\"Binary\">p</DataItem></Geometry></Grid></Domain></Xdmf>");
  write_file(bench / "a.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
  make_pipe(bench, "a.ele");
  write_file(bench / "cube.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  make_pipe(bench, "cube.mtr");
  write_file(bench / "scene.json",
             R"({"data": {"b": {"file": "p.rho"}}, "layers": [{"type": "isosurface", "data": "b", "isovalue": 60}]})");
  for (const char* words : {"info a.nhdr", "info b.nhdr", "info c.nhdr", "pack a.nhdr -o x.rho", "info a.mhd",
                            "pack a.mhd -o x.rho", "info a.bov", "info a.pvtu", "info a.xdmf", "pack a.node -o x.rho",
                            "tetrahedralize cube.off -o x.vtu", "render scene.json -o x.png"})
    expect_refusal(bench, words, ": found a pipe; expected a file");
}

/// Folders of slices: entries that are not files are not slices.
TEST(SpecialFiles, in_folders_are_passed_over) {
  const Workbench bench;
  std::filesystem::create_directory(bench / "slices");
  ASSERT_EQ(::mkfifo((bench / "slices/a1.png").c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo((bench / "slices/a2.dcm").c_str(), 0600), 0);
  std::filesystem::create_symlink("a1.png", bench / "slices/a3.png");
  const RunResult run = in_time(bench, "info slices");
  EXPECT_NE(run.exit_code, 124) << run.err;
  EXPECT_NE(run.exit_code, 0) << run.err;
}

TEST(SpecialFiles, may_be_named_through_links_where_they_are_files) {
  const Workbench bench;
  bench.make_ball();
  EXPECT_EQ(bench.shell("rhoray info /dev/stdin < ball.rho").exit_code, 0);
  const RunResult piped = bench.shell("cat ball.rho | timeout -k 1 20 rhoray info /dev/stdin");
  EXPECT_EQ(piped.exit_code, 3);
  EXPECT_THAT(piped.err, HasSubstr("hint: save what comes through the pipe to a file first"));
}

}  // namespace
}  // namespace rhoray::tests
