#include "formats/color_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/resealed.h"

namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::MemoryFile;

ColorGridDescription described(int component_count = 3) {
  return {.layout = BrickLayout::bricked({5, 3, 1}, 2, 2),
          .world_from_grid = {{0, 0.5, 0}, {-0.25, 0, 0}, {0, 0, 2}, {1, -2, 3.5}},
          .length_unit = "mm",
          .component_count = component_count,
          .provenance = {.source_name = "slices", .source_checksum = {}, .command = "made"}};
}

std::uint8_t component_at(std::int64_t i, std::int64_t j, std::int64_t k, std::uint64_t c) {
  return static_cast<std::uint8_t>(i + 10 * j + 100 * k + 50 * static_cast<std::int64_t>(c));
}

std::string made(const ColorGridDescription& d) {
  std::uint64_t count = static_cast<std::uint64_t>(d.component_count);
  for (const std::uint64_t n : d.layout.shape()) count *= n;
  std::string texels(count, '\0');
  const AxisTables tables(d.layout);
  const Index3 n = d.layout.sample_count;
  const auto components = static_cast<std::uint64_t>(d.component_count);
  for (std::int64_t k = 0; k < n.z; ++k)
    for (std::int64_t j = 0; j < n.y; ++j)
      for (std::int64_t i = 0; i < n.x; ++i)
        for (std::uint64_t c = 0; c < components; ++c)
          texels[components * tables.address(i, j, k) + c] = static_cast<char>(component_at(i, j, k, c));
  const MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(d), color_grid_arrays(d));
  writer.write("texels", 0, std::as_bytes(std::span(texels)));
  writer.commit();
  return memory.content();
}

ColorGrid opened(const std::string& bytes) {
  const MemoryFile memory(bytes);
  return ColorGrid(PackedFile::from_descriptor(memory.descriptor(), "c.rho"));
}

TEST(ColorGrid, is_read_as_it_was_written) {
  for (const int components : {3, 4}) {
    const ColorGrid grid = opened(made(described(components)));
    EXPECT_EQ(grid.file().version(), "1.4");
    const ColorGridDescription& d = grid.description();
    EXPECT_EQ(d.layout, described().layout);
    EXPECT_EQ(d.world_from_grid, described().world_from_grid);
    EXPECT_EQ(d.length_unit, "mm");
    EXPECT_EQ(d.component_count, components);
    EXPECT_EQ(d.has_alpha(), components == 4);
    EXPECT_EQ(d.provenance.source_name, "slices");
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 5; ++i)
        for (std::uint64_t c = 0; c < static_cast<std::uint64_t>(components); ++c)
          EXPECT_EQ(grid.texels()[static_cast<std::uint64_t>(components) * grid.tables().address(i, j, 0) + c],
                    component_at(i, j, 0, c));
  }
}

TEST(ColorGrid, keeps_its_space) {
  ColorGridDescription d = described();
  d.space = Space::ras;
  const ColorGrid grid = opened(made(d));
  EXPECT_EQ(grid.file().version(), "1.6");
  EXPECT_EQ(grid.description().space, Space::ras);
}

TEST(ColorGrid, reaches_half_a_step_beyond_its_texels) {
  const ColorGridDescription d = described();
  EXPECT_EQ(d.box_grid(), Box3(Vec3(-0.5, -0.5, -0.5), Vec3(4.5, 2.5, 0.5)));
  // World x decreases with j, world y increases with i.
  EXPECT_EQ(d.bounds(), Box3(Vec3(1 - 0.25 * 2.5, -2 - 0.25, 2.5), Vec3(1 + 0.25 * 0.5, -2 + 0.5 * 4.5, 4.5)));
}

TEST(ColorGrid, refuses_a_file_that_ends_too_soon) {
  const std::string bytes = made(described());
  for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{100}})
    expect_error(ErrorCode::invalid, "c.rho", [&] { opened(bytes.substr(0, size)); });
}

/// Changes content and recomputes valid checksums.
void expect_refusal(const std::string& from, const std::string& to, const std::string& words) {
  tests::Envelope parts = tests::open_envelope(made(described()));
  const std::size_t at = parts.json.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  parts.json.replace(at, from.size(), to);
  expect_error(ErrorCode::invalid, words, [&] { opened(tests::seal_again(parts)); });
}

TEST(ColorGrid, refuses_descriptions_that_do_not_fit_the_texels) {
  expect_refusal(R"(\"component_count\":3)", R"(\"component_count\":4)", "array 'texels'");
  expect_refusal(R"(\"component_count\":3)", R"(\"component_count\":2)", "component_count");
  expect_refusal(R"(\"component_count\":3)", R"(\"component_count\":5)", "component_count");
  expect_refusal(R"(\"sample_count\":[5,3,1])", R"(\"sample_count\":[5,3,9])", "array 'texels'");
  expect_refusal(R"(\"sample_count\":[5,3,1])", R"(\"sample_count\":[5,3,0])", "sample_count");
  expect_refusal(R"(\"sample_count\":[5,3,1])", R"(\"sample_count\":[5,3,9999999])", "sample_count");
  expect_refusal(R"(\"brick_edge\":2)", R"(\"brick_edge\":65)", "brick_edge");
  expect_refusal(R"(\"z_axis\":[0.0,0.0,2.0])", R"(\"z_axis\":[0.0,1.0,0.0])", "axes that span a volume");
  expect_refusal(R"("kind":"colors")", R"("kind":"grid")", "'colors'");
}

}  // namespace
}  // namespace rhoray::formats
