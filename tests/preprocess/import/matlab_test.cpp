#include <zlib.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::HasSubstr;

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.field = field});
}

/// A MAT-file of version 5 by hand, in either byte order.
class File {
 public:
  explicit File(bool big_endian = false) : big_endian_(big_endian), content_("MATLAB 5.0 MAT-file, by hand") {
    content_.resize(124, ' ');
    content_ += bytes_of_values(std::vector<std::uint16_t>{0x0100}, big_endian_) + (big_endian ? "MI" : "IM");
  }

  /// @param flags  the class of the array, and 0x0800 for complex numbers
  /// @param type   of the stored numbers
  template <class T>
  File& add(const std::string& name, std::uint32_t flags, std::uint32_t type, const std::vector<T>& numbers,
            const std::vector<std::int32_t>& sizes = {3, 4, 5}, bool packed = false) {
    const std::string array = part(6, bytes_of_values(std::vector<std::uint32_t>{flags, 0}, big_endian_)) +
                              part(5, bytes_of_values(sizes, big_endian_)) + part(1, name) +
                              part(type, bytes_of_values(numbers, big_endian_));
    if (packed) {
      const std::string whole = part(14, array);
      std::string small(::compressBound(whole.size()), '\0');
      uLongf size = small.size();
      ::compress(reinterpret_cast<Bytef*>(small.data()), &size, reinterpret_cast<const Bytef*>(whole.data()),
                 whole.size());
      content_ += tag(15, static_cast<std::uint32_t>(size)) + small.substr(0, size);
    } else {
      content_ += part(14, array);
    }
    return *this;
  }

  /// The array of the known values.
  template <class T>
  File& add_known(const std::string& name, std::uint32_t flags, std::uint32_t type, bool packed = false) {
    return add(name, flags, type, known_values<T>(), {3, 4, 5}, packed);
  }

  const std::string& content() const { return content_; }

 private:
  std::string tag(std::uint32_t type, std::uint32_t bytes) const {
    return bytes_of_values(std::vector{type, bytes}, big_endian_);
  }
  /// Short parts stand in their tag.
  std::string part(std::uint32_t type, std::string bytes) const {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    if (size > 0 && size <= 4) {
      bytes.resize(4, '\0');
      return bytes_of_values(std::vector{size << 16 | type}, big_endian_) + bytes;
    }
    bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
    return tag(type, size) + bytes;
  }

  bool big_endian_;
  std::string content_;
};

struct Class {
  std::uint32_t number, type;
  ElementType element;
};

template <class T>
void expect_class_is_read(const std::filesystem::path& path, const Class& row) {
  for (const bool big_endian : {false, true})
    for (const bool packed : {false, true}) {
      write_file(path, File(big_endian).add_known<T>("image", row.number, row.type, packed).content());
      const NeutralVolume volume = read(path);
      expect_values<T>(volume, row.element);
      EXPECT_EQ(volume.field_name, "image");
      expect_map(volume.world_from_grid, {});
    }
}

TEST(Matlab, reads_every_class_of_numbers_plain_or_packed_in_both_byte_orders) {
  TemporaryFolder folder;
  const auto path = folder / "a.mat";
  expect_class_is_read<double>(path, {6, 9, ElementType::F64});
  expect_class_is_read<float>(path, {7, 7, ElementType::F32});
  expect_class_is_read<std::int8_t>(path, {8, 1, ElementType::I8});
  expect_class_is_read<std::uint8_t>(path, {9, 2, ElementType::U8});
  expect_class_is_read<std::int16_t>(path, {10, 3, ElementType::I16});
  expect_class_is_read<std::uint16_t>(path, {11, 4, ElementType::U16});
  expect_class_is_read<std::int32_t>(path, {12, 5, ElementType::I32});
  expect_class_is_read<std::uint32_t>(path, {13, 6, ElementType::U32});
  expect_class_is_read<std::int64_t>(path, {14, 12, ElementType::F64});
  expect_class_is_read<std::uint64_t>(path, {15, 13, ElementType::F64});
  // whole numbers of a class in fewer bytes
  expect_class_is_read<std::uint8_t>(path, {6, 2, ElementType::F64});
  expect_class_is_read<std::int16_t>(path, {6, 3, ElementType::F64});
  expect_class_is_read<std::uint8_t>(path, {7, 2, ElementType::F32});
  expect_class_is_read<std::uint8_t>(path, {11, 2, ElementType::U16});
}

