#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "formats/base/text.h"
#include "preprocess/process/memory_cap.h"
#include "tests/support/sanitizers.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;
constexpr std::uint64_t cap = preprocess::MemoryCap::smallest_bytes;
constexpr std::uint64_t large_cap = 512 * mebibyte;

/// Anonymous memory of a process (RssAnon), 0 when the process has ended.
std::uint64_t anonymous_bytes(pid_t process) {
  std::ifstream status(concat("/proc/", process, "/status"));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return std::stoull(line.substr(8)) << 10;
  return 0;
}

std::vector<pid_t> children_of(pid_t process) {
  std::vector<pid_t> children;
  std::error_code gone;
  for (const auto& task : fs::directory_iterator(concat("/proc/", process, "/task"), gone)) {
    std::ifstream list(task.path() / "children");
    for (pid_t child = 0; list >> child;) children.push_back(child);
  }
  return children;
}

struct Peaks {
  int exit_code = -1;
  std::uint64_t program = 0, worker = 0;  ///< largest anonymous memory observed
};

/// Starts `rhoray` in the folder, with its messages in the file "said".
pid_t start_rhoray(const fs::path& folder, std::vector<std::string> words) {
  words.insert(words.begin(), RHORAY_PROGRAM);
  const std::string said = (folder / "said").string();
  const pid_t child = ::fork();
  if (child != 0) return child;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (::chdir(folder.c_str()) == 0 && std::freopen(said.c_str(), "w", stderr) != nullptr)
    ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

Peaks watched(const fs::path& folder, const std::vector<std::string>& words) {
  const pid_t program = start_rhoray(folder, words);
  Peaks peaks;
  int status = 0;
  std::error_code gone;
  while (::waitpid(program, &status, WNOHANG) == 0) {
    // Before it becomes another program, the child is a copy of this one with all its memory.
    if (!fs::equivalent(concat("/proc/", program, "/exe"), RHORAY_PROGRAM, gone)) continue;
    peaks.program = std::max(peaks.program, anonymous_bytes(program));
    for (const pid_t worker : children_of(program)) peaks.worker = std::max(peaks.worker, anonymous_bytes(worker));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  peaks.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return peaks;
}

/// Writes two-byte samples whose values do not repeat from slice to slice. Returns their sizes in
/// the format of --raw.
std::string make_large_raw(const fs::path& path, std::uint64_t bytes) {
  constexpr std::size_t nx = 256, ny = 256;
  const std::size_t nz = bytes / (2 * nx * ny) + 1;
  std::ofstream out(path, std::ios::binary);
  std::vector<std::uint16_t> slice(nx * ny);
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::size_t i = 0; i < slice.size(); ++i) slice[i] = static_cast<std::uint16_t>((i % nx) * (i / nx) + 71 * k);
    out.write(reinterpret_cast<const char*>(slice.data()), static_cast<std::streamsize>(slice.size() * 2));
  }
  return concat(nx, "x", ny, "x", nz);
}

/// n^3 cubes of six tetrahedra with two fields, an appended VTU written by hand.
void make_large_vtu(const fs::path& path, std::uint64_t n) {
  const preprocess::NeutralMesh mesh = box_mesh({.cells = Index3(static_cast<std::int64_t>(n))});
  const std::uint64_t points = mesh.points.size(), cells = mesh.cells.size();
  std::string head =
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
      "<UnstructuredGrid><Piece " +
      concat("NumberOfPoints=\"", points, "\" NumberOfCells=\"", cells, "\">");
  std::uint64_t offset = 0;
  const auto array = [&](const char* type, const char* name, int components, std::uint64_t bytes) {
    head += concat("<DataArray type=\"", type, "\" Name=\"", name, "\" NumberOfComponents=\"", components,
                   "\" format=\"appended\" offset=\"", offset, "\"/>");
    offset += 8 + bytes;
  };
  head += "<PointData>";
  array("Float64", "height", 1, 8 * points);
  array("Float64", "place", 3, 24 * points);
  head += "</PointData><Points>";
  array("Float64", "Points", 3, 24 * points);
  head += "</Points><Cells>";
  array("Int64", "connectivity", 1, 32 * cells);
  array("Int64", "offsets", 1, 8 * cells);
  array("UInt8", "types", 1, cells);
  head += "</Cells></Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_";

  std::ofstream out(path, std::ios::binary);
  const auto put = [&](const void* values, std::uint64_t bytes) {
    out.write(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    out.write(static_cast<const char*>(values), static_cast<std::streamsize>(bytes));
  };
  std::vector<double> heights;
  for (const auto& point : mesh.points) heights.push_back(point[2]);
  std::vector<std::uint64_t> ends;
  for (std::uint64_t c = 0; c < cells; ++c) ends.push_back(4 * (c + 1));
  out << head;
  put(heights.data(), 8 * points);
  put(mesh.points.data(), 24 * points);
  put(mesh.points.data(), 24 * points);
  put(mesh.cells.data(), 32 * cells);
  put(ends.data(), 8 * cells);
  put(std::string(cells, '\12').data(), cells);
  out << "</AppendedData></VTKFile>";
}

class MemoryCapOfPack : public testing::Test {
 protected:
  /// Packs with and without the cap. Expects the same bytes, and at most a tenth more anonymous
  /// memory than the cap.
  /// @param least_bytes  minimum expected size of the packed file
  void expect_the_cap_holds(const std::vector<std::string>& words, std::uint64_t least_bytes = 8 * cap,
                            std::uint64_t limit = cap) {
    std::vector<std::string> command{"pack"};
    command.insert(command.end(), words.begin(), words.end());
    command.insert(command.end(), {"-o", "packed.rho", "--force"});
    const Peaks free = watched(bench_.path(), command);
    ASSERT_EQ(free.exit_code, 0) << read_file(bench_ / "said");
    fs::rename(bench_ / "packed.rho", bench_ / "free.rho");
    EXPECT_GE(fs::file_size(bench_ / "free.rho"), least_bytes);

    command.insert(command.end(), {"--memory", concat(limit / mebibyte, "M")});
    const Peaks capped = watched(bench_.path(), command);
    ASSERT_EQ(capped.exit_code, 0) << read_file(bench_ / "said");
    EXPECT_LE(capped.program, limit + limit / 10);
    EXPECT_LE(capped.worker, limit + limit / 10);
    EXPECT_GT(capped.program, 0U) << "the program was never seen";
    EXPECT_GT(capped.worker, 0U) << "its worker was never seen";
    EXPECT_EQ(bench_.shell("cmp free.rho packed.rho").exit_code, 0);
    free_ = free;
  }

  Workbench bench_;
  Peaks free_;
};

TEST_F(MemoryCapOfPack, holds_for_a_volume_eight_times_as_large) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  const std::string sizes = make_large_raw(bench_ / "large.raw", 8 * cap);
  expect_the_cap_holds({"large.raw", "--raw", sizes + ":uint16:le"});
}

