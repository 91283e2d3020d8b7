#include <zlib.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.raw = {}, .field = field});
}

std::string header(const std::string& lines) {
  return concat("NRRD0004\ntype: short\ndimension: 3\nsizes: 3 4 5\n", lines);
}

const std::string little = "endian: little\nencoding: raw\n";

TEST(Nrrd, keeps_rotated_and_mirrored_axes_origin_and_units) {
  TemporaryFolder folder;
  write_file(folder / "a.nrrd",
             header(concat("space: left-posterior-superior\nspace directions: (0,2,0) (-0.5,0,0) (0,0.25,3)\n"
                           "space origin: (10,-20,30.5)\nspace units: \"mm\" \"mm\" \"mm\"\nsample units: \"HU\"\n",
                           little)) +
                 "\n" + bytes_of_values(known_values<std::int16_t>()));
  const NeutralVolume volume = read(folder / "a.nrrd");
  expect_known_values(volume, ElementType::I16);
  expect_map(volume.world_from_grid, {{0, 2, 0}, {-0.5, 0, 0}, {0, 0.25, 3}, {10, -20, 30.5}});
  EXPECT_EQ(volume.length_unit, "mm");
  EXPECT_EQ(volume.field_unit, "HU");
  EXPECT_EQ(volume.field_name, "a");
}

