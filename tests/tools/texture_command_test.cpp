#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/color_grid.h"
#include "tests/support/sanitizers.h"
#include "tests/tools/workbench.h"

/// Colours from pictures to a picture: pack --color, info, verify, render --texture.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

std::array<std::uint8_t, 4> texel(int i, int j, int k) {
  return {static_cast<std::uint8_t>(10 * i), static_cast<std::uint8_t>(100 + j), static_cast<std::uint8_t>(200 + k),
          static_cast<std::uint8_t>(250 - k)};
}

/// A folder of slices of 5 x 4 pixels.
void make_slices(const std::filesystem::path& folder, const std::string& extension, int components, int count) {
  std::filesystem::create_directory(folder);
  for (int k = 0; k < count; ++k) {
    std::vector<std::uint8_t> pixels;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i)
        for (int c = 0; c < components; ++c) pixels.push_back(texel(i, j, k)[static_cast<std::size_t>(c)]);
    const std::string path = (folder / concat("s", k + 1, extension)).string();
    OIIO::ImageSpec spec(5, 4, components, OIIO::TypeDesc::UINT8);
    spec["oiio:UnassociatedAlpha"] = 1;
    const auto out = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(out && out->open(path, spec) && out->write_image(OIIO::TypeDesc::UINT8, pixels.data()) && out->close());
  }
}

TEST(TextureCommand, packs_a_folder_of_pictures_and_says_what_it_holds) {
  const Workbench bench;
  for (const char* extension : {".png", ".tif"})
    for (const int components : {3, 4}) {
      const std::string name = concat("slices", components, std::string(extension).substr(1));
      make_slices(bench / name, extension, components, 12);
      const RunResult packed = bench.rhoray(
          {"pack", name, "--color", "--spacing", "0.5,0.5,2", "--origin", "1,2,3", "-o", "c.rho", "--force", "--json"});
      ASSERT_EQ(packed.exit_code, 0) << packed.err;
      EXPECT_THAT(packed.err, HasSubstr(concat("5 x 4 x 12 = 240 colours ", components == 3 ? "RGB" : "RGBA")));
      EXPECT_EQ(Json::parse(packed.out)["kind"], "colors");
      const formats::ColorGrid grid(formats::PackedFile::open(bench / "c.rho"));
      const auto n = static_cast<std::uint64_t>(components);
      for (int k = 0; k < 12; ++k)
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 5; ++i)
            for (std::uint64_t c = 0; c < n; ++c)
              ASSERT_EQ(grid.texels()[n * grid.tables().address(i, j, k) + c], texel(i, j, k)[c]);
      EXPECT_EQ(grid.description().world_from_grid, (Affine{{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 2}, {1, 2, 3}}));
      EXPECT_THAT(grid.description().provenance.command,
                  HasSubstr(concat("rhoray pack ", name, " -o c.rho --color --spacing 0.5,0.5,2 --origin 1,2,3")));

      const RunResult info = bench.rhoray({"info", "c.rho"});
      EXPECT_THAT(info.out, HasSubstr(concat("packed colors, ")));
      EXPECT_THAT(info.out, HasSubstr(concat("5 x 4 x 12, ", components == 3 ? "RGB" : "RGBA", " of 8 bits (sRGB)")));
      const Json json = Json::parse(bench.rhoray({"info", "c.rho", "--json"}).out);
      EXPECT_EQ(json["format_version"], "1.4");
      EXPECT_EQ(json["components"], components == 3 ? "RGB" : "RGBA");
      EXPECT_EQ(json["geometry"]["spacing"], Json({0.5, 0.5, 2.0}));
      EXPECT_EQ(json["box"]["low"], Json({0.75, 1.75, 2.0}));
      EXPECT_EQ(json["box"]["high"], Json({3.25, 3.75, 26.0}));
      EXPECT_THAT(bench.rhoray({"verify", "c.rho", "--deep"}).out, HasSubstr("c.rho: sound"));
    }
}

TEST(TextureCommand, packs_within_a_cap_on_memory) {
  if (sanitized) GTEST_SKIP() << no_limits_of_memory;
  const Workbench bench;
  make_slices(bench / "slices", ".png", 3, 3);
  ASSERT_EQ(bench.rhoray({"pack", "slices", "--color", "-o", "a.rho"}).exit_code, 0);
  const RunResult capped = bench.rhoray({"pack", "slices", "--color", "--memory", "512M", "-o", "b.rho"});
  ASSERT_EQ(capped.exit_code, 0) << capped.err;
  const auto texels = [&](const char* name) {
    const formats::ColorGrid grid(formats::PackedFile::open(bench / name));
    return std::vector<std::uint8_t>(grid.texels().begin(), grid.texels().end());
  };
  EXPECT_EQ(texels("a.rho"), texels("b.rho"));
}

TEST(TextureCommand, finds_damage_among_the_texels) {
  const Workbench bench;
  bench.make_photo();
  bench.make_ball();
  const formats::PackedFile file = formats::PackedFile::open(bench / "photo.rho");
  std::string bytes = read_file(bench / "photo.rho");
  bytes[file.entry("texels").first_byte + 100] ^= 1;
  write_file(bench / "photo.rho", bytes);
  const RunResult verified = bench.rhoray({"verify", "photo.rho"});
  EXPECT_EQ(verified.exit_code, 4);
  EXPECT_THAT(verified.out, HasSubstr("texels"));
  const RunResult drawn = bench.rhoray({"render", "ball.rho", "--texture", "photo.rho", "-o", "p.png"});
  EXPECT_EQ(drawn.exit_code, 4);
  EXPECT_THAT(drawn.err, HasSubstr("photo.rho"));
  EXPECT_FALSE(std::filesystem::exists(bench / "p.png"));
}

