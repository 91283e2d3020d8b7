#include <minizip/zip.h>
#include <vtkImageData.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkTIFFWriter.h>

#include <cmath>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/zip_archive.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/vtk_lattice.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::ElementsAre;
using testing::HasSubstr;

template <class T>
std::string bytes_of(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof value);
}

/// One element in explicit little-endian coding (DICOM PS3.5, section 7.1.2).
std::string element(std::uint16_t group, std::uint16_t number, const char* kind, std::string value) {
  if (value.size() % 2 != 0) value += std::string_view(kind) == "UI" ? '\0' : ' ';
  const std::string head = bytes_of(group) + bytes_of(number) + kind;
  if (std::string_view(kind) == "OW" || std::string_view(kind) == "OB")
    return head + std::string(2, '\0') + bytes_of(static_cast<std::uint32_t>(value.size())) + value;
  return head + bytes_of(static_cast<std::uint16_t>(value.size())) + value;
}

struct ImageFacts {
  int slice = 0;  ///< of known_values
  std::string position = "10\\20\\30";
  std::string rows_and_columns = "1\\0\\0\\0\\1\\0";
  std::string series = "1.2.3";
  std::string description = "head";
  std::string modality = "CT";
  std::string slope = "1", intercept = "-1000";
  int bits = 16, stored_bits = 12;
  bool is_signed = false;
  std::int64_t add = 0;  ///< to the stored values
  std::string photometric = "MONOCHROME2";
  int columns = size_x;
  std::string more{};   ///< elements between the scale and the samples
  bool packed = false;  ///< by runs of bytes (RLE), for 8 bits
};

constexpr std::string_view end_of_fragments("\xfe\xff\xdd\xe0\0\0\0\0", 8);

/// Bytes of one image as one fragment of runs (DICOM PS3.5, section A.4 and annex G).
std::string fragments_of(const std::string& samples) {
  std::string frame = bytes_of(std::uint32_t{1}) + bytes_of(std::uint32_t{64}) + std::string(56, '\0');
  frame += static_cast<char>(samples.size() - 1);
  frame += samples;
  if (frame.size() % 2 != 0) frame += '\0';
  const std::string item("\xfe\xff\x00\xe0", 4);
  return item + bytes_of(std::uint32_t{0}) + item + bytes_of(static_cast<std::uint32_t>(frame.size())) + frame +
         std::string(end_of_fragments);
}