TEST_F(MemoryCapOfPack, holds_for_a_volume_that_is_turned_round_and_stored_as_another_type) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  const std::string sizes = make_large_raw(bench_ / "large.raw", 4 * cap);
  expect_the_cap_holds({"large.raw", "--raw", sizes + ":uint16:be", "--type", "F32"});
  EXPECT_GT(free_.program, 8 * cap) << "the cap was not needed here";
}

TEST_F(MemoryCapOfPack, holds_for_a_mesh_eight_times_as_large) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  make_large_vtu(bench_ / "large.vtu", 62);
  expect_the_cap_holds({"large.vtu"}, cap);
  EXPECT_GT(free_.program, 4 * cap) << "the cap was not needed here";
  expect_the_cap_holds({"large.vtu", "--structure", "leaves"});
  EXPECT_GT(free_.program, 4 * cap) << "the cap was not needed here";
  EXPECT_GT(free_.worker, 4 * cap) << "the cap was not needed here";
}

/// 4 GiB come in and 4 GiB go out: with the copy for comparison, 12 GiB of disk.
TEST_F(MemoryCapOfPack, holds_for_a_volume_eight_times_half_a_gibibyte) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  if (std::getenv("RHORAY_LARGE_FILES") == nullptr) GTEST_SKIP() << "RHORAY_LARGE_FILES is not set (tests/nightly)";
  const std::string sizes = make_large_raw(bench_ / "large.raw", 8 * large_cap);
  expect_the_cap_holds({"large.raw", "--raw", sizes + ":uint16:le"}, 8 * large_cap, large_cap);
}

