#include <minizip/zip.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/colors.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::HasSubstr;

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.field = field});
}

struct Writing {
  std::string shape = "(5, 4, 3)";
  bool fortran_order = false;
  int version = 1;
};

/// A .npy file by hand (numpy/lib/format.py).
std::string npy(const std::string& descr, const std::string& numbers, const Writing& writing = {}) {
  std::string dictionary = concat("{'descr': ", descr, ", 'fortran_order': ", writing.fortran_order ? "True" : "False",
                                  ", 'shape': ", writing.shape, ", }");
  dictionary.append(63 - (10 + dictionary.size()) % 64, ' ');
  dictionary += '\n';
  std::string header("\x93NUMPY");
  header += {static_cast<char>(writing.version), '\0'};
  header += writing.version == 1 ? bytes_of_values(std::vector{static_cast<std::uint16_t>(dictionary.size())})
                                 : bytes_of_values(std::vector{static_cast<std::uint32_t>(dictionary.size())});
  return header + dictionary + numbers;
}

const std::string int16_descr = "'<i2'";

std::string int16_npy(const Writing& writing = {}) {
  return npy(int16_descr, bytes_of_values(known_values<std::int16_t>()), writing);
}

template <class T>
void expect_type_is_read(const std::filesystem::path& path, const std::string& code, ElementType type) {
  for (const bool big_endian : {false, true})
    for (const int version : {1, 2, 3}) {
      write_file(path, npy(concat("'", big_endian ? ">" : "<", code, "'"),
                           bytes_of_values(known_values<T>(), big_endian), {.version = version}));
      expect_values<T>(read(path), type);
    }
}

TEST(Numpy, reads_every_element_type_in_both_byte_orders) {
  TemporaryFolder folder;
  const auto path = folder / "a.npy";
  expect_type_is_read<std::uint8_t>(path, "u1", ElementType::U8);
  expect_type_is_read<std::int8_t>(path, "i1", ElementType::I8);
  expect_type_is_read<std::uint16_t>(path, "u2", ElementType::U16);
  expect_type_is_read<std::int16_t>(path, "i2", ElementType::I16);
  expect_type_is_read<std::uint32_t>(path, "u4", ElementType::U32);
  expect_type_is_read<std::int32_t>(path, "i4", ElementType::I32);
  expect_type_is_read<std::uint64_t>(path, "u8", ElementType::F64);
  expect_type_is_read<std::int64_t>(path, "i8", ElementType::F64);
  expect_type_is_read<float>(path, "f4", ElementType::F32);
  expect_type_is_read<double>(path, "f8", ElementType::F64);
  write_file(path, npy("'|b1'", bytes_of_values(known_values<std::uint8_t>())));
  const NeutralVolume booleans = read(path);
  expect_known_values(booleans, ElementType::U8);
  EXPECT_EQ(booleans.field_name, "a");
  expect_map(booleans.world_from_grid, {});
}

TEST(Numpy, turns_fortran_order) {
  TemporaryFolder folder;
  std::vector<float> z_fastest;
  for (std::int64_t i = 0; i < size_x; ++i)
    for (std::int64_t j = 0; j < size_y; ++j)
      for (std::int64_t k = 0; k < size_z; ++k) z_fastest.push_back(static_cast<float>(value_at(i, j, k)));
  for (const bool big_endian : {false, true}) {
    write_file(folder / "a.npy",
               npy(big_endian ? "'>f4'" : "'<f4'", bytes_of_values(z_fastest, big_endian), {.fortran_order = true}));
    expect_known_values(read(folder / "a.npy"), ElementType::F32);
  }
}

TEST(Numpy, reads_colours) {
  TemporaryFolder folder;
  for (const int components : {3, 4}) {
    const auto expected = colors_of({size_x, size_y, size_z}, components, telling_texel);
    std::string texels(expected.samples.size(), '\0');
    std::memcpy(texels.data(), expected.samples.data(), texels.size());
    const Writing writing{.shape = concat("(5, 4, 3, ", components, ")")};
    write_file(folder / "a.npy", npy("'|u1'", texels, writing));
    const NeutralVolume colors = read_volume(folder / "a.npy", {.colors = true});
    EXPECT_EQ(colors.component_count, components);
    EXPECT_TRUE(std::equal(colors.samples.begin(), colors.samples.end(), expected.samples.begin()));
    EXPECT_EQ(read(folder / "a.npy").field_name, "a.mag") << "a picture needs no choice";
    write_file(folder / "a.npy", int16_npy());
    expect_refusal([&] { read_volume(folder / "a.npy", {.colors = true}); }, ErrorCode::unsupported, {"3 axes"});
  }
}

