#include "formats/macro_levels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"

namespace rhoray::formats {
namespace {

TEST(MacroShape, counts_are_the_leaf_cells_over_the_edge_rounded_up) {
  for (const std::int64_t leaves : {1, 2, 3, 4, 5, 63, 64, 65, 511, 1733})
    for (const std::int64_t factor : {2, 3, 4, 32}) {
      const MacroShape shape{{leaves, 1, 7}, factor, 5};
      for (int level = 0; level <= 5; ++level) {
        const std::int64_t edge = shape.cell_edge(level);
        EXPECT_EQ(shape.count(level).x, (leaves + edge - 1) / edge);
        EXPECT_EQ(shape.count(level).y, 1);
      }
    }
  EXPECT_EQ((MacroShape{{7, 7, 7}, 4, 3}.cell_edge(3)), 64);
}

TEST(MacroLevels, levels_are_found_by_number_and_position) {
  const MacroShape shape{{5, 4, 3}, 2, 2};
  const std::vector<ArraySpec> arrays = macro_arrays(shape, 1, ElementType::I16, "macro.");
  ASSERT_EQ(arrays.size(), 2U);
  EXPECT_EQ(arrays[0].name, "macro.1");
  EXPECT_THAT(arrays[0].shape, testing::ElementsAre(2, 2, 3, 2));
  EXPECT_EQ(arrays[1].name, "macro.2");
  EXPECT_THAT(arrays[1].shape, testing::ElementsAre(1, 1, 2, 2));

  const tests::MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), {.kind = "test"}, arrays);
  std::vector<std::int16_t> first(24), second{1, 2, 3, 4};
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = static_cast<std::int16_t>(100 + i);
  writer.write_all("macro.1", std::span<const std::int16_t>(first));
  writer.write_all("macro.2", std::span<const std::int16_t>(second));
  writer.commit();

  const PackedFile file = PackedFile::from_descriptor(memory.descriptor(), "memory.rho");
  const auto levels = view_macro_levels<std::int16_t>(file, shape, 1, "macro.");
  EXPECT_EQ(levels.range(1, 0, 0, 0), (Interval<std::int16_t>{100, 101}));
  EXPECT_EQ(levels.range(1, 2, 1, 1), (Interval<std::int16_t>{122, 123}));
  EXPECT_EQ(levels.range(2, 1, 0, 0), (Interval<std::int16_t>{3, 4}));

  tests::expect_error(ErrorCode::invalid, "array 'macro.0'",
                      [&] { view_macro_levels<std::int16_t>(file, shape, 0, "macro."); });
  tests::expect_error(ErrorCode::invalid, "array 'macro.1': found I16 [2, 2, 3, 2]; expected U8",
                      [&] { view_macro_levels<std::uint8_t>(file, shape, 1, "macro."); });
}

}  // namespace
}  // namespace rhoray::formats
