#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNIFTIImageWriter.h>
#include <vtkNew.h>
#include <zlib.h>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/time_steps.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/vtk_lattice.h"
#include "tests/support/colors.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

NeutralVolume read(const std::filesystem::path& path) {
  return read_volume(path, {});
}

/// A NIfTI-1 file by hand (nifti1.h), in either byte order.
class File {
 public:
  explicit File(bool big_endian = false) : big_endian_(big_endian), header_(352, '\0') {
    set<std::int32_t>(0, 348);
    set_all<std::int16_t>(40, {3, 3, 4, 5, 1, 1, 1, 1});
    set<std::int16_t>(70, 4);   // int16
    set<std::int16_t>(72, 16);  // bits
    set_all<float>(76, {1, 2, 3, 4, 0, 0, 0, 0});
    set<float>(108, 352);
    header_.replace(344, 4, std::string("n+1\0", 4));
  }
  template <class T>
  File& set(std::size_t at, T value) {
    header_.replace(at, sizeof(T), bytes_of_values(std::vector<T>{value}, big_endian_));
    return *this;
  }
  template <class T>
  File& set_all(std::size_t at, const std::vector<T>& values) {
    header_.replace(at, sizeof(T) * values.size(), bytes_of_values(values, big_endian_));
    return *this;
  }
  std::string content() const { return header_ + bytes_of_values(known_values<std::int16_t>(), big_endian_); }
  /// The header, then these bytes.
  std::string followed_by(const std::string& samples) const { return header_ + samples; }

 private:
  bool big_endian_;
  std::string header_;
};

TEST(Nifti, reads_both_byte_orders_packed_or_not) {
  TemporaryFolder folder;
  for (const bool big_endian : {false, true}) {
    const std::string content = File(big_endian).content();
    write_file(folder / "a.nii", content);
    const NeutralVolume plain = read(folder / "a.nii");
    expect_known_values(plain, ElementType::I16);
    expect_map(plain.world_from_grid, axis_parallel_map({2, 3, 4}, {0, 0, 0}));
    EXPECT_EQ(plain.field_name, "a");
    EXPECT_EQ(plain.space, formats::Space::unknown);  // neither sform nor qform
    const gzFile packed = ::gzopen((folder / "a.nii.gz").c_str(), "wb");
    ::gzwrite(packed, content.data(), static_cast<unsigned>(content.size()));
    ::gzclose(packed);
    expect_known_values(read(folder / "a.nii.gz"), ElementType::I16);
    EXPECT_EQ(read(folder / "a.nii.gz").field_name, "a");
  }
}

TEST(Nifti, takes_the_sform_first_then_the_qform) {
  TemporaryFolder folder;
  File file;
  file.set<std::int16_t>(252, 1);  // qform: half a turn about z, mirrored along it
  file.set_all<float>(76, {-1, 2, 3, 4}).set_all<float>(256, {0, 0, 1, 7, 8, 9});
  write_file(folder / "a.nii", file.content());
  expect_map(read(folder / "a.nii").world_from_grid, {{-2, 0, 0}, {0, -3, 0}, {0, 0, -4}, {7, 8, 9}}, 1e-6);
  EXPECT_EQ(read(folder / "a.nii").space, formats::Space::ras);
  const float half = std::sqrt(0.5F);  // a quarter turn about x: y goes to z, z to -y
  file.set_all<float>(76, {1, 2, 3, 4}).set_all<float>(256, {half, 0, 0, 7, 8, 9});
  write_file(folder / "a.nii", file.content());
  expect_map(read(folder / "a.nii").world_from_grid, {{2, 0, 0}, {0, 0, 3}, {0, -4, 0}, {7, 8, 9}}, 1e-6);
  // A third of a turn about (1, 1, 1): x goes to y, y to z, z to x.
  file.set_all<float>(256, {0.5F, 0.5F, 0.5F, 7, 8, 9});
  write_file(folder / "a.nii", file.content());
  expect_map(read(folder / "a.nii").world_from_grid, {{0, 2, 0}, {0, 0, 3}, {4, 0, 0}, {7, 8, 9}}, 1e-6);
  file.set<std::int16_t>(254, 1)
      .set_all<float>(280, {0, -3, 0, 10, 2, 0, 0, 20, 0, 0.5F, 4, 30})
      .set<std::uint8_t>(123, 2);
  write_file(folder / "a.nii", file.content());
  const NeutralVolume volume = read(folder / "a.nii");
  expect_map(volume.world_from_grid, {{0, 2, 0}, {-3, 0, 0.5}, {0, 0, 4}, {10, 20, 30}});
  EXPECT_EQ(volume.length_unit, "mm");
}