TEST(Numpy, refuses_what_is_no_volume) {
  TemporaryFolder folder;
  const auto path = folder / "a.npy";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read(path); }, error_code, words);
  };
  refuses("another file", ErrorCode::invalid, {"a.npy, byte 0"});
  refuses("\x93NUMPY\4" + std::string(200, ' '), ErrorCode::unsupported, {"version 4"});
  const std::string numbers(120, '\1');
  for (const std::string descr : {"'<f2'", "'<c8'", "'|O'", "'<U3'", "'|S4'", "'<M8[ns]'", "'|V8'"})
    refuses(npy(descr, numbers), ErrorCode::unsupported, {"key descr", descr});
  refuses(npy("[('x', '<f4')]", numbers), ErrorCode::unsupported, {"a structured type"});
  refuses(int16_npy({.shape = "(15, 4)"}), ErrorCode::unsupported, {"2 axes (15 x 4)", "3 axes: z, y, x"});
  refuses(int16_npy({.shape = "(60,)"}), ErrorCode::unsupported, {"1 axis (60)"});
  refuses(int16_npy({.shape = "()"}), ErrorCode::unsupported, {"0 axes (a single number)"});
  refuses(int16_npy({.shape = "5"}), ErrorCode::invalid, {"key shape"});
  refuses(int16_npy({.shape = "(5, , 3)"}), ErrorCode::invalid, {"key shape"});
  refuses(int16_npy({.shape = "(5, 4, 0)"}), ErrorCode::invalid, {"0 x 4 x 5"});
  refuses(int16_npy({.shape = "(5, 4, -3)"}), ErrorCode::invalid, {"-3 x 4 x 5"});
  refuses(int16_npy({.shape = "(5, 4, 4)"}), ErrorCode::invalid, {"120 bytes", "160"});
  refuses(int16_npy({.shape = "(4294967296, 4294967296, 4)"}), ErrorCode::invalid, {"fits in memory"});
  std::string no_shape = int16_npy();
  no_shape.replace(no_shape.find("'shape'"), 7, "'shade'");
  refuses(no_shape, ErrorCode::invalid, {"no key 'shape'"});
  write_file(path, int16_npy());
  expect_refusal([&] { read(path, "b"); }, ErrorCode::usage, {"no field 'b'", "expected one of: a"});
  expect_refusal([&] { read_volume(path, {.time = "last"}); }, ErrorCode::usage, {"no time steps"});
  write_file(path, int16_npy() + "more");
  EXPECT_THAT(read(path).notes, testing::ElementsAre(HasSubstr("4 bytes after the array")));
  try {
    write_file(path, npy("'<f2'", numbers));
    read(path);
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), HasSubstr("astype"));
  }
}

TEST(Numpy, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  EXPECT_EQ(check_every_beginning(folder / "a.npy", int16_npy(),
                                  [&] { return read(folder / "a.npy").samples.size() == 120; }),
            0);
}

/// An archive as numpy.savez (packed: savez_compressed) writes it.
void write_npz(const std::filesystem::path& path, const std::vector<std::pair<std::string, std::string>>& files,
               bool packed = false) {
  zipFile archive = zipOpen64(path.c_str(), APPEND_STATUS_CREATE);
  ASSERT_NE(archive, nullptr);
  for (const auto& [name, content] : files) {
    zip_fileinfo info{};
    ASSERT_EQ(zipOpenNewFileInZip(archive, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr,
                                  packed ? Z_DEFLATED : 0, Z_DEFAULT_COMPRESSION),
              ZIP_OK);
    ASSERT_EQ(zipWriteInFileInZip(archive, content.data(), static_cast<unsigned>(content.size())), ZIP_OK);
    zipCloseFileInZip(archive);
  }
  zipClose(archive, nullptr);
}

