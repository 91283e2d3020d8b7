#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <sstream>

#include "formats/brick_grid.h"
#include "formats/triangle_mesh.h"
#include "tests/support/made_grid.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"
#include "tests/support/resealed.h"
#include "tests/support/temporary_folder.h"

// SPEC.md and the code agree: the printed bytes are those that the writer makes today.
namespace rhoray::formats {
namespace {

using tests::MemoryFile;

/// The text between a fence that opens with ```<language> and the next fence.
std::string code_block(const std::string& markdown, const std::string& language) {
  const std::string fence = "\n```" + language + "\n";
  const std::size_t start = markdown.find(fence);
  if (start == std::string::npos) throw std::runtime_error("no block of " + language);
  const std::size_t first = start + fence.size();
  return markdown.substr(first, markdown.find("```", first) - first);
}

/// Like `hexdump -C`: sixteen bytes a line; repeated lines are replaced by a star.
std::string dump(const std::string& bytes) {
  std::string text, previous;
  bool starred = false;
  char part[32];
  for (std::size_t at = 0; at < bytes.size(); at += 16) {
    const std::string line = bytes.substr(at, 16);
    if (line == previous && line.size() == 16) {
      if (!starred) text += "*\n";
      starred = true;
      continue;
    }
    starred = false;
    previous = line;
    std::snprintf(part, sizeof part, "%08zx ", at);
    text += part;
    for (std::size_t i = 0; i < 16; ++i) {
      if (i == 8) text += ' ';
      std::snprintf(part, sizeof part, " %02x", static_cast<unsigned char>(line[i % line.size()]));
      text += i < line.size() ? part : "   ";
    }
    text += "  |";
    for (const char c : line) text += c >= 0x20 && c < 0x7f ? c : '.';
    text += "|\n";
  }
  std::snprintf(part, sizeof part, "%08zx\n", bytes.size());
  return text + part;
}

/// The bytes that such a text represents.
std::string undump(const std::string& text) {
  std::istringstream lines(text);
  std::string bytes, line;
  bool repeat = false;
  while (std::getline(lines, line)) {
    if (line == "*") {
      repeat = true;
      continue;
    }
    const std::size_t at = std::stoul(line.substr(0, 8), nullptr, 16);
    const std::string last = bytes.size() >= 16 ? bytes.substr(bytes.size() - 16) : "";
    while (repeat && bytes.size() < at) bytes += last;
    repeat = false;
    if (bytes.size() != at) throw std::runtime_error("the dump leaves bytes out before " + line.substr(0, 8));
    if (line.size() == 8) break;
    std::istringstream pairs(line.substr(8, line.find('|') - 8));
    for (std::string pair; pairs >> pair;) bytes += static_cast<char>(std::stoi(pair, nullptr, 16));
  }
  return bytes;
}

std::string spec() {
  return tests::read_file(RHORAY_SPEC_FILE);
}

/// The grid described in SPEC.md: 2 x 2 x 2 samples i + 10 j + 100 k in the linear layout.
std::string example_written_now() {
  const auto grid = tests::sample_grid<std::uint8_t>(
      BrickLayout::linear({2, 2, 2}),
      [](std::int64_t i, std::int64_t j, std::int64_t k) { return static_cast<std::uint8_t>(i + 10 * j + 100 * k); },
      {.factor = 4, .level_count = 1});
  const MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(grid.description), grid_arrays(grid.description));
  grid.write_into(writer).commit();
  return memory.content();
}

TEST(Spec, prints_the_bytes_that_the_writer_makes) {
  EXPECT_EQ(code_block(spec(), "hexdump"), dump(example_written_now()));
  EXPECT_EQ(undump(code_block(spec(), "hexdump")), example_written_now());
}

TEST(Spec, example_is_read_as_the_text_says) {
  const MemoryFile memory(undump(code_block(spec(), "hexdump")));
  const BrickGrid grid(PackedFile::from_descriptor(memory.descriptor(), "example.rho"));
  EXPECT_THAT(grid.samples<std::uint8_t>(), testing::ElementsAre(0, 1, 10, 11, 100, 101, 110, 111));
  EXPECT_EQ(grid.macro_levels<std::uint8_t>().range(1, 0, 0, 0), (Interval<std::uint8_t>{0, 111}));
  EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
  EXPECT_THAT(deep_findings(grid), testing::IsEmpty());
}

/// The surface described in SPEC.md: one triangle.
std::string surface_written_now() {
  const TriangleMeshDescription description{.length_unit = "mm",
                                            .point_type = ElementType::F32,
                                            .point_count = 3,
                                            .triangle_count = 1,
                                            .bounds = Box3(Vec3(0, 0, 0), Vec3(1, 2, 0)),
                                            .has_source_order = true,
                                            .flat_triangle_count = 0,
                                            .dropped_facet_count = 0,
                                            .unused_point_count = 0,
                                            .provenance = {}};
  const std::array<float, 9> points{0, 0, 0, 1, 0, 0, 0, 2, 0};
  const std::array<std::uint32_t, 3> triangle{0, 1, 2};
  const MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(description), triangle_mesh_arrays(description));
  writer.write("points", 0, std::as_bytes(std::span(points)));
  writer.write("triangles", 0, std::as_bytes(std::span(triangle)));
  writer.commit();
  return memory.content();
}