std::string dicom(const ImageFacts& facts) {
  const std::string syntax = element(2, 0x10, "UI", facts.packed ? "1.2.840.10008.1.2.5" : "1.2.840.10008.1.2.1");
  const std::string kind = element(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(2, 3, "UI", "1.2.9");
  const std::string meta = kind + syntax;
  const auto u16 = [](std::uint16_t group, std::uint16_t number, int value) {
    return element(group, number, "US", bytes_of(static_cast<std::uint16_t>(value)));
  };
  std::string samples;
  for (int j = 0; j < size_y; ++j)
    for (int i = 0; i < size_x; ++i) {
      const std::int64_t value = value_at(i, j, facts.slice) + facts.add;
      if (facts.bits == 8)
        samples += static_cast<char>(value);
      else if (facts.bits == 32)
        samples += bytes_of(static_cast<std::uint32_t>(value));
      else
        samples += bytes_of(static_cast<std::uint16_t>(value & ((1 << facts.stored_bits) - 1)));
    }
  const std::string pixel_data = facts.packed ? bytes_of(std::uint16_t{0x7fe0}) + bytes_of(std::uint16_t{0x10}) +
                                                    std::string("OB\0\0", 4) + bytes_of(~std::uint32_t{0}) +
                                                    fragments_of(samples)
                                              : element(0x7fe0, 0x10, facts.bits == 8 ? "OB" : "OW", samples);
  return std::string(128, '\0') + "DICM" + element(2, 0, "UL", bytes_of(static_cast<std::uint32_t>(meta.size()))) +
         meta + element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") + element(8, 0x18, "UI", "1.2.9") +
         element(8, 0x60, "CS", facts.modality) + element(8, 0x103e, "LO", facts.description) +
         element(0x20, 0xe, "UI", facts.series) + element(0x20, 0x32, "DS", facts.position) +
         element(0x20, 0x37, "DS", facts.rows_and_columns) + u16(0x28, 2, 1) +
         element(0x28, 4, "CS", facts.photometric) + u16(0x28, 0x10, size_y) + u16(0x28, 0x11, facts.columns) +
         element(0x28, 0x30, "DS", "0.5\\0.25") + u16(0x28, 0x100, facts.bits) + u16(0x28, 0x101, facts.stored_bits) +
         u16(0x28, 0x102, facts.stored_bits - 1) + u16(0x28, 0x103, facts.is_signed ? 1 : 0) +
         element(0x28, 0x1052, "DS", facts.intercept) + element(0x28, 0x1053, "DS", facts.slope) + facts.more +
         pixel_data;
}

/// Five slices, numbered so that neither their names nor their order in the folder is that in
/// space.
void write_series(const std::filesystem::path& folder, const std::function<void(ImageFacts&)>& change = {}) {
  for (int k = 0; k < size_z; ++k) {
    ImageFacts facts;
    facts.slice = k;
    facts.position = concat("10\\20\\", 30 - 2 * (size_z - 1 - k));
    if (change) change(facts);
    write_file(folder / concat("IM", (k * 3) % 5), dicom(facts));
  }
}

class Dicom : public testing::Test {
 protected:
  NeutralVolume read(const std::string& field = {}) { return read_volume(folder_.path(), {.raw = {}, .field = field}); }
  TemporaryFolder folder_;
};

TEST_F(Dicom, sorts_a_series_by_place_and_scales_it_to_hounsfield_units) {
  write_series(folder_.path(), [](ImageFacts& facts) { facts.add = 1000; });
  EXPECT_EQ(foreign_kind(folder_.path()), ForeignKind::volume);
  const NeutralVolume volume = read();
  expect_known_values(volume, ElementType::I16);
  expect_map(volume.world_from_grid, axis_parallel_map({0.25, 0.5, 2}, {10, 20, 22}));
  EXPECT_TRUE(volume.axes[2].empty());
  EXPECT_EQ(volume.length_unit, "mm");
  EXPECT_EQ(volume.space, formats::Space::lps);
  EXPECT_EQ(volume.field_unit, "HU");
  EXPECT_EQ(volume.field_name, "head");
}

TEST_F(Dicom, reads_signed_values_of_few_bits) {
  write_series(folder_.path(), [](ImageFacts& facts) {
    facts.is_signed = true;
    facts.add = -100;
    facts.intercept = "100";
  });
  expect_known_values(read(), ElementType::I16);
}

TEST_F(Dicom, reads_bytes_and_slopes) {
  write_series(folder_.path(), [](ImageFacts& facts) {
    facts.bits = facts.stored_bits = 8;
    facts.intercept = "0";
  });
  expect_known_values(read(), ElementType::U8);
  write_series(folder_.path(), [](ImageFacts& facts) { facts.slope = "0.5"; });
  const NeutralVolume volume = read();
  EXPECT_EQ(volume.type, ElementType::F32);
  EXPECT_EQ(values_of(volume)[7], 0.5 * known_values<double>()[7] - 1000);
}

/// Integers beyond 32 bits wrapped around, and 32-bit floats rounded.
TEST_F(Dicom, takes_long_floats_for_numbers_that_shorter_types_cannot_hold) {
  struct Case {
    int bits;
    std::int64_t add;
    const char *slope, *intercept;
    ElementType type;
  };
  for (const Case& row : {Case{32, 4294967143, "1", "1000", ElementType::F64},
                          Case{16, 0, "1", "5e9", ElementType::F64}, Case{16, 0, "1", "-5e9", ElementType::F64},
                          Case{16, 0, "1", "1e300", ElementType::F64}, Case{16, 0, "1", "4294901760", ElementType::U32},
                          Case{32, 16777217, "2", "0", ElementType::F64}, Case{16, 1, "2", "0", ElementType::F32},
                          Case{16, 0, "0.5", "1e9", ElementType::F64}, Case{16, 1, "1e40", "0", ElementType::F64}}) {
    write_series(folder_.path(), [&](ImageFacts& facts) {
      facts.bits = facts.stored_bits = row.bits;
      facts.add = row.add;
      facts.slope = row.slope;
      facts.intercept = row.intercept;
    });
    const NeutralVolume volume = read();
    EXPECT_EQ(volume.type, row.type) << row.slope << ' ' << row.intercept;
    std::vector<double> expected = known_values<double>();
    for (double& value : expected)
      value = (value + static_cast<double>(row.add)) * std::stod(row.slope) + std::stod(row.intercept);
    EXPECT_EQ(values_of(volume), expected) << row.slope << ' ' << row.intercept;
  }
}

TEST_F(Dicom, refuses_indices_into_a_table_of_colours) {
  std::string table;
  for (std::uint16_t number = 0x1101; number <= 0x1103; ++number)
    table += element(0x28, number, "US", bytes_of(std::uint16_t{256}) + std::string("\0\0\x10\0", 4));
  for (std::uint16_t number = 0x1201; number <= 0x1203; ++number)
    table += element(0x28, number, "OW", std::string(512, '\1'));
  write_series(folder_.path(), [&](ImageFacts& facts) {
    facts.bits = facts.stored_bits = 8;
    facts.intercept = "0";
    facts.photometric = "PALETTE COLOR";
    facts.more = table;
  });
  expect_refusal([&] { read(); }, ErrorCode::unsupported, {"IM", "PALETTE COLOR", "MONOCHROME"});
}

TEST_F(Dicom, gives_series_of_one_description_names_of_their_own) {
  write_series(folder_.path(), [](ImageFacts& facts) { facts.add = 1000; });
  for (int k = 0; k < 2; ++k)
    write_file(folder_ / concat("b", k),
               dicom({.slice = k, .position = concat("0\\0\\", k), .series = "1.2.4", .intercept = "0"}));
  const NeutralVolume volume = read();
  expect_known_values(volume, ElementType::I16);
  EXPECT_EQ(volume.field_name, "head (1.2.3)");
  EXPECT_THAT(volume.other_fields, ElementsAre("head (1.2.4)"));
  EXPECT_EQ(read("head (1.2.4)").sample_count, Index3(3, 4, 2));
  EXPECT_EQ(read("1.2.4").sample_count, Index3(3, 4, 2));
  expect_refusal([&] { read("head"); }, ErrorCode::usage, {"'head'", "'head (1.2.3)'", "'head (1.2.4)'"});
}

/// GDCM fills what is missing with numbers of its own.
TEST_F(Dicom, refuses_every_beginning_of_packed_images) {
  ImageFacts facts{.intercept = "0", .bits = 8, .stored_bits = 8, .packed = true};
  const std::string content = dicom(facts);
  write_file(folder_ / "a.dcm", content);
  const auto is_whole = [&] {
    const NeutralVolume volume = read_volume(folder_ / "a.dcm", {});
    return values_of(volume).size() == 12 && values_of(volume)[11] == value_at(2, 3, 0);
  };
  EXPECT_TRUE(is_whole());
  for (std::size_t cut = 1; cut < 100; ++cut) {
    write_file(folder_ / "a.dcm", std::string_view(content).substr(0, content.size() - cut));
    expect_refusal([&] { read(); }, ErrorCode::invalid, {"a.dcm"});
  }
  facts.columns = 60000;
  write_file(folder_ / "a.dcm", dicom(facts));
  expect_refusal([&] { read(); }, ErrorCode::invalid, {"240000 bytes", "packed bytes"});
}

TEST_F(Dicom, keeps_oblique_directions_and_uneven_steps) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  write_series(folder_.path(), [&](ImageFacts& facts) {
    facts.rows_and_columns = concat("1\\0\\0\\0\\", c, "\\", s);
    const double way = facts.slice == 4 ? 9 : 2 * facts.slice;
    facts.position = concat("0\\", -s * way, "\\", c * way);
    facts.add = 1000;
  });
  const NeutralVolume volume = read();
  expect_known_values(volume, ElementType::I16);
  expect_map(volume.world_from_grid, {{0.25, 0, 0}, {0, 0.5 * c, 0.5 * s}, {0, -s, c}, {0, 0, 0}}, 1e-5);
  ASSERT_EQ(volume.axes[2].size(), 5U);
  EXPECT_NEAR(volume.axes[2][4], 9, 1e-5);
  EXPECT_THAT(volume.notes, ElementsAre(HasSubstr("steps between images differ")));
}