TEST(Nrrd, keeps_spaces_of_bodies) {
  TemporaryFolder folder;
  const auto placed = [&](const std::string& space) {
    write_file(folder / "a.nrrd",
               header(concat(space, "space directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (4,5,6)\n", little)) +
                   "\n" + bytes_of_values(known_values<std::int16_t>()));
    return read(folder / "a.nrrd");
  };
  const Affine map{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {4, 5, 6}};
  using formats::Space;
  for (const auto& [words, space] : {std::pair{"space: left-posterior-superior\n", Space::lps},
                                     {"space: LPS\n", Space::lps},
                                     {"space: right-anterior-superior\n", Space::ras},
                                     {"space: scanner-xyz\n", Space::unknown},
                                     {"space dimension: 3\n", Space::unknown}}) {
    EXPECT_EQ(placed(words).space, space) << words;
    expect_map(placed(words).world_from_grid, map);
  }
  const NeutralVolume turned = placed("space: left-anterior-superior\n");
  EXPECT_EQ(turned.space, Space::ras);
  expect_map(turned.world_from_grid, {{-1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {-4, 5, 6}});
}

TEST(Nrrd, takes_spacings_and_the_edges_of_cells) {
  TemporaryFolder folder;
  const std::string data = concat("\n", bytes_of_values(known_values<std::int16_t>()));
  write_file(folder / "a.nrrd",
             header(concat("spacings: 0.5 1 nan\naxis mins: 1 2 3\ncenterings: cell node node\n", little)) + data);
  expect_map(read(folder / "a.nrrd").world_from_grid, axis_parallel_map({0.5, 1, 1}, {1.25, 2, 3}));
  write_file(folder / "a.nrrd",
             header(concat("axis mins: 0 0 0\naxis maxs: 6 6 10\ncenterings: cell node cell\n", little)) + data);
  expect_map(read(folder / "a.nrrd").world_from_grid, axis_parallel_map({2, 2, 2}, {1, 0, 1}));
}

TEST(Nrrd, does_not_take_a_first_axis_of_four_for_components) {  // as vtkNrrdReader does
  TemporaryFolder folder;
  std::string text = "NRRD0001\ntype: unsigned char\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n\n";
  for (char value = 0; value < 24; ++value) text += value;
  write_file(folder / "a.nrrd", text);
  const NeutralVolume volume = read(folder / "a.nrrd");
  EXPECT_EQ(volume.sample_count, Index3(4, 3, 2));
  EXPECT_EQ(values_of(volume)[23], 23);
}

TEST(Nrrd, reads_detached_big_endian_and_numbered_files) {
  TemporaryFolder folder;
  const std::string samples = bytes_of_values(known_values<std::int16_t>(), true);
  write_file(folder / "a.raw", samples);
  write_file(folder / "a.nhdr", header("endian: big\nencoding: raw\ndata file: a.raw\n"));
  expect_known_values(read(folder / "a.nhdr"), ElementType::I16);
  for (std::size_t slice = 0; slice < 5; ++slice)
    write_file(folder / concat("s.", 5 + slice), std::string_view(samples).substr(slice * 24, 24));
  write_file(folder / "b.nhdr", header("endian: big\nencoding: raw\ndata file: s.%d 5 9 1\n"));
  expect_known_values(read(folder / "b.nhdr"), ElementType::I16);
  std::filesystem::remove(folder / "s.7");
  expect_refusal([&] { read(folder / "b.nhdr"); }, ErrorCode::invalid, {"b.nhdr", "s.7"});
}

TEST(Nrrd, reads_gzip_and_text) {
  TemporaryFolder folder;
  const gzFile packed = ::gzopen((folder / "a.raw.gz").c_str(), "wb");
  const std::string samples = bytes_of_values(known_values<std::int16_t>());
  ::gzwrite(packed, samples.data(), static_cast<unsigned>(samples.size()));
  ::gzclose(packed);
  write_file(folder / "a.nhdr", header("endian: little\nencoding: gzip\ndata file: a.raw.gz\n"));
  expect_known_values(read(folder / "a.nhdr"), ElementType::I16);
  const std::string gz = read_file(folder / "a.raw.gz");
  write_file(folder / "a.raw.gz", std::string_view(gz).substr(0, gz.size() / 2));
  expect_refusal([&] { read(folder / "a.nhdr"); }, ErrorCode::invalid, {"a.nhdr"});
  write_file(folder / "b.nrrd", header("encoding: text\n") + "\n" + values_in_text());
  expect_known_values(read(folder / "b.nrrd"), ElementType::I16);
}

TEST(Nrrd, passes_values_that_are_no_numbers_through) {
  TemporaryFolder folder;
  write_file(folder / "a.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 3 1 1\nencoding: text\n\nnan -inf 1.5\n");
  const std::vector<double> values = values_of(read(folder / "a.nrrd"));
  EXPECT_TRUE(std::isnan(values[0]));
  EXPECT_EQ(values[1], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(values[2], 1.5);
}

TEST(Nrrd, leaves_axes_with_one_sample_out_and_refuses_vectors_and_time) {
  TemporaryFolder folder;
  const auto path = folder / "a.nrrd";
  const std::string start = "NRRD0004\ntype: uchar\ndimension: 4\nencoding: raw\n";
  write_file(path, start + "sizes: 2 2 2 1\n\n12345678");
  EXPECT_EQ(read(path).sample_count, Index3(2, 2, 2));
  write_file(path, concat(start, "sizes: 3 2 2 2\nkinds: 3-vector domain domain domain\n\n", std::string(24, 'x')));
  expect_refusal([&] { read(path); }, ErrorCode::unsupported, {"axis 0", "3 numbers for each sample", "3-vector"});
  write_file(path, concat(start, "sizes: 2 2 2 3\n\n", std::string(24, 'x')));
  expect_refusal([&] { read(path); }, ErrorCode::unsupported, {"4 axes in space"});
  write_file(path, "NRRD0004\ntype: uchar\ndimension: 2\nencoding: raw\nsizes: 2 2\n\n1234");
  expect_refusal([&] { read(path); }, ErrorCode::unsupported, {"2 axes in space"});
  write_file(
      path,
      concat("NRRD0004\ntype: block\nblock size: 3\nendian: little\ndimension: 3\nencoding: raw\nsizes: 2 2 2\n\n",
             std::string(24, 'x')));
  expect_refusal([&] { read(path); }, ErrorCode::unsupported, {"key type", "block"});
}

TEST(Nrrd, refuses_axes_that_lie_in_one_plane) {
  TemporaryFolder folder;
  write_file(folder / "a.nrrd",
             header(concat("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (1,1,0)\n", little)) + "\n" +
                 bytes_of_values(known_values<std::int16_t>()));
  expect_refusal([&] { read(folder / "a.nrrd"); }, ErrorCode::invalid, {"one plane"});
}

TEST(Nrrd, refuses_other_files_and_absurd_sizes) {
  TemporaryFolder folder;
  const auto path = folder / "a.nrrd";
  write_file(path, "P5\n2 2\n255\nabcd");  // Teem would read this as an image
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"a.nrrd, byte 0", "NRRD000"});
  write_file(path, "NRRD0004\ntype: float\ndimension: 3\nsizes: 1000 1000 1000\nencoding: raw\nendian: little\n\nabcd");
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"a.nrrd, key sizes", "4000000000 bytes"});
  write_file(path,
             "NRRD0004\ntype: float\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nencoding: raw\nendian: "
             "little\n\nab");
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"a.nrrd"});
  write_file(path, "NRRD0004\ntype: float\ndimension: 3\nsizes: 0 -4 5\nencoding: raw\nendian: little\n\nabcd");
  expect_refusal([&] { read(path); }, ErrorCode::invalid, {"a.nrrd"});
  expect_refusal([&] { read(folder / "none.nrrd"); }, ErrorCode::unreadable, {"none.nrrd"});
  write_file(path, header(little) + "\n" + bytes_of_values(known_values<std::int16_t>()));
  expect_refusal([&] { read(path, "b"); }, ErrorCode::usage, {"no field 'b'", "'a'"});
  EXPECT_EQ(read(path, "a").field_name, "a");
}

TEST(Nrrd, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const std::string content =
      header(concat("spacings: 1 2 3\n", little)) + "\n" + bytes_of_values(known_values<std::int16_t>());
  EXPECT_EQ(
      check_every_beginning(folder / "a.nrrd", content, [&] { return read(folder / "a.nrrd").samples.size() == 120; }),
      0);
}

}  // namespace
}  // namespace rhoray::preprocess