TEST(Nifti, applies_the_scale_to_values) {
  TemporaryFolder folder;
  write_file(folder / "a.nii", File().set<float>(112, 0.5F).set<float>(116, -10).content());
  const NeutralVolume volume = read(folder / "a.nii");
  EXPECT_EQ(volume.type, ElementType::F32);
  EXPECT_EQ(values_of(volume)[7], known_values<int>()[7] * 0.5 - 10);
  EXPECT_THAT(volume.notes, testing::ElementsAre(testing::HasSubstr("0.5 times")));
  for (const auto& [slope, intercept] : {std::pair(0.0F, 5.0F), std::pair(1.0F, 0.0F), std::pair(NAN, 0.0F)}) {
    write_file(folder / "a.nii", File().set<float>(112, slope).set<float>(116, intercept).content());
    expect_known_values(read(folder / "a.nii"), ElementType::I16);
  }
}

TEST(Nifti, reads_what_vtk_writes) {
  TemporaryFolder folder;
  const vtkSmartPointer<vtkImageData> image = vtk_lattice(VTK_UNSIGNED_SHORT);
  image->SetSpacing(2, 3, 4);
  vtkNew<vtkMatrix4x4> pose;  // a turn about z and a shift; the spacing is the image's
  const double elements[16] = {0, -1, 0, 10, 1, 0, 0, 20, 0, 0, 1, 30, 0, 0, 0, 1};
  pose->DeepCopy(elements);
  vtkNew<vtkNIFTIImageWriter> writer;
  writer->SetInputData(image);
  writer->SetQFormMatrix(pose);
  writer->SetSFormMatrix(pose);
  writer->SetFileName((folder / "a.nii.gz").c_str());
  writer->Write();
  const NeutralVolume volume = read(folder / "a.nii.gz");
  expect_known_values(volume, ElementType::U16);
  expect_map(volume.world_from_grid, {{0, 2, 0}, {-3, 0, 0}, {0, 0, 4}, {10, 20, 30}}, 1e-6);
}

/// Three volumes: the known values, and those plus 100 and 200.
std::string three_volumes(bool big_endian, float time_step) {
  std::string samples;
  for (const int added : {0, 100, 200}) {
    std::vector<std::int16_t> values = known_values<std::int16_t>();
    for (std::int16_t& value : values) value = static_cast<std::int16_t>(value + added);
    samples += bytes_of_values(values, big_endian);
  }
  return File(big_endian)
      .set_all<std::int16_t>(40, {4, 3, 4, 5, 3})
      .set<float>(92, time_step)
      .set<float>(136, 10)
      .followed_by(samples);
}

std::string packed(const std::filesystem::path& path, const std::string& content) {
  const gzFile file = ::gzopen(path.c_str(), "wb");
  ::gzwrite(file, content.data(), static_cast<unsigned>(content.size()));
  ::gzclose(file);
  return read_file(path);
}