TEST(TextureCommand, refuses_what_does_not_go_with_colours) {
  const Workbench bench;
  bench.make_photo_nrrd();
  bench.make_ball_raw();
  bench.make_box_vtu();
  struct Case {
    std::vector<std::string> words;
    int exit_code;
    std::string message;
  };
  const Case cases[] = {
      {{"photo.nrrd", "--color", "--type", "U8"}, 2, "--type: cannot be combined with --color"},
      {{"photo.nrrd", "--color", "--layout", "sparse"}, 2, "--layout sparse: cannot be combined with --color"},
      {{"photo.nrrd", "--color", "--levels", "2"}, 2, "--levels: cannot be combined with --color"},
      {{"photo.nrrd", "--color", "--factor", "2"}, 2, "--factor: cannot be combined with --color"},
      {{"photo.nrrd", "--color", "--field", "a,b"}, 2, "--field with several names"},
      {{"photo.nrrd", "--color", "--field", "red"}, 2, "found no field 'red'"},
      {{"photo.nrrd", "--color", "--brick-edge", "65"}, 2, "brick edge: found 65"},
      {{"ball.raw", "--color", "--raw", "24x24x24:uint8"}, 2, "--raw: cannot be combined with --color"},
      {{"box.vtu", "--color"}, 2, "--color: only for volumes, but box.vtu is a mesh"},
  };
  for (const Case& one : cases) {
    std::vector<std::string> words{"pack"};
    words.insert(words.end(), one.words.begin(), one.words.end());
    words.insert(words.end(), {"-o", "x.rho"});
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, one.exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(one.message));
    EXPECT_FALSE(std::filesystem::exists(bench / "x.rho"));
  }
}

TEST(TextureCommand, renders_a_covered_surface_and_says_so) {
  const Workbench bench;
  bench.make_ball();
  bench.make_photo();
  const std::vector<std::string> look{"render", "ball.rho", "--iso", "100", "--size", "40x30", "--stats", "--json"};
  const auto drawn = [&](std::vector<std::string> more) {
    more.insert(more.begin(), look.begin(), look.end());
    const RunResult result = bench.rhoray(more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  };
  const Json plain = drawn({"-o", "plain.png"});
  EXPECT_EQ(plain["statistics"]["texture_lookups"], 0);
  const Json textured = drawn({"-o", "p.png", "--texture", "photo.rho"});
  EXPECT_GT(textured["statistics"]["hits"], 100);
  EXPECT_EQ(textured["statistics"]["texture_lookups"], textured["statistics"]["hits"]);
  EXPECT_NE(read_file(bench / "p.png"), read_file(bench / "plain.png"));

  // The command stored in the picture renders it again.
  const std::string command = textured["reproduce"], bytes = read_file(bench / "p.png");
  EXPECT_THAT(command, HasSubstr("--texture photo.rho"));
  std::filesystem::remove(bench / "p.png");
  const RunResult again = bench.shell(command);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(read_file(bench / "p.png") == bytes);

  // So does the document.
  const RunResult printed = bench.rhoray(
      {"render", "ball.rho", "--iso", "100", "--size", "40x30", "--texture", "photo.rho", "--print-scene"});
  EXPECT_EQ(Json::parse(printed.out)["layers"][0]["texture"], "texture");
  EXPECT_EQ(Json::parse(printed.out)["data"]["texture"]["file"], "photo.rho");
  write_file(bench / "s.json", printed.out);
  std::filesystem::remove(bench / "p.png");
  ASSERT_EQ(bench.rhoray({"render", "s.json", "-o", "p.png"}).exit_code, 0);
  EXPECT_TRUE(read_file(bench / "p.png") == bytes);
}

TEST(TextureCommand, explains_the_texture) {
  const Workbench bench;
  bench.make_ball();
  bench.make_photo();
  const RunResult with = bench.rhoray({"render", "ball.rho", "--texture", "photo.rho", "--explain"});
  EXPECT_THAT(with.out, HasSubstr("\n  texture: covered by the colours in "));
  EXPECT_THAT(with.out, testing::Not(HasSubstr("is not opened")));
  EXPECT_THAT(bench.rhoray({"render", "ball.rho", "--explain"}).out,
              HasSubstr("\n  no texture: no texture covers the surface"));
}

TEST(TextureCommand, refuses_mistakes_by_their_options) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box_vtu();
  bench.make_photo();
  struct Case {
    std::vector<std::string> words;
    int exit_code;
    std::string message, hint;
  };
  const Case cases[] = {
      {{"ball.rho", "--texture", "foto.rho"}, 3, "foto.rho: no such file", "photo.rho"},
      {{"ball.rho", "--texture", "ball.rho"}, 7, "ball.rho: holds a grid; expected colours", "pack --color"},
      {{"ball.rho", "--texture", "box.vtu"}, 7, "box.vtu: is a mesh; expected colours", "a folder of pictures"},
      {{"ball.rho", "--texture", "ball.raw"}, 7, "ball.raw: unsupported file type", "a folder of pictures"},
      {{"ball.rho", "--mode", "mip", "--texture", "photo.rho"}, 2, "--texture: needs an isosurface", ""},
      {{"photo.rho"}, 7, "photo.rho: holds colours; expected a grid", "--texture FILE"},
  };
  for (const Case& one : cases) {
    std::vector<std::string> words{"render"};
    words.insert(words.end(), one.words.begin(), one.words.end());
    words.insert(words.end(), {"-o", "x.png"});
    const RunResult result = bench.rhoray(words);
    EXPECT_EQ(result.exit_code, one.exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr(one.message));
    EXPECT_THAT(result.err, HasSubstr(one.hint));
    EXPECT_FALSE(std::filesystem::exists(bench / "x.png"));
  }
}

}  // namespace
}  // namespace rhoray::tests