TEST_F(Dicom, takes_the_largest_series_or_the_one_that_is_named) {
  write_series(folder_.path(), [](ImageFacts& facts) { facts.add = 1000; });
  write_file(folder_ / "scout", dicom({.series = "9.9", .description = "scout"}));
  write_file(folder_ / "readme.txt", "hello");
  const NeutralVolume volume = read();
  expect_known_values(volume, ElementType::I16);
  EXPECT_THAT(volume.notes,
              testing::UnorderedElementsAre(HasSubstr("'scout' (1 images)"), HasSubstr("1 files left out")));
  EXPECT_THAT(volume.other_fields, ElementsAre("scout"));
  EXPECT_EQ(read("scout").sample_count, Index3(3, 4, 1));
  expect_refusal([&] { read("scuot"); }, ErrorCode::usage, {"'scuot'", "'head'", "'scout'"});
}

TEST_F(Dicom, refuses_series_that_make_no_volume) {
  const auto refuses = [&](const std::function<void(ImageFacts&)>& change, ErrorCode error_code,
                           const std::string& word) {
    write_series(folder_.path(), change);
    expect_refusal([&] { read(); }, error_code, {word});
  };
  refuses([](ImageFacts& facts) { facts.position = "1\\2\\3"; }, ErrorCode::unsupported, "at the place of");
  refuses([](ImageFacts& facts) { facts.position = concat(facts.slice == 2 ? 5 : 0, "\\0\\", facts.slice); },
          ErrorCode::unsupported, "in one line");
  refuses(
      [](ImageFacts& facts) {
        if (facts.slice == 3) facts.rows_and_columns = "0\\1\\0\\1\\0\\0";
      },
      ErrorCode::unsupported, "does not lie as");
}