TEST(Matlab, reads_the_array_that_is_named_or_the_first_of_three_axes) {
  TemporaryFolder folder;
  const auto path = folder / "a.mat";
  const std::vector<double> six{1, 2, 3, 4, 5, 6};
  write_file(path, File()
                       .add("spacing", 6, 9, six, {1, 6})
                       .add("an object", 17, 9, six, {1, 6})
                       .add("first", 6, 9, six, {3, 2, 1}, true)
                       .add_known<std::int16_t>("second", 10, 3)
                       .content());
  const NeutralVolume first = read(path);
  EXPECT_EQ(first.sample_count, Index3(3, 2, 1));
  EXPECT_EQ(values_of(first), six);
  EXPECT_THAT(first.notes, testing::ElementsAre("using 'first'; choose another with --field: second"));
  expect_known_values(read(path, "second"), ElementType::I16);
  EXPECT_THAT(read(path, "second").other_fields, testing::ElementsAre("first"));
  EXPECT_TRUE(read(path, "second").notes.empty());
  expect_refusal([&] { read(path, "third"); }, ErrorCode::usage,
                 {"no field 'third'", "expected one of: first, second"});
  expect_refusal([&] { read(path, "spacing"); }, ErrorCode::unsupported, {"'spacing'", "2 axes (1 x 6)", "x, y, z"});
}

TEST(Matlab, reads_the_first_array_that_is_readable) {
  TemporaryFolder folder;
  const auto path = folder / "a.mat";
  write_file(path, File()
                       .add_known<double>("a struct", 2, 9)
                       .add_known<double>("a spectrum", 0x0806, 9)
                       .add_known<std::int16_t>("image", 10, 3)
                       .content());
  const NeutralVolume volume = read(path);
  expect_known_values(volume, ElementType::I16);
  EXPECT_EQ(volume.field_name, "image");
  EXPECT_THAT(volume.notes, testing::ElementsAre("arrays that cannot be read were left out: a struct, a spectrum"));
  EXPECT_TRUE(read(path, "image").notes.empty());
  expect_refusal([&] { read(path, "a struct"); }, ErrorCode::unsupported, {"'a struct'", "no plain array"});
  expect_refusal([&] { read(path, "a spectrum"); }, ErrorCode::unsupported, {"'a spectrum'", "complex"});
}

TEST(Matlab, reads_vectors_along_a_fourth_axis) {
  TemporaryFolder folder;
  write_file(folder / "a.mat", File().add("flow", 6, 9, std::vector<double>{3, 5, 4, 12}, {1, 2, 1, 2}).content());
  EXPECT_EQ(values_of(read(folder / "a.mat")), (std::vector<double>{5, 13}));
  EXPECT_EQ(values_of(read(folder / "a.mat", "flow.y")), (std::vector<double>{4, 12}));
}

TEST(Matlab, refuses_what_is_no_volume) {
  TemporaryFolder folder;
  const auto path = folder / "a.mat";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read(path); }, error_code, words);
  };
  refuses("another file", ErrorCode::unsupported, {"a.mat, byte 0", "version 5"});
  refuses("MATLAB 7.3 MAT-file, " + std::string(600, ' '), ErrorCode::unsupported, {"version 7.3"});
  refuses(File().content(), ErrorCode::invalid, {"arrays", "none"});
  refuses(File().add_known<double>("a", 0x0806, 9).content(), ErrorCode::unsupported, {"'a'", "complex"});
  refuses(File().add_known<double>("a", 1, 9).content(), ErrorCode::unsupported, {"'a'", "no plain array"});
  refuses(File().add_known<double>("a", 7, 9).content(), ErrorCode::invalid, {"type 9", "F32"});
  refuses(File().add_known<double>("a", 12, 9).content(), ErrorCode::invalid, {"type 9", "I32"});
  refuses(File().add_known<double>("a", 6, 99).content(), ErrorCode::invalid, {"type 99"});
  const std::vector<double> six{1, 2, 3, 4, 5, 6};
  refuses(File().add("a", 6, 9, six, {2, 2, 2}).content(), ErrorCode::invalid, {"48 bytes", "64"});
  refuses(File().add("a", 6, 9, six, {2, 0, 2}).content(), ErrorCode::invalid, {"2 x 0 x 2"});
  refuses(File().add("a", 6, 9, six, {2, -3, -1}).content(), ErrorCode::invalid, {"2 x -3 x -1"});
  refuses(File().add("a", 6, 9, six, {2000000000, 2000000000, 2000000000}).content(), ErrorCode::invalid, {"memory"});
  try {
    write_file(path, "MATLAB 7.3 MAT-file, " + std::string(600, ' '));
    read(path);
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), HasSubstr("-v7"));
  }
}

TEST(Matlab, refuses_every_beginning_of_a_file_and_notices_damage) {
  TemporaryFolder folder;
  const auto path = folder / "a.mat";
  const auto is_complete = [&] { return read(path).samples.size() == 120; };
  EXPECT_EQ(check_every_beginning(path, File().add_known<std::int16_t>("a", 10, 3).content(), is_complete), 0);
  std::string packed = File().add_known<std::int16_t>("a", 10, 3, true).content();
  EXPECT_EQ(check_every_beginning(path, packed, is_complete), 0);
  packed.back() = static_cast<char>(packed.back() ^ 1);  // in the checksum
  write_file(path, packed);
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"damaged data"});
}

}  // namespace
}  // namespace rhoray::preprocess
