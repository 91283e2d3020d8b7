#include <vtkImageData.h>
#include <vtkMetaImageWriter.h>
#include <vtkNew.h>
#include <zlib.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/vtk_lattice.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

NeutralVolume read(const std::filesystem::path& path) {
  return read_volume(path, {});
}

std::string header(const std::string& lines) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 3 4 5\n" + lines;
}

TEST(MetaImage, keeps_direction_spacing_and_origin) {
  TemporaryFolder folder;
  write_file(folder / "a.mha",
             header("TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 20 -30\nElementSpacing = 2 3 4\n"
                    "ElementType = MET_USHORT\nElementDataFile = LOCAL\n") +
                 bytes_of_values(known_values<std::uint16_t>()));
  const NeutralVolume volume = read(folder / "a.mha");
  expect_known_values(volume, ElementType::U16);
  expect_map(volume.world_from_grid, {{0, 2, 0}, {-3, 0, 0}, {0, 0, 4}, {10, 20, -30}});  // rows are axes of the grid
}

TEST(MetaImage, lies_in_lps_where_it_names_its_axes) {
  TemporaryFolder folder;
  for (const auto& [line, space] : {std::pair{"AnatomicalOrientation = RAI\n", formats::Space::lps},
                                    {"AnatomicalOrientation = ???\n", formats::Space::unknown},
                                    {"", formats::Space::unknown}}) {
    write_file(folder / "a.mha", header(std::string(line) + "ElementType = MET_USHORT\nElementDataFile = LOCAL\n") +
                                     bytes_of_values(known_values<std::uint16_t>()));
    EXPECT_EQ(read(folder / "a.mha").space, space) << line;
  }
}

TEST(MetaImage, reads_what_vtk_writes_plain_and_compressed) {
  TemporaryFolder folder;
  for (const bool compressed : {false, true}) {
    const vtkSmartPointer<vtkImageData> image = vtk_lattice(VTK_FLOAT);
    image->SetSpacing(0.5, 1, 2);
    image->SetOrigin(-1, 0, 3);
    vtkNew<vtkMetaImageWriter> writer;
    writer->SetInputData(image);
    writer->SetCompression(compressed);
    writer->SetFileName((folder / "a.mhd").c_str());
    writer->SetRAWFileName((folder / (compressed ? "a.zraw" : "a.raw")).c_str());
    writer->Write();
    const NeutralVolume volume = read(folder / "a.mhd");
    expect_known_values(volume, ElementType::F32);
    expect_map(volume.world_from_grid, axis_parallel_map({0.5, 1, 2}, {-1, 0, 3}));
  }
}

TEST(MetaImage, reads_lists_and_numbered_files_and_skips_headers) {
  TemporaryFolder folder;
  const std::string samples = bytes_of_values(known_values<std::int32_t>(), true);
  std::string list;
  for (std::size_t slice = 0; slice < 5; ++slice) {
    write_file(folder / concat("s0", 3 + 2 * slice), "head" + samples.substr(slice * 48, 48));
    list += concat("s0", 3 + 2 * slice, "\n");
  }
  const std::string type = "ElementByteOrderMSB = True\nElementType = MET_INT\n";
  write_file(folder / "a.mhd", header(type + "HeaderSize = -1\nElementDataFile = s%02d 3 9 2\n"));
  expect_refusal([&] { read(folder / "a.mhd"); }, ErrorCode::invalid, {"a.mhd", "4 files for 5 slices"});
  std::filesystem::rename(folder / "s011", folder / "s11");
  write_file(folder / "a.mhd", header(type + "HeaderSize = -1\nElementDataFile = s%02d 3 11 2\n"));
  expect_known_values(read(folder / "a.mhd"), ElementType::I32);
  std::filesystem::rename(folder / "s11", folder / "s011");
  write_file(folder / "b.mhd", header(type + "HeaderSize = 4\nElementDataFile = LIST\n" + list));
  expect_known_values(read(folder / "b.mhd"), ElementType::I32);
  write_file(folder / "short", "head" + std::string(57, 'x'));
  write_file(folder / "c.mhd", header("HeaderSize = 4\nElementType = MET_UCHAR\nElementDataFile = short\n"));
  expect_refusal([&] { read(folder / "c.mhd"); }, ErrorCode::invalid,
                 {"short", "byte 61", "60 bytes of samples after the first 4"});
}

TEST(MetaImage, refuses_what_it_cannot_mean) {
  TemporaryFolder folder;
  const auto path = folder / "a.mha";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read(path); }, error_code, words);
  };
  refuses("NDims = 2\nDimSize = 3 4\nElementDataFile = LOCAL\n", ErrorCode::unsupported, {"key NDims", "2"});
  refuses("NDims = 3\nDimSize = 3 4\nElementDataFile = LOCAL\n", ErrorCode::invalid, {"key DimSize", "2 numbers"});
  refuses("NDims = 3\nDimSize = 3 four 5\nElementDataFile = LOCAL\n", ErrorCode::invalid, {"key DimSize", "'four'"});
  refuses(header("ElementType = MET_NONE\nElementDataFile = LOCAL\n"), ErrorCode::unsupported, {"MET_NONE"});
  refuses(header("ElementNumberOfChannels = 0\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"),
          ErrorCode::unsupported, {"0 numbers for each sample"});
  refuses(header("ElementNumberOfChannels = 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"), ErrorCode::invalid,
          {"180 bytes"});
  refuses(header("ElementType = MET_UCHAR\nElementDataFile = none.raw\n"), ErrorCode::unreadable, {"none.raw"});
  refuses(header("ElementSpacing = 1 0 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n") + std::string(60, 'x'),
          ErrorCode::invalid, {"spacing of 0"});
  refuses(header("TransformMatrix = 1 0 0 1 1e-10 0 0 0 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n") +
              std::string(60, 'x'),
          ErrorCode::invalid, {"axes that lie in one plane"});
  refuses("NDims = 3\nDimSize = 100000 100000 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nxx",
          ErrorCode::invalid, {"10000000000 bytes"});
  refuses(
      "NDims = 3\nDimSize = 100000 100000 1\nCompressedData = True\nElementType = MET_UCHAR\nElementDataFile = "
      "LOCAL\nxx",
      ErrorCode::invalid, {"packed bytes"});
  refuses("something else entirely", ErrorCode::invalid, {"a.mha, header", "Key = value"});
}