TEST_F(Dicom, reads_a_zip_archive_and_refuses_every_beginning_of_it) {
  const std::filesystem::path path = folder_ / "series.zip";
  zipFile archive = zipOpen64(path.c_str(), APPEND_STATUS_CREATE);
  for (int k = 0; k < size_z; ++k) {
    ImageFacts facts;
    facts.slice = k;
    facts.position = concat("0\\0\\", k);
    facts.add = 1000;
    const std::string bytes = dicom(facts);
    zip_fileinfo info{};
    ASSERT_EQ(zipOpenNewFileInZip(archive, concat("series/", k).c_str(), &info, nullptr, 0, nullptr, 0, nullptr,
                                  Z_DEFLATED, 6),
              ZIP_OK);
    ASSERT_EQ(zipWriteInFileInZip(archive, bytes.data(), static_cast<unsigned>(bytes.size())), ZIP_OK);
    zipCloseFileInZip(archive);
  }
  zipClose(archive, nullptr);
  const auto is_whole = [&] { return values_of(read_volume(path, {})) == known_values<double>(); };
  EXPECT_TRUE(is_whole());
  EXPECT_LE(check_every_beginning(path, read_file(path), is_whole, {.stride = 37}), 4);  // the last bytes say little
}

/// minizip leaves a name as long as the array without a zero byte at its end.
TEST_F(Dicom, names_in_a_zip_archive_end_where_the_archive_says) {
  const std::filesystem::path path = folder_ / "names.zip";
  for (const std::size_t length : {std::size_t{4095}, std::size_t{4096}, std::size_t{4097}, std::size_t{65535}}) {
    std::filesystem::remove(path);
    zipFile archive = zipOpen64(path.c_str(), APPEND_STATUS_CREATE);
    const std::string name(length, 'n');
    zip_fileinfo info{};
    ASSERT_EQ(zipOpenNewFileInZip(archive, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED, 6),
              ZIP_OK);
    ASSERT_EQ(zipWriteInFileInZip(archive, "text", 4), ZIP_OK);
    zipCloseFileInZip(archive);
    zipClose(archive, nullptr);
    std::string taken;
    const auto read_names = [&] {
      preprocess::read_zip(path, [&](const std::string& entry, std::string_view) { taken = entry; });
    };
    if (length > 4096) {
      expect_refusal(read_names, ErrorCode::invalid,
                     {"names.zip", "table of contents", concat("found a name of ", length, " bytes"), "at most 4096"});
    } else {
      read_names();
      EXPECT_EQ(taken.size(), length);
      EXPECT_EQ(taken, name);
    }
  }
}