/// Small files of every kind that is processed in its own way under a cap.
TEST_F(MemoryCapOfPack, changes_no_byte) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  preprocess::NeutralMesh mesh = box_mesh({.cells = Index3(24, 25, 26), .jitter = 0.1});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  add_point_field(
      mesh, "length", [](const Vec3& p) { return p.length(); }, true);
  preprocess::NeutralField tissue{
      .name = "tissue", .unit = "", .component_count = 1, .was_single_precision = true, .values = {}};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) tissue.values.push_back(static_cast<double>(c % 7));
  mesh.cell_fields.push_back(tissue);
  mesh.cells[100][3] = mesh.cells[100][0];  // will be dropped
  mesh.points.push_back({9, 9, 9});         // belongs to no cell
  for (preprocess::NeutralField& field : mesh.point_fields) field.values.push_back(0.5);
  preprocess::export_mesh(mesh, bench_ / "mesh.vtu", false);

  std::mt19937 random(7);
  std::string noise(std::size_t{3} * 67 * 129 * 131, '\0');
  for (char& byte : noise) byte = static_cast<char>(random() % 5);
  write_file(bench_ / "plain.raw", noise);
  const std::string sizes = "dimension: 3\nsizes: 67 129 131\n";
  write_file(bench_ / "attached.nrrd",
             "NRRD0004\ntype: uchar\n" + sizes + "encoding: raw\n\n" + noise.substr(0, 67 * 129 * 131));
  write_file(bench_ / "samples.raw", noise.substr(0, 2 * 67 * 129 * 131));
  bench_.shell("gzip -k -c samples.raw > samples.raw.gz");
  write_file(bench_ / "packed.nhdr",
             "NRRD0004\ntype: short\nendian: big\n" + sizes + "encoding: gzip\ndata file: samples.raw.gz\n");
  write_file(bench_ / "meta.mhd",
             "ObjectType = Image\nNDims = 3\nDimSize = 67 129 131\nElementType = MET_SHORT\n"
             "ElementDataFile = samples.raw\n");

  const std::vector<std::vector<std::string>> inputs{{"mesh.vtu"},
                                                     {"mesh.vtu", "--cell-data", "--field", "length,tissue"},
                                                     {"plain.raw", "--raw", "67x129x131:uint8"},
                                                     {"plain.raw", "--raw", "67x129x131:int16:be:1"},
                                                     {"plain.raw", "--raw", "67x129x131:uint8", "--type", "F64"},
                                                     {"plain.raw", "--raw", "67x129x131:int8", "--layout", "linear"},
                                                     {"attached.nrrd"},
                                                     {"packed.nhdr"},
                                                     {"meta.mhd", "--type", "I32"}};
  for (const std::vector<std::string>& input : inputs) {
    SCOPED_TRACE(testing::PrintToString(input));
    std::vector<std::string> command{"pack"};
    command.insert(command.end(), input.begin(), input.end());
    command.insert(command.end(), {"-o", "packed.rho", "--force"});
    const RunResult free = bench_.rhoray(command);
    ASSERT_EQ(free.exit_code, 0) << free.err;
    const std::string bytes = read_file(bench_ / "packed.rho");
    command.insert(command.end(), {"--memory", concat(cap / mebibyte, "M")});
    const RunResult capped = bench_.rhoray(command);
    ASSERT_EQ(capped.exit_code, 0) << capped.err;
    EXPECT_TRUE(read_file(bench_ / "packed.rho") == bytes) << "other bytes";
  }
}

/// The operating system enforces the limit, so it stops a reader that does not stream.
TEST_F(MemoryCapOfPack, stops_a_reader_that_needs_more) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  // A block is unpacked as a whole, and each of these has 50 MiB.
  constexpr std::uint64_t blocks = 4, block_bytes = 50 * mebibyte, packed_bytes = mebibyte;
  const std::string head =
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
      "compressor=\"vtkLZ4DataCompressor\"><ImageData WholeExtent=\"0 1023 0 1023 0 199\" Origin=\"0 0 0\" "
      "Spacing=\"1 1 1\"><Piece Extent=\"0 1023 0 1023 0 199\"><PointData><DataArray type=\"UInt8\" Name=\"a\" "
      "format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData><AppendedData encoding=\"raw\">_";
  std::string sizes;
  for (const std::uint64_t size :
       {blocks, block_bytes, std::uint64_t{0}, packed_bytes, packed_bytes, packed_bytes, packed_bytes})
    sizes.append(reinterpret_cast<const char*>(&size), sizeof size);
  write_file(bench_ / "a.vti", head + sizes);
  fs::resize_file(bench_ / "a.vti", head.size() + sizes.size() + blocks * packed_bytes);
  const RunResult refused = bench_.rhoray({"pack", "a.vti", "-o", "a.rho", "--memory", concat(cap / mebibyte, "M")});
  EXPECT_EQ(refused.exit_code, 5) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("a.vti"));
  EXPECT_THAT(refused.err, HasSubstr("memory"));
  EXPECT_FALSE(fs::exists(bench_ / "a.rho"));
}

TEST_F(MemoryCapOfPack, refuses_less_than_programs_take_by_themselves) {
  bench_.make_ball_raw();
  const RunResult refused =
      bench_.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "-o", "ball.rho", "--memory", "15M"});
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("at least 16M"));
}

TEST_F(MemoryCapOfPack, leaves_nothing_behind_when_it_is_interrupted_or_killed) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  make_large_vtu(bench_ / "large.vtu", 40);
  const std::vector<std::string> command{"pack", "large.vtu", "-o", "a.rho", "--memory", concat(cap / mebibyte, "M")};
  int stopped = 0;
  for (const int signal : {SIGINT, SIGKILL, SIGTERM})
    for (const int delay_ms : {30, 120, 250}) {
      const pid_t program = start_rhoray(bench_.path(), command);
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      ::kill(program, signal);
      int status = 0;
      ::waitpid(program, &status, 0);
      fs::remove(bench_ / "said");
      if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {  // it had finished
        EXPECT_TRUE(fs::remove(bench_ / "a.rho"));
        continue;
      }
      ++stopped;
      std::vector<std::string> files;
      for (const auto& entry : fs::directory_iterator(bench_.path())) files.push_back(entry.path().filename());
      EXPECT_THAT(files, testing::ElementsAre("large.vtu"));
    }
  EXPECT_GT(stopped, 0) << "it was never stopped in the middle of its work";
}

}  // namespace
}  // namespace rhoray::tests
