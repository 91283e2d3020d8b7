#include <vtkImageData.h>
#include <vtkMetaImageWriter.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkTIFFWriter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedShortArray.h>
#include <vtkXMLImageDataWriter.h>

#include <cstdlib>

#include "preprocess/import/readers.h"
#include "preprocess/import_volume.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/colors.h"

// Colours by other programs' writers, read back texel for texel.
namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::HasSubstr;

class Colors : public testing::Test {
 protected:
  void SetUp() override { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }
};

template <class Samples = vtkUnsignedCharArray>
vtkNew<vtkImageData> image(int components, int first_slice, int slice_count) {
  vtkNew<vtkImageData> made;
  made->SetDimensions(size_x, size_y, slice_count);
  made->SetSpacing(0.5, 1, 2);
  made->SetOrigin(1, -2, 3);
  vtkNew<Samples> texels;
  texels->SetName("photo");
  texels->SetNumberOfComponents(components);
  for (int k = 0; k < slice_count; ++k)
    for (int j = 0; j < size_y; ++j)
      for (int i = 0; i < size_x; ++i)
        for (std::size_t c = 0; c < static_cast<std::size_t>(components); ++c)
          texels->InsertNextValue(telling_texel(Index3(i, j, first_slice + k))[c]);
  made->GetPointData()->SetScalars(texels);
  return made;
}

template <class Writer>
void write(vtkImageData* made, const std::filesystem::path& path, const std::function<void(Writer&)>& set = {}) {
  vtkNew<Writer> writer;
  writer->SetInputData(made);
  writer->SetFileName(path.c_str());
  if (set) set(*writer);
  writer->Write();
  ASSERT_TRUE(std::filesystem::exists(path));
}

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.raw = {}, .field = field, .colors = true});
}

/// Read by a worker, as tools do.
NeutralVolume imported(const std::filesystem::path& path) {
  ImportVolumeOptions options;
  options.colors = true;
  return import_volume(path, options);
}

/// @param is_flipped  rows lie from the top of the picture
void expect_texels(const NeutralVolume& colors, int components, bool is_flipped = false) {
  EXPECT_EQ(colors.sample_count, Index3(size_x, size_y, size_z));
  ASSERT_EQ(colors.component_count, components);
  EXPECT_EQ(formats::element_name(colors.type), formats::element_name(ElementType::U8));
  const auto expected = colors_of({size_x, size_y, size_z}, components, [&](Index3 at) {
    if (is_flipped) at.y = size_y - 1 - at.y;
    return telling_texel(at);
  });
  ASSERT_EQ(colors.samples.size(), expected.samples.size());
  EXPECT_TRUE(std::equal(colors.samples.begin(), colors.samples.end(), expected.samples.begin()));
}

TEST_F(Colors, of_a_folder_of_pictures_are_slices) {
  for (const int components : {3, 4}) {
    TemporaryFolder folder;
    for (int k = 0; k < size_z; ++k)
      write<vtkPNGWriter>(image(components, k, 1), folder / concat("slice", k + 8, ".png"));
    const NeutralVolume colors = imported(folder.path());
    expect_texels(colors, components, true);
    expect_map(colors.world_from_grid, {});
    EXPECT_THAT(colors.notes, testing::ElementsAre(HasSubstr("--spacing")));
  }
}

TEST_F(Colors, of_one_picture_are_one_slice) {
  TemporaryFolder folder;
  write<vtkTIFFWriter>(image(3, 0, 1), folder / "a.tif");
  EXPECT_EQ(imported(folder / "a.tif").sample_count, Index3(size_x, size_y, 1));
}

TEST_F(Colors, of_pictures_that_differ_or_hold_none_are_refused) {
  TemporaryFolder folder;
  write<vtkPNGWriter>(image(3, 0, 1), folder / "a1.png");
  write<vtkPNGWriter>(image(4, 1, 1), folder / "a2.png");
  expect_refusal([&] { imported(folder.path()); }, ErrorCode::invalid, {"a2.png", "4 channels", "as the first slice"});
  write<vtkPNGWriter>(image<vtkUnsignedShortArray>(3, 0, 1), folder / "a1.png");
  expect_refusal([&] { imported(folder.path()); }, ErrorCode::unsupported, {"a1.png", "uint16", "of 8 bits"});
  for (const int components : {1, 2}) {
    write<vtkPNGWriter>(image(components, 0, 1), folder / "a1.png");
    expect_refusal([&] { imported(folder.path()); }, ErrorCode::unsupported,
                   {"a1.png", concat(components, " channels")});
  }
}

TEST_F(Colors, of_image_data_are_read_by_name_or_the_first) {
  for (const int components : {3, 4}) {
    TemporaryFolder folder;
    const auto made = image(components, 0, size_z);
    vtkNew<vtkUnsignedCharArray> other;
    other->SetName("other");
    other->SetNumberOfTuples(made->GetNumberOfPoints());
    other->Fill(7);
    made->GetPointData()->AddArray(other);
    write<vtkXMLImageDataWriter>(made, folder / "a.vti");
    for (const char* field : {"", "photo"}) {
      const NeutralVolume colors = read(folder / "a.vti", field);
      expect_texels(colors, components);
      expect_map(colors.world_from_grid, axis_parallel_map({0.5, 1, 2}, {1, -2, 3}));
    }
    expect_refusal([&] { read(folder / "a.vti", "other"); }, ErrorCode::unsupported, {"'other'", "1 components of U8"});
    expect_refusal([&] { read(folder / "a.vti", "fotos"); }, ErrorCode::usage, {"no field 'fotos'", "photo"});
  }
}