/// GDCM aborts on some of them: through the worker, that is a sentence too.
TEST_F(Dicom, every_beginning_of_a_file_ends_as_a_sentence) {
  ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  const std::filesystem::path path = folder_ / "a.dcm";
  const std::string content = dicom({.intercept = "0", .add = 0});
  const auto is_whole = [&] {
    const NeutralVolume volume = import_volume(path);
    return volume.sample_count == Index3(3, 4, 1) && values_of(volume)[11] == value_at(2, 3, 0);
  };
  EXPECT_EQ(check_every_beginning(path, content, is_whole, {.stride = 61}), 0);
}

std::string picture(int slice, bool colour = false, int maximum = 255) {
  std::string text = concat(colour ? "P6" : "P5", "\n", size_x, " ", size_y, "\n", maximum, "\n");
  for (int j = 0; j < size_y; ++j)
    for (int i = 0; i < size_x; ++i)
      for (int channel = 0; channel < (colour ? 3 : 1); ++channel) {
        const int value = value_at(i, j, slice) + channel;
        if (maximum > 255) text += static_cast<char>(value >> 8);
        text += static_cast<char>(value);
      }
  return text;
}

class Slices : public testing::Test {
 protected:
  void SetUp() override { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }
  NeutralVolume read(const std::string& field = {}) {
    ImportVolumeOptions options;
    options.field = field;
    return import_volume(folder_.path(), options);
  }
  TemporaryFolder folder_;
};

TEST_F(Slices, stand_in_the_order_of_their_numbers) {
  for (int k = 0; k < size_z; ++k) write_file(folder_ / concat("s", 8 + k, ".pgm"), picture(k));  // 8, 9, 10, 11, 12
  EXPECT_EQ(foreign_kind(folder_.path()), ForeignKind::volume);
  const NeutralVolume volume = read();
  expect_known_values(volume, ElementType::U8);
  EXPECT_THAT(volume.notes, ElementsAre(HasSubstr("--spacing")));
}

TEST_F(Slices, keep_sixteen_bits) {
  for (int k = 0; k < size_z; ++k) write_file(folder_ / concat("s", k, ".pgm"), picture(k, false, 65535));
  expect_known_values(read(), ElementType::U16);
}

