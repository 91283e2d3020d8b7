#include "formats/packed_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <numeric>

#include "formats/base/text.h"
#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::MemoryFile;
using tests::TemporaryFolder;

template <class T>
class PackedFileOf : public testing::Test {};
using AllTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                std::uint64_t, std::int64_t, float, double>;
TYPED_TEST_SUITE(PackedFileOf, AllTypes);

TYPED_TEST(PackedFileOf, values_and_shape_come_back_as_written) {
  const TemporaryFolder folder;
  std::vector<TypeParam> values(24);
  std::iota(values.begin(), values.end(), TypeParam{3});
  values[0] = std::numeric_limits<TypeParam>::lowest();
  values[1] = std::numeric_limits<TypeParam>::max();
  PackedFileWriter writer(folder / "a.rho", {.kind = "test", .required = {}, .details = R"({"x":1})"},
                          {{.name = "first", .type = ElementType::U8, .shape = {3}},
                           {.name = "values", .type = element_type_of<TypeParam>(), .shape = {2, 3, 4}}});
  writer.write_all("values", std::span<const TypeParam>(values));
  writer.write_all("first", std::span<const std::uint8_t>(std::array<std::uint8_t, 3>{7, 8, 9}));
  const std::uint64_t bytes = writer.commit();

  const PackedFile file = PackedFile::open(folder / "a.rho");
  EXPECT_EQ(file.file_bytes(), bytes);
  EXPECT_EQ(std::filesystem::file_size(folder / "a.rho"), bytes);
  EXPECT_EQ(file.version(), "1.0");
  EXPECT_EQ(file.description().kind, "test");
  EXPECT_EQ(file.description().details, R"({"x":1})");
  EXPECT_THAT(file.array<TypeParam>("values", {2, 3, 4}), testing::ElementsAreArray(values));
  EXPECT_THAT(file.array<TypeParam>("values", {0, 3, 0}), testing::SizeIs(24));
  EXPECT_THAT(file.array<std::uint8_t>("first", {3}), testing::ElementsAre(7, 8, 9));
  EXPECT_EQ(file.entry("values").element_count(), 24U);
  EXPECT_THAT(file.damaged_blocks(), testing::IsEmpty());
}

PackedFile small_file(const MemoryFile& memory) {
  PackedFileWriter writer(memory.descriptor(), {.kind = "test"},
                          {{.name = "a", .type = ElementType::U16, .shape = {5}},
                           {.name = "bricks", .type = ElementType::U8, .shape = {10}, .alignment = 4096},
                           {.name = "none", .type = ElementType::F64, .shape = {0, 3}}});
  writer.write_all("a", std::span<const std::uint16_t>(std::array<std::uint16_t, 5>{1, 2, 3, 4, 5}));
  writer.write_all("bricks", std::span<const std::uint8_t>(std::array<std::uint8_t, 10>{}));
  writer.commit();
  return PackedFile::from_descriptor(memory.descriptor(), "memory.rho");
}

TEST(PackedFile, arrays_start_where_they_asked_to) {
  const MemoryFile memory;
  const PackedFile file = small_file(memory);
  ASSERT_EQ(file.arrays().size(), 3U);
  EXPECT_EQ(file.entry("a").first_byte, 4096U);
  EXPECT_EQ(file.entry("bricks").first_byte, 8192U);
  EXPECT_EQ(file.entry("none").first_byte % 64, 0U);
  EXPECT_EQ(file.array<double>("none", {0, 3}).size(), 0U);
}

TEST(PackedFile, an_array_of_another_type_or_shape_is_refused_with_both) {
  const MemoryFile memory;
  const PackedFile file = small_file(memory);
  expect_error(ErrorCode::invalid, "memory.rho, array 'a': found U16 [5]; expected F32 [5]",
               [&] { file.array<float>("a", {5}); });
  expect_error(ErrorCode::invalid, "found U16 [5]; expected U16 [any, 6]", [&] {
    file.array<std::uint16_t>("a", {0, 6});
  });
  expect_error(ErrorCode::invalid, "array 'b': found nothing", [&] { file.array<std::uint16_t>("b", {5}); });
  EXPECT_FALSE(file.has("b"));
  EXPECT_FALSE(file.has("_sum")) << "the envelope's own arrays are not shown";
}