TEST(Nifti, reads_the_volume_of_a_time_step) {
  TemporaryFolder folder;
  for (const bool big_endian : {false, true}) {
    write_file(folder / "a.nii", three_volumes(big_endian, 2));
    packed(folder / "b.nii.gz", three_volumes(big_endian, 2));
    for (const char* name : {"a.nii", "b.nii.gz"}) {
      const auto first_of = [&](const std::string& time) {
        return values_of(read_volume(folder / name, {.time = time})).front();
      };
      expect_known_values(read(folder / name), ElementType::I16);
      EXPECT_THAT(read(folder / name).notes,
                  testing::ElementsAre("using the first of 3 volumes; choose another with --time"));
      EXPECT_EQ(first_of("first"), 0);
      EXPECT_EQ(first_of("last"), 200);
      EXPECT_EQ(first_of("#1"), 100);
      EXPECT_EQ(first_of("14"), 200);
      EXPECT_EQ(first_of("11.9"), 100);
      EXPECT_TRUE(read_volume(folder / name, {.time = "#1"}).notes.empty());
      expect_refusal([&] { first_of("#3"); }, ErrorCode::usage, {"#0 to #2"});
      expect_refusal([&] { first_of("soon"); }, ErrorCode::usage, {"'soon'"});
    }
  }
  write_file(folder / "a.nii", File().content());
  EXPECT_EQ(values_of(read_volume(folder / "a.nii", {.time = "last"})).size(), 60U);
}

TEST(Nifti, refuses_a_time_where_volumes_have_none) {
  TemporaryFolder folder;
  write_file(folder / "a.nii", three_volumes(false, 0));
  EXPECT_EQ(values_of(read_volume(folder / "a.nii", {.time = "#1"})).front(), 100);
  expect_refusal([&] { read_volume(folder / "a.nii", {.time = "0"}); }, ErrorCode::usage,
                 {"a.nii", "'0'", "first, last or #0 to #2", "no times"});
}

TEST(TimeSteps, with_a_time_are_nearer_than_those_without) {
  std::vector<std::string> notes;
  const double last_unknown[] = {0, NAN}, first_unknown[] = {NAN, 0, 1};
  EXPECT_EQ(choose_time_step(last_unknown, "0.1", "a.xdmf", notes), 0U);
  EXPECT_EQ(choose_time_step(first_unknown, "0.9", "a.xdmf", notes), 2U);
}

TEST(Nifti, says_how_much_behind_the_samples_is_left_out_and_notices_damage_there) {
  TemporaryFolder folder;
  const std::string content = File().content() + std::string(20000, 'x');
  const auto note = testing::ElementsAre(testing::HasSubstr("20000 bytes after the samples were left out"));
  write_file(folder / "a.nii", content);
  EXPECT_THAT(read(folder / "a.nii").notes, note);
  std::string stream = packed(folder / "p.gz", content);
  write_file(folder / "a.nii.gz", stream);
  EXPECT_THAT(read(folder / "a.nii.gz").notes, note);
  stream[stream.size() - 6] = static_cast<char>(stream[stream.size() - 6] ^ 1);  // in the checksum
  write_file(folder / "a.nii.gz", stream);
  expect_refusal([&] { read(folder / "a.nii.gz"); }, ErrorCode::invalid, {"a.nii.gz", "damaged data"});
}

TEST(Nifti, refuses_every_beginning_of_several_volumes) {
  TemporaryFolder folder;
  const auto is_complete = [&] { return read(folder / "a.nii").samples.size() == 120; };
  EXPECT_EQ(check_every_beginning(folder / "a.nii", three_volumes(false, 0), is_complete), 0);
  const std::string content = packed(folder / "p.gz", three_volumes(false, 0));
  EXPECT_EQ(check_every_beginning(folder / "a.nii", content, is_complete), 0);
}

TEST(Nifti, reads_a_file_put_together_from_packed_parts) {
  TemporaryFolder folder;
  const std::string content = File().content();
  const std::string both =
      packed(folder / "p.gz", content.substr(0, 400)) + packed(folder / "p.gz", content.substr(400));
  write_file(folder / "a.nii.gz", both);
  expect_known_values(read(folder / "a.nii.gz"), ElementType::I16);
}