TEST_F(Slices, of_colours_show_their_magnitude_without_a_choice) {
  for (int k = 0; k < size_z; ++k) write_file(folder_ / concat("s", k, ".ppm"), picture(k, true));
  const NeutralVolume shown = read();
  EXPECT_EQ(shown.field_name, "colors.mag");
  EXPECT_NEAR(values_of(shown)[0], std::sqrt(5), 1e-6);  // 0, 1, 2
  EXPECT_THAT(shown.notes,
              testing::Contains(HasSubstr("'colors.mag'; choose another with --field: R, G, B, luminance")));
  expect_known_values(read("R"), ElementType::U8);
  EXPECT_EQ(values_of(read("B"))[0], 2);
  EXPECT_EQ(values_of(read("luminance"))[0], 0);  // 0.7152 * 1 + 0.0722 * 2, cut to a whole number
  expect_refusal([&] { read("grey"); }, ErrorCode::usage, {"'grey'", "R, G, B, luminance"});
}

TEST_F(Slices, must_all_be_alike) {
  for (int k = 0; k < size_z; ++k)
    write_file(folder_ / concat("s", k, ".pgm"), picture(k, false, k == 3 ? 65535 : 255));
  expect_refusal([&] { read(); }, ErrorCode::invalid, {"s3.pgm", "as the first slice"});
  write_file(folder_ / "s3.pgm", picture(3).substr(0, 12));
  expect_refusal([&] { read(); }, ErrorCode::invalid, {"s3.pgm"});
  write_file(folder_ / "s3.pgm", "no picture");
  expect_refusal([&] { read(); }, ErrorCode::invalid, {"s3.pgm"});
}

/// OpenImageIO fills the rest of such a picture.
TEST_F(Slices, that_are_cut_are_refused) {
  vtkNew<vtkJPEGWriter> writer;
  writer->SetInputData(vtk_lattice(VTK_UNSIGNED_CHAR));
  writer->SetFilePrefix((folder_ / "s").c_str());
  writer->SetFilePattern("%s%d.jpg");
  writer->Write();
  EXPECT_EQ(read().sample_count, Index3(size_x, size_y, size_z));
  const std::string content = read_file(folder_ / "s3.jpg");
  write_file(folder_ / "s3.jpg", content + "bytes behind the picture");
  EXPECT_EQ(read().sample_count, Index3(size_x, size_y, size_z));
  for (const std::size_t cut : {1, 2, 3, 5, 9}) {
    write_file(folder_ / "s3.jpg", std::string_view(content).substr(0, content.size() - cut));
    expect_refusal([&] { read(); }, ErrorCode::invalid, {"s3.jpg", "damaged"});
  }
}

TEST_F(Slices, of_several_pages_each_are_refused) {
  for (const char* name : {"a.tif", "b.tif"}) {
    vtkNew<vtkTIFFWriter> writer;
    writer->SetInputData(vtk_lattice(VTK_UNSIGNED_CHAR));
    writer->SetFileName((folder_ / name).c_str());
    writer->Write();
  }
  EXPECT_EQ(import_volume(folder_ / "a.tif", {}).sample_count, Index3(size_x, size_y, size_z));
  expect_refusal([&] { read(); }, ErrorCode::unsupported, {"a.tif", "several pages", "one picture"});
}

TEST_F(Slices, that_claim_more_than_their_files_can_hold_are_refused) {
  for (const char* name : {"a.pgm", "b.pgm"}) write_file(folder_ / name, "P5\n60000 60000\n255\nab");
  expect_refusal([&] { read(); }, ErrorCode::invalid, {"7200000000 bytes", "packed bytes"});
}

TEST_F(Slices, one_picture_is_no_volume) {
  write_file(folder_ / "s.pgm", picture(0));
  expect_refusal([&] { read(); }, ErrorCode::unsupported, {"found 1 slice"});
  ImportVolumeOptions options;
  expect_refusal([&] { import_volume(folder_ / "s.pgm", options); }, ErrorCode::unsupported, {"found 1 slice"});
}

}  // namespace
}  // namespace rhoray::preprocess