TEST(Spec, prints_the_bytes_of_a_surface) {
  EXPECT_EQ(code_block(spec(), "hexdump-surface"), dump(surface_written_now()));
  const MemoryFile memory(undump(code_block(spec(), "hexdump-surface")));
  const TriangleMesh surface(PackedFile::from_descriptor(memory.descriptor(), "example.rho"));
  EXPECT_EQ(surface.point(2), (std::array<double, 3>{0, 2, 0}));
  EXPECT_THAT(surface.triangles(), testing::ElementsAre(std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_THAT(deep_findings(surface), testing::IsEmpty());
}

TEST(Spec, checksums_of_the_example_follow_from_the_text_alone) {
  const std::string bytes = undump(code_block(spec(), "hexdump"));
  EXPECT_EQ(tests::seal_again(tests::open_envelope(bytes)), bytes);
}

/// Output of Python with numpy for these lines, run in the folder; empty if there is no Python with
/// numpy.
std::string output_of_python(const std::filesystem::path& folder, const std::string& lines) {
  std::string python;
  for (const std::string& candidate : {std::string("python3"), std::string("/usr/bin/python3")})
    if (python.empty() && std::system((candidate + " -c 'import numpy' 2>/dev/null").c_str()) == 0) python = candidate;
  if (python.empty()) return {};
  tests::write_file(folder / "read.py", lines);
  const std::string command = "cd '" + folder.string() + "' && " + python + " read.py 2>&1";
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return "python does not start";
  std::string output;
  std::array<char, 256> part{};
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) output += part.data();
  EXPECT_EQ(::pclose(pipe), 0);
  return output;
}

TEST(Spec, its_lines_of_numpy_read_an_array) {
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "example.rho", example_written_now());
  const std::string output =
      output_of_python(folder.path(), code_block(spec(), "python") + "print(x.tolist(), x.dtype)\n");
  if (output.empty()) GTEST_SKIP() << "no python3 with numpy here";
  EXPECT_EQ(output, "[[[0, 1], [10, 11]], [[100, 101], [110, 111]]] uint8\n");
}

TEST(Spec, its_lines_of_numpy_read_a_sparse_grid_and_its_axes) {
  // Two and a half bricks along x; the middle one has no data.
  const tests::MadeGrid grid = tests::made_grid(
      {.sample_count = {5, 2, 3}, .brick_edge = 2, .is_sparse = true, .axes = {{{0, 1, 4, 9, 16}, {}, {}}}},
      {{"density", [](std::int64_t i, std::int64_t j, std::int64_t k) {
          return i / 2 == 1 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(i + 10 * j + 100 * k);
        }}});
  const tests::TemporaryFolder folder;
  tests::write_file(folder / "sparse.rho", grid.file());
  const std::string output = output_of_python(
      folder.path(), "import json, numpy as np\n" + code_block(spec(), "python-grid") +
                         "print(x.shape, x[0].tolist(), x[2, 1].tolist())\nprint([p.tolist() for p in positions])\n");
  if (output.empty()) GTEST_SKIP() << "no python3 with numpy here";
  EXPECT_EQ(output,
            "(3, 2, 5) [[0.0, 1.0, nan, nan, 4.0], [10.0, 11.0, nan, nan, 14.0]] [210.0, 211.0, nan, nan, 214.0]\n"
            "[[0.0, 1.0, 4.0, 9.0, 16.0], [0, 1], [0, 1, 2]]\n");
}

}  // namespace
}  // namespace rhoray::formats