TEST(Nifti, reads_colours) {
  TemporaryFolder folder;
  for (const auto& [datatype, components] : {std::pair(128, 3), std::pair(2304, 4)}) {
    const NeutralVolume expected = colors_of({size_x, size_y, size_z}, components, telling_texel);
    std::string texels(expected.samples.size(), '\0');
    std::memcpy(texels.data(), expected.samples.data(), texels.size());
    const std::string content = File().set(70, static_cast<std::int16_t>(datatype)).followed_by(texels);
    write_file(folder / "a.nii", content);
    packed(folder / "b.nii.gz", content);
    for (const char* name : {"a.nii", "b.nii.gz"}) {
      const NeutralVolume colors = read_volume(folder / name, {.colors = true});
      EXPECT_EQ(colors.component_count, components);
      EXPECT_TRUE(std::equal(colors.samples.begin(), colors.samples.end(), expected.samples.begin()));
      expect_map(colors.world_from_grid, axis_parallel_map({2, 3, 4}, {0, 0, 0}));
      const NeutralVolume shown = read(folder / name);
      EXPECT_TRUE(shown.field_name.ends_with(".mag")) << "a picture needs no choice";
      EXPECT_EQ(shown.component_count, 1);
    }
  }
  write_file(folder / "a.nii", File().content());
  expect_refusal([&] { read_volume(folder / "a.nii", {.colors = true}); }, ErrorCode::unsupported, {"datatype", "128"});
}

TEST(Nifti, refuses_what_it_cannot_mean) {
  TemporaryFolder folder;
  const auto path = folder / "a.nii";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read(path); }, error_code, words);
  };
  refuses(std::string(400, 'x'), ErrorCode::invalid, {"a.nii, byte 0", "348"});
  refuses(File().set<std::int32_t>(0, 540).content(), ErrorCode::unsupported, {"NIfTI-2"});
  refuses(File().set<std::int32_t>(344, 0).content(), ErrorCode::invalid, {"magic"});
  refuses(File().set_all<std::int16_t>(40, {4, 3, 4, 5, 2}).content(), ErrorCode::invalid,
          {"472 bytes", "240 bytes after the first 352"});
  refuses(File().set_all<std::int16_t>(40, {6, 3, 4, 5, 1, 1, 2}).content(), ErrorCode::unsupported,
          {"dim[6]", "2 groups"});
  refuses(File().set_all<std::int16_t>(40, {3, 3, 0, 5}).content(), ErrorCode::invalid, {"3 x 0 x 5"});
  refuses(File().set_all<std::int16_t>(40, {3, 30000, 30000, 30000}).content(), ErrorCode::invalid, {"samples"});
  refuses(File().set<std::int16_t>(70, 32).content(), ErrorCode::unsupported, {"datatype", "32"});
  refuses(File().set<std::int16_t>(70, 128).set_all<std::int16_t>(40, {5, 3, 4, 5, 1, 2}).content(),
          ErrorCode::unsupported, {"dim[5]", "2 colours"});
  refuses(File().set<float>(108, NAN).content(), ErrorCode::invalid, {"vox_offset"});
  refuses(File().set<float>(108, 1e6F).content(), ErrorCode::invalid, {"samples", "after the first 1000000"});
  refuses(File().set<std::int16_t>(254, 1).content(), ErrorCode::invalid, {"one plane"});
}

TEST(Nifti, refuses_every_beginning_of_a_file_and_notices_damage) {
  TemporaryFolder folder;
  const auto is_complete = [&] { return read(folder / "a.nii").samples.size() == 120; };
  EXPECT_EQ(check_every_beginning(folder / "a.nii", File().content(), is_complete), 0);
  const gzFile file = ::gzopen((folder / "p.gz").c_str(), "wb");
  ::gzwrite(file, File().content().data(), 472);
  ::gzclose(file);
  std::string packed = read_file(folder / "p.gz");
  EXPECT_EQ(check_every_beginning(folder / "a.nii", packed, is_complete), 0);
  packed[packed.size() - 6] = static_cast<char>(packed[packed.size() - 6] ^ 1);  // in the checksum
  write_file(folder / "a.nii", packed);
  expect_refusal([&] { read(folder / "a.nii"); }, ErrorCode::invalid, {"damaged data"});
}

}  // namespace
}  // namespace rhoray::preprocess
