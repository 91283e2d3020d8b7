#include <cstring>

#include "preprocess/import/readers.h"
#include "preprocess/import_volume.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

TEST(RawDescription, says_sizes_type_order_and_skip) {
  const RawVolume plain = parse_raw_volume("256x128x64:uint16");
  EXPECT_EQ(plain.sample_count, Index3(256, 128, 64));
  EXPECT_EQ(plain.type, ElementType::U16);
  EXPECT_FALSE(plain.big_endian);
  EXPECT_EQ(plain.skipped_bytes, 0U);
  const RawVolume full = parse_raw_volume("3x4x5:float64:be:524");
  EXPECT_EQ(full.type, ElementType::F64);
  EXPECT_TRUE(full.big_endian);
  EXPECT_EQ(full.skipped_bytes, 524U);
  EXPECT_EQ(parse_raw_volume("1x1x1:I8:12").skipped_bytes, 12U);
}

TEST(RawDescription, refuses_with_the_part_that_is_wrong) {
  for (const auto& [text, part] :
       std::vector<std::pair<std::string, std::string>>{{"", "three sizes"},
                                                        {"3x4:uint8", "'3x4'"},
                                                        {"3x4x0:uint8", "'0'"},
                                                        {"3x-4x5:uint8", "'-4'"},
                                                        {"3x4x5", "a type"},
                                                        {"3x4x5:uint9", "'uint9'"},
                                                        {"3x4x5:uint8:me", "'me'"},
                                                        {"3x4x5:uint8:le:-1", "'-1'"},
                                                        {"3x4x5:uint8:le:0:0", "nothing more"}})
    expect_refusal([&description = text] { parse_raw_volume(description); }, ErrorCode::usage, {"raw volume", part});
}

NeutralVolume read(const std::filesystem::path& path, const std::string& description) {
  return read_volume(path, {.raw = parse_raw_volume(description), .field = {}});
}

TEST(RawVolume, reads_both_byte_orders_behind_skipped_bytes) {
  TemporaryFolder folder;
  const auto path = folder / "numbers.bin";
  write_file(path, "header!" + bytes_of_values(known_values<std::uint16_t>(), true) + "rest");
  const NeutralVolume big = read(path, "3x4x5:uint16:be:7");
  expect_known_values(big, ElementType::U16);
  EXPECT_EQ(big.field_name, "numbers");
  EXPECT_THAT(big.notes, testing::ElementsAre(testing::HasSubstr("4 bytes")));
  write_file(path, bytes_of_values(known_values<double>()));
  expect_known_values(read(path, "3x4x5:float64"), ElementType::F64);
}

template <class T>
void expect_the_same_swapped(const std::filesystem::path& path, const char* type) {
  for (const std::size_t header : {0U, 1U, 7U, 524U}) {
    const std::string behind(header, 'h');
    write_file(path, behind + bytes_of_values(known_values<T>(), true));
    const auto words = [&](const char* order) { return concat("3x4x5:", type, ":", order, ":", header); };
    expect_known_values(read(path, words("be")), formats::element_type_of<T>());
    const NeutralVolume swapped = read(path, words("le"));
    const std::string native = bytes_of_values(known_values<T>());
    ASSERT_EQ(swapped.samples.size(), native.size());
    EXPECT_NE(std::memcmp(swapped.samples.data(), native.data(), native.size()), 0)
        << type << " reads the same either way: is this case still the hard one?";
  }
}

// D15 of the catalogue of hard cases: taken in the wrong order, bytes are plausible numbers.
TEST(RawVolume, of_swapped_bytes_behind_an_odd_header_is_the_same_volume) {
  TemporaryFolder folder;
  expect_the_same_swapped<std::int16_t>(folder / "n.bin", "int16");
  expect_the_same_swapped<std::uint16_t>(folder / "n.bin", "uint16");
  expect_the_same_swapped<std::int32_t>(folder / "n.bin", "int32");
  expect_the_same_swapped<std::uint32_t>(folder / "n.bin", "uint32");
  expect_the_same_swapped<float>(folder / "n.bin", "float32");
  expect_the_same_swapped<double>(folder / "n.bin", "float64");
}

TEST(RawVolume, refuses_a_file_that_is_too_short_missing_or_a_folder) {
  TemporaryFolder folder;
  const auto path = folder / "short.bin";
  write_file(path, std::string(59, 'x'));
  expect_refusal([&] { read(path, "3x4x5:uint8"); }, ErrorCode::invalid, {"short.bin, byte 59", "60 bytes"});
  expect_refusal([&] { read(path, "3x4x5:uint8:100"); }, ErrorCode::invalid, {"short.bin"});
  expect_refusal([&] { read(path, "3037000500x3037000500x4:float64"); }, ErrorCode::invalid, {"fits in memory"});
  expect_refusal([&] { read(folder / "none.bin", "3x4x5:uint8"); }, ErrorCode::unreadable,
                 {"none.bin", "No such file"});
  expect_refusal([&] { read(folder.path(), "3x4x5:uint8"); }, ErrorCode::unreadable, {"folder"});
  write_file(path, "");
  expect_refusal([&] { read(path, "3x4x5:uint8"); }, ErrorCode::invalid, {"empty"});
}

TEST(RawVolume, keeps_64_bit_integers_only_where_a_double_holds_them) {
  TemporaryFolder folder;
  const auto path = folder / "long.raw";
  std::vector<std::int64_t> values = known_values<std::int64_t>();
  values[7] = -(std::int64_t{1} << 53);
  write_file(path, bytes_of_values(values));
  const NeutralVolume volume = read(path, "3x4x5:int64");
  EXPECT_EQ(volume.type, ElementType::F64);
  EXPECT_EQ(values_of(volume)[7], -9007199254740992.0);
  EXPECT_EQ(volume.notes.size(), 1U);
  values[7] -= 1;
  write_file(path, bytes_of_values(values));
  expect_refusal([&] { read(path, "3x4x5:int64"); }, ErrorCode::unsupported, {"2^53"});
  write_file(path, bytes_of_values(std::vector<std::uint64_t>(60, ~std::uint64_t{0})));
  expect_refusal([&] { read(path, "3x4x5:uint64"); }, ErrorCode::unsupported, {"2^53"});
}

}  // namespace
}  // namespace rhoray::preprocess