TEST_F(Colors, of_image_data_that_holds_none_are_refused) {
  TemporaryFolder folder;
  write<vtkXMLImageDataWriter>(image(2, 0, size_z), folder / "a.vti");
  expect_refusal([&] { read(folder / "a.vti"); }, ErrorCode::unsupported,
                 {"a.vti", "no colours", "photo (2 components)"});
  write<vtkXMLImageDataWriter>(image<vtkUnsignedShortArray>(3, 0, size_z), folder / "a.vti");
  expect_refusal([&] { read(folder / "a.vti"); }, ErrorCode::unsupported, {"a.vti", "no colours"});
}

TEST_F(Colors, of_a_metaimage_are_read_plain_and_packed) {
  for (const int components : {3, 4})
    for (const bool packed : {false, true}) {
      TemporaryFolder folder;
      write<vtkMetaImageWriter>(image(components, 0, size_z), folder / "a.mha",
                                [&](vtkMetaImageWriter& writer) { writer.SetCompression(packed); });
      const NeutralVolume colors = read(folder / "a.mha");
      expect_texels(colors, components);
      expect_map(colors.world_from_grid, axis_parallel_map({0.5, 1, 2}, {1, -2, 3}));
    }
  TemporaryFolder folder;
  write<vtkMetaImageWriter>(image(2, 0, size_z), folder / "a.mha");
  expect_refusal([&] { read(folder / "a.mha"); }, ErrorCode::unsupported, {"ElementNumberOfChannels", "found 2"});
  write<vtkMetaImageWriter>(image<vtkUnsignedShortArray>(3, 0, size_z), folder / "b.mha");
  expect_refusal([&] { read(folder / "b.mha"); }, ErrorCode::unsupported, {"ElementType", "MET_USHORT", "8 bits"});
}

std::string nrrd_text(const std::string& type, int components, const std::string& kind) {
  std::string text = concat("NRRD0004\ntype: ", type, "\ndimension: 4\nspace dimension: 3\nsizes: ", components, " ",
                            size_x, " ", size_y, " ", size_z, "\nspace directions: none (0.5,0,0) (0,1,0) (0,0,2)\n",
                            "space origin: (1,-2,3)\nencoding: raw\nendian: little\n");
  if (!kind.empty()) text += concat("kinds: ", kind, " space space space\n");
  text += '\n';
  for (std::int64_t k = 0; k < size_z; ++k)
    for (std::int64_t j = 0; j < size_y; ++j)
      for (std::int64_t i = 0; i < size_x; ++i)
        for (std::size_t c = 0; c < static_cast<std::size_t>(components); ++c) {
          text += static_cast<char>(telling_texel({i, j, k})[c % 4]);
          if (type == "ushort") text += '\0';
        }
  return text;
}

TEST_F(Colors, of_a_nrrd_stand_along_its_first_axis) {
  TemporaryFolder folder;
  for (const auto& [components, kind] :
       {std::pair{3, "RGB-color"}, {3, "vector"}, {3, "3-color"}, {3, ""}, {4, "RGBA-color"}, {4, "4-color"}}) {
    write_file(folder / "a.nrrd", nrrd_text("uchar", components, kind));
    expect_texels(read(folder / "a.nrrd"), components);
    const NeutralVolume colors = imported(folder / "a.nrrd");
    expect_texels(colors, components);
    expect_map(colors.world_from_grid, axis_parallel_map({0.5, 1, 2}, {1, -2, 3}));
  }
}

TEST_F(Colors, of_a_nrrd_that_holds_none_are_refused) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& text, const std::vector<std::string>& words) {
    write_file(folder / "a.nrrd", text);
    expect_refusal([&] { read(folder / "a.nrrd"); }, ErrorCode::unsupported, words);
  };
  refuses(nrrd_text("ushort", 3, "RGB-color"), {"key type", "unsigned short", "8 bits"});
  refuses(nrrd_text("uchar", 2, "vector"), {"axis 0", "2 samples of kind vector"});
  refuses(nrrd_text("uchar", 5, "vector"), {"axis 0", "5 samples"});
  refuses(nrrd_text("uchar", 3, "HSV-color"), {"axis 0", "HSV-color"});
}

TEST_F(Colors, of_files_that_end_too_soon_are_refused) {
  TemporaryFolder folder;
  check_every_beginning(folder / "a.nrrd", nrrd_text("uchar", 3, "RGB-color"), [&] {
    read(folder / "a.nrrd");
    return false;
  });
}

TEST_F(Colors, of_other_formats_are_refused_with_those_that_are_read) {
  TemporaryFolder folder;
  write_file(folder / "a.slc", "");
  expect_refusal([&] { read(folder / "a.slc"); }, ErrorCode::unsupported, {".nii", ".nrrd", ".mha", ".vti"});
}

}  // namespace
}  // namespace rhoray::preprocess
