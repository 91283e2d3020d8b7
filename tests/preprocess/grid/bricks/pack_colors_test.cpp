#include "preprocess/pack_colors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/colors.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::colors_of;
using tests::expect_error;
using tests::telling_texel;
using tests::TemporaryFolder;

formats::ColorGrid opened(const std::filesystem::path& path) {
  return formats::ColorGrid(formats::PackedFile::open(path));
}

void expect_telling_texels(const formats::ColorGrid& grid) {
  const Index3 n = grid.description().layout.sample_count;
  const auto components = static_cast<std::uint64_t>(grid.description().component_count);
  for (Index3 at{0, 0, 0}; at.z < n.z; ++at.z)
    for (at.y = 0; at.y < n.y; ++at.y)
      for (at.x = 0; at.x < n.x; ++at.x)
        for (std::uint64_t c = 0; c < components; ++c)
          ASSERT_EQ(grid.texels()[components * grid.tables().address(at.x, at.y, at.z) + c], telling_texel(at)[c]);
}

TEST(PackColors, keeps_every_texel_in_every_layout_and_the_frame) {
  const TemporaryFolder folder;
  const Affine world{{0, 0.5, 0}, {-0.25, 0, 0}, {0, 0, 2}, {1, -2, 3.5}};
  for (const int components : {3, 4})
    for (const Index3& count : {Index3(13, 9, 6), Index3(1, 1, 1), Index3(2, 40, 1)})
      for (const std::int64_t edge : {0, 2, 3, 4, 8, 16, 64}) {
        auto colors = colors_of(count, components, telling_texel, world);
        colors.length_unit = "mm";
        const PackColorsReport report = pack_colors(colors, folder / "c.rho",
                                                    {.is_linear = edge == 0,
                                                     .brick_edge = edge == 0 ? 8 : edge,
                                                     .command = "a command",
                                                     .source_name = "slices",
                                                     .replace_existing = true});
        const formats::ColorGrid grid = opened(folder / "c.rho");
        EXPECT_EQ(report.file_bytes, grid.file().file_bytes());
        EXPECT_THAT(grid.file().damaged_blocks(), testing::IsEmpty());
        EXPECT_EQ(grid.description().layout.is_linear(), edge == 0);
        EXPECT_EQ(grid.description().world_from_grid, world);
        EXPECT_EQ(grid.description().length_unit, "mm");
        EXPECT_EQ(grid.description().component_count, components);
        EXPECT_EQ(grid.description().provenance.command, "a command");
        expect_telling_texels(grid);
      }
}

TEST(PackColors, refuses_what_is_no_volume_of_colours) {
  const TemporaryFolder folder;
  const auto refuses = [&](ErrorCode error_code, const std::string& words,
                           const std::function<void(NeutralVolume&)>& spoil, const PackColorsOptions& options = {}) {
    auto colors = colors_of({3, 4, 5}, 3, telling_texel);
    spoil(colors);
    expect_error(error_code, words, [&] { pack_colors(colors, folder / "c.rho", options); });
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  };
  refuses(ErrorCode::invalid, "found 2 components of U8; expected 3 or 4", [](auto& c) { c.component_count = 2; });
  refuses(ErrorCode::invalid, "found 3 components of U16", [](auto& c) { c.type = formats::ElementType::U16; });
  refuses(ErrorCode::invalid, "found 180 bytes of texels; expected 3 x 4 x 6 x 3",
          [](auto& c) { c.sample_count.z = 6; });
  refuses(ErrorCode::invalid, "expected 1 to 1048576 on every axis", [](auto& c) { c.sample_count.x = 0; });
  refuses(ErrorCode::invalid, "span a volume of 0", [](auto& c) { c.world_from_grid.z_axis = {1, 0, 0}; });
  refuses(ErrorCode::unsupported, "uneven spacing", [](auto& c) { c.axes[0] = {0, 1, 3}; });
  refuses(ErrorCode::usage, "brick edge: found 65", [](auto&) {}, {.brick_edge = 65});
}

}  // namespace
}  // namespace rhoray::preprocess