TEST(Numpy, reads_the_array_of_an_archive_that_is_named_or_the_first_volume) {
  TemporaryFolder folder;
  const auto path = folder / "a.npz";
  const std::string spacing = npy("'<f8'", bytes_of_values(std::vector<double>{1, 2, 3}), {.shape = "(3,)"});
  const std::string names = npy("'<U1'", "abcdefgh", {.shape = "(2,)"});
  const std::string other = npy("'<f4'", bytes_of_values(std::vector<float>{1, 2, 3, 4, 5, 6}), {.shape = "(1, 2, 3)"});
  for (const bool packed : {false, true}) {
    write_npz(path, {{"spacing.npy", spacing}, {"names.npy", names}, {"image.npy", int16_npy()}}, packed);
    const NeutralVolume only = read(path);
    expect_known_values(only, ElementType::I16);
    EXPECT_EQ(only.field_name, "image");
    EXPECT_TRUE(only.notes.empty());
    write_npz(path, {{"read me.txt", "text"}, {"other.npy", other}, {"image.npy", int16_npy()}}, packed);
    expect_known_values(read(path, "image"), ElementType::I16);
    EXPECT_THAT(read(path, "image").other_fields, testing::ElementsAre("other"));
    const NeutralVolume first = read(path);
    EXPECT_EQ(values_of(first), (std::vector<double>{1, 2, 3, 4, 5, 6}));
    EXPECT_THAT(first.notes, testing::ElementsAre("using 'other'; choose another with --field: image"));
  }
  expect_refusal([&] { read(path, "imago"); }, ErrorCode::usage, {"no field 'imago'", "expected one of: other, image"});
  const std::string flow = npy("'<f4'", bytes_of_values(std::vector<float>{3, 4, 5, 12}), {.shape = "(1, 1, 2, 2)"});
  const std::string steps = npy("'|u1'", std::string(16, 'x'), {.shape = "(1, 1, 1, 16)"});
  write_npz(path, {{"spacing.npy", spacing}, {"steps.npy", steps}, {"flow.npy", flow}});
  EXPECT_EQ(values_of(read(path)), (std::vector<double>{5, 13}));
  EXPECT_EQ(values_of(read(path, "flow.y")), (std::vector<double>{4, 12}));
  expect_refusal([&] { read(path, "steps"); }, ErrorCode::unsupported,
                 {"'steps'", "4 axes (1 x 1 x 1 x 16)", "2 to 9"});
  write_npz(path, {{"spacing.npy", spacing}, {"names.npy", names}});
  expect_refusal([&] { read(path); }, ErrorCode::unsupported, {"spacing (3), names (2)", "one of 3 axes"});
  expect_refusal([&] { read(path, "names"); }, ErrorCode::unsupported, {"1 axis (2)"});
  write_npz(path, {{"read me.txt", "text"}});
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"arrays", "none"});
  write_file(path, "no archive");
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"a.npz"});
}

TEST(Numpy, refuses_every_beginning_of_an_archive_and_notices_damage) {
  TemporaryFolder folder;
  const auto path = folder / "a.npz";
  write_npz(path, {{"image.npy", int16_npy()}});
  std::string content = read_file(path);
  // The last bytes of the table of contents are not needed.
  EXPECT_LE(check_every_beginning(path, content, [&] { return read(path).samples.size() == 120; }), 3);
  char& sample = content[content.find("image.npy") + 9 + 200];
  sample = static_cast<char>(sample ^ 1);
  write_file(path, content);
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"image.npy", "damaged"});
}

TEST(Numpy, refuses_an_archive_that_claims_more_than_its_bytes_can_hold) {
  TemporaryFolder folder;
  const auto path = folder / "a.npz";
  write_npz(path, {{"image.npy", int16_npy()}}, true);
  std::string content = read_file(path);
  const std::size_t entry = content.find("PK\x01\x02");  // of the table of contents
  ASSERT_NE(entry, content.npos);
  content.replace(entry + 24, 4, bytes_of_values(std::vector<std::uint32_t>{1U << 30}));
  write_file(path, content);
  expect_refusal([&] { read(path); }, ErrorCode::invalid,
                 {"sizes that need 1073741824 bytes", concat("in ", content.size(), " packed bytes")});
}

TEST(Numpy, notices_damage_behind_the_array_of_an_archive) {
  TemporaryFolder folder;
  const auto path = folder / "a.npz";
  write_npz(path, {{"image.npy", int16_npy() + std::string(20000, 'x')}});
  std::string content = read_file(path);
  EXPECT_THAT(read(path).notes, testing::ElementsAre(HasSubstr("20000 bytes after the array")));
  content[content.find("xxxx") + 10000] = 'y';
  write_file(path, content);
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"image.npy", "damaged"});
}

}  // namespace
}  // namespace rhoray::preprocess