TEST(PackedFile, views_outlive_the_descriptor_and_the_first_copy) {
  std::optional<PackedFile> copy;
  {
    const MemoryFile memory;
    copy = small_file(memory);
  }
  EXPECT_THAT(copy->array<std::uint16_t>("a", {5}), testing::ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(copy->damaged_blocks(), testing::IsEmpty());
}

TEST(PackedFile, what_is_no_file_is_refused_as_unreadable) {
  const TemporaryFolder folder;
  expect_error(ErrorCode::unreadable, "missing.rho: No such file", [&] { PackedFile::open(folder / "missing.rho"); });
  expect_error(ErrorCode::unreadable, "found a folder", [&] { PackedFile::open(folder.path()); });
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  expect_error(ErrorCode::unreadable, "found a pipe", [&] { PackedFile::open(folder / "pipe"); });
}

TEST(PackedFile, what_is_no_packed_file_is_refused_as_invalid) {
  const TemporaryFolder folder;
  tests::write_file(folder / "empty", "");
  tests::write_file(folder / "text", std::string(10000, 'x'));
  expect_error(ErrorCode::invalid, "empty, byte 0: found the end of the file",
               [&] { PackedFile::open(folder / "empty"); });
  expect_error(ErrorCode::invalid, "is not a .rho file", [&] { PackedFile::open(folder / "text"); });
}

TEST(PackedFile, looks_packed_tells_by_the_first_bytes) {
  const TemporaryFolder folder;
  const MemoryFile memory;
  small_file(memory);
  tests::write_file(folder / "whole", memory.content());
  tests::write_file(folder / "cut", memory.content().substr(0, 1000));
  tests::write_file(folder / "text", std::string(1000, '{'));
  tests::write_file(folder / "short", "{");
  EXPECT_TRUE(PackedFile::looks_packed(folder / "whole"));
  EXPECT_TRUE(PackedFile::looks_packed(folder / "cut")) << "a damaged packed file should be refused as one";
  EXPECT_FALSE(PackedFile::looks_packed(folder / "text"));
  EXPECT_FALSE(PackedFile::looks_packed(folder / "short"));
  EXPECT_FALSE(PackedFile::looks_packed(folder / "missing"));
  EXPECT_FALSE(PackedFile::looks_packed(folder.path()));
}

TEST(PackedFile, each_damaged_block_is_named_with_any_number_of_threads) {
  constexpr std::uint64_t data_bytes = 40'000'000;  // 611 blocks, so that several threads take part
  const MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), {.kind = "test"},
                          {{.name = "data", .type = ElementType::U8, .shape = {data_bytes}, .alignment = 4096}});
  std::vector<std::uint8_t> data(data_bytes);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i * 2654435761U >> 13);
  writer.write_all("data", std::span<const std::uint8_t>(data));
  writer.commit();
  const PackedFile file = PackedFile::from_descriptor(memory.descriptor(), "memory.rho");
  ASSERT_THAT(file.damaged_blocks(), testing::IsEmpty());

  const std::uint64_t first = file.entry("data").first_byte;
  for (const std::uint64_t at : {std::uint64_t{0}, std::uint64_t{20'000'000}, data_bytes - 1})
    memory.put(first + at, static_cast<char>(~data[at]));
  for (const unsigned threads : {1U, 2U, 8U, 0U}) {
    const std::vector<DamagedBlock> damaged = file.damaged_blocks(threads);
    ASSERT_EQ(damaged.size(), 3U);
    EXPECT_EQ(damaged[0].first_byte, first);
    EXPECT_EQ(damaged[0].byte_count, 65536U);
    EXPECT_EQ(damaged[1].first_byte, first + 20'000'000 / 65536 * 65536);
    EXPECT_EQ(damaged[2].first_byte, first + data_bytes / 65536 * 65536);
  }
}

TEST(PackedFile, a_file_cut_short_while_open_has_damaged_blocks_and_does_not_end_the_process) {
  const MemoryFile memory;
  const PackedFile file = small_file(memory);
  memory.resize(5000);
  EXPECT_THAT(file.damaged_blocks(), testing::SizeIs(1));
}

}  // namespace
}  // namespace rhoray::formats
