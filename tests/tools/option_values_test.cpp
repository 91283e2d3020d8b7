#include "tools/rhoray/cli/options.h"

#include "render/scene_spec.h"
#include "tests/support/expect_error.h"

namespace rhoray::tools {
namespace {

template <class T>
T read(const std::string& text) {
  T value{};
  read_value(text, value);
  return value;
}

template <class T>
void expect_refused(std::initializer_list<const char*> texts) {
  for (const char* text : texts) {
    SCOPED_TRACE(text);
    tests::expect_error(ErrorCode::usage, "found '", [&] { read<T>(text); });
  }
}

TEST(OptionValues, reads_sizes_of_pictures) {
  EXPECT_EQ(read<render::PictureSize>("640x480").width, 640);
  EXPECT_EQ(read<render::PictureSize>("640x480").height, 480);
  EXPECT_EQ(read<render::PictureSize>("4k").width, 3840);
  EXPECT_EQ(read<render::PictureSize>("65536x1").width, 65536);
  expect_refused<render::PictureSize>({"", "x", "640", "640x", "0x0", "-1x4", "640x480x3", "1000000x1000000", "65537x1",
                                       "6e2x480", " 640x480", "99999999999999999999x1"});
}

TEST(OptionValues, reads_numbers_whole_and_finite) {
  EXPECT_EQ(read<double>("-60"), -60);
  EXPECT_EQ(read<double>("1e-3"), 1e-3);
  expect_refused<double>({"", "nan", "inf", "1e999", "1,5", "60mV", "+-1"});
  EXPECT_EQ(read<Vec3>("1,-2,3.5"), Vec3(1, -2, 3.5));
  expect_refused<Vec3>({"", "1,2", "1,2,3,4", "1,,3", "1,2,x", "1,2,inf"});
  EXPECT_EQ(read<Interval<double>>("-1,2"), (Interval<double>{-1, 2}));
  expect_refused<Interval<double>>({"2,1", "1,1", "1", "1,nan"});
  EXPECT_EQ(read<unsigned>("8"), 8U);
  expect_refused<unsigned>({"-1", "1.5", "two", "4294967296"});
}

TEST(OptionValues, reads_numbers_of_bytes) {
  EXPECT_EQ(read<ByteCount>("100").bytes, 100U);
  EXPECT_EQ(read<ByteCount>("2G").bytes, std::uint64_t{2} << 30);
  EXPECT_EQ(read<ByteCount>("1.5K").bytes, 1536U);
  expect_refused<ByteCount>({"", "0", "G", "2GB", "-1M", "1e30T"});
}

TEST(OptionValues, reads_colours_by_name_as_srgb_bytes_or_linear_numbers) {
  EXPECT_EQ(read<render::Color>("#ffffff").linear, Vec3(1, 1, 1));
  EXPECT_EQ(read<render::Color>("#000000").linear, Vec3(0, 0, 0));
  EXPECT_NEAR(read<render::Color>("#bc0000").linear.x, 0.5, 0.003);  // 188 is half the light
  EXPECT_EQ(read<render::Color>("0.25,0.5,1").linear, Vec3(0.25, 0.5, 1));
  EXPECT_EQ(read<render::Color>("red").linear, Vec3(1, 0, 0));
  EXPECT_EQ(read<render::Color>("aliceblue").linear, read<render::Color>("#f0f8ff").linear);
  EXPECT_EQ(read<render::Color>("yellowgreen").linear, read<render::Color>("#9acd32").linear);
  expect_refused<render::Color>({"", "redd", "Red", "#fff", "#gggggg", "#12345", "0,0,1.1", "0,0,-0.1", "1,1"});
}

TEST(OptionValues, reads_types_and_lists) {
  EXPECT_EQ(read<formats::ElementType>("uint16"), formats::ElementType::U16);
  EXPECT_EQ(read<formats::ElementType>("F32"), formats::ElementType::F32);
  expect_refused<formats::ElementType>({"", "F16", "int"});
  EXPECT_EQ(read<std::vector<std::string>>("a,b"), (std::vector<std::string>{"a", "b"}));
  expect_refused<std::vector<std::string>>({"", "a,", ",a", "a,,b"});
}

TEST(OptionValues, quotes_words_for_a_shell) {
  EXPECT_EQ(shell_line({"rhoray", "--iso", "-60.5"}), "rhoray --iso -60.5");
  EXPECT_EQ(shell_line({"a b", "", "it's", "$HOME"}), "'a b' '' 'it'\\''s' '$HOME'");
}

}  // namespace
}  // namespace rhoray::tools