TEST(MetaImage, notices_damage_in_compressed_samples) {
  TemporaryFolder folder;
  const std::string samples = bytes_of_values(known_values<std::uint8_t>());
  std::vector<Bytef> packed(::compressBound(samples.size()));
  uLongf size = packed.size();
  ASSERT_EQ(::compress(packed.data(), &size, reinterpret_cast<const Bytef*>(samples.data()), samples.size()), Z_OK);
  std::string stream(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
  const std::string start = header("CompressedData = True\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n");
  write_file(folder / "a.mha", start + stream);
  expect_known_values(read(folder / "a.mha"), ElementType::U8);
  stream.back() = static_cast<char>(stream.back() ^ 1);  // in the checksum
  write_file(folder / "a.mha", start + stream);
  expect_refusal([&] { read(folder / "a.mha"); }, ErrorCode::invalid, {"a.mha", "damaged data"});
}

std::string packed(const std::string& samples) {
  std::string stream(::compressBound(samples.size()), '\0');
  uLongf size = stream.size();
  EXPECT_EQ(::compress(reinterpret_cast<Bytef*>(stream.data()), &size, reinterpret_cast<const Bytef*>(samples.data()),
                       samples.size()),
            Z_OK);
  return stream.substr(0, size);
}

TEST(MetaImage, notices_damage_behind_compressed_samples_and_says_how_much_is_left_out) {
  TemporaryFolder folder;
  const std::string start = header("CompressedData = True\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n");
  std::string stream = packed(bytes_of_values(known_values<std::uint8_t>()) + std::string(20000, 'x'));
  write_file(folder / "a.mha", start + stream);
  const NeutralVolume volume = read(folder / "a.mha");
  expect_known_values(volume, ElementType::U8);
  EXPECT_THAT(volume.notes, testing::ElementsAre(testing::HasSubstr("20000 bytes after the samples were left out")));
  stream.back() = static_cast<char>(stream.back() ^ 1);  // in the checksum
  write_file(folder / "a.mha", start + stream);
  expect_refusal([&] { read(folder / "a.mha"); }, ErrorCode::invalid, {"a.mha", "damaged data"});
}

TEST(MetaImage, skips_headers_of_compressed_files_whose_names_hold_spaces) {
  TemporaryFolder folder;
  write_file(folder / "a  b.zraw", "a header" + packed(bytes_of_values(known_values<std::uint8_t>())));
  write_file(folder / "a.mhd", header("CompressedData = True\nHeaderSize = 8\nElementType = MET_UCHAR\n"
                                      "ElementDataFile =  a  b.zraw \r\n"));
  expect_known_values(read(folder / "a.mhd"), ElementType::U8);
}

TEST(MetaImage, takes_the_unit_of_length_and_says_that_a_scale_is_left_out) {
  TemporaryFolder folder;
  const auto read_with = [&](const std::string& lines) {
    write_file(folder / "a.mha", header(lines + "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n") +
                                     bytes_of_values(known_values<std::uint8_t>()));
    return read(folder / "a.mha");
  };
  EXPECT_EQ(read_with("DistanceUnits = um\n").length_unit, "um");
  EXPECT_EQ(read_with("DistanceUnits = ?\n").length_unit, "");
  EXPECT_EQ(read_with("").length_unit, "");
  EXPECT_THAT(read_with("ElementToIntensityFunctionSlope = 1\nElementToIntensityFunctionOffset = 0\n").notes,
              testing::IsEmpty());
  const NeutralVolume scaled =
      read_with("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1000\n");
  expect_known_values(scaled, ElementType::U8);
  EXPECT_THAT(scaled.notes, testing::ElementsAre(testing::HasSubstr("2 times the number plus -1000")));
}

TEST(MetaImage, refuses_repeated_keys_and_endless_lists) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& lines, const std::vector<std::string>& words) {
    write_file(folder / "a.mhd", header("ElementType = MET_UCHAR\n" + lines));
    expect_refusal([&] { read(folder / "a.mhd"); }, ErrorCode::invalid, words);
  };
  refuses("DimSize = 5 4 3\nElementDataFile = a.raw\n", {"a.mhd, key DimSize", "a second one", "each key once"});
  refuses("ElementDataFile = s%d.raw -2147483648 2147483647\n", {"a.mhd", "FIRST LAST"});
  refuses("ElementDataFile = s%d.raw 2147483646 2147483647 1\n", {"2 files for 5 slices"});
  refuses("ElementDataFile = s%d.raw 1 2147483647 2147483646\n", {"2 files for 5 slices"});
}

TEST(MetaImage, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  const std::string content =
      header("ElementType = MET_UCHAR\nElementDataFile = LOCAL\n") + bytes_of_values(known_values<std::uint8_t>());
  EXPECT_EQ(
      check_every_beginning(folder / "a.mha", content, [&] { return read(folder / "a.mha").samples.size() == 60; }), 0);
}

}  // namespace
}  // namespace rhoray::preprocess
