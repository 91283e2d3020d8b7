#include "preprocess/import/reading/label_names.h"

#include <limits>

#include "preprocess/export_grid.h"
#include "preprocess/labels.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "preprocess/unpack_mesh.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

/// Names of labels from foreign files, and their way through packed files.
namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::LabelNames;

TEST(GivenNames, become_names_that_a_packed_file_holds) {
  std::vector<std::string> notes;
  const std::string wide(63, 'w'), two_bytes = "\xc3\xb6";
  std::string letters;
  for (int i = 0; i < 63; ++i) letters += two_bytes;
  const LabelNames names = label_names_from({{1, "liver"},
                                             {2, " \tleft\r\nlung\x7f"},
                                             {-3, "M\xfcller"},
                                             {4, " \n "},
                                             {5, ""},
                                             {6, wide + wide + wide},
                                             {7, "abc" + letters}},
                                            notes);
  EXPECT_EQ(names, (LabelNames{{1, "liver"},
                               {2, "left  lung"},
                               {-3, "M\xef\xbf\xbdller"},
                               {6, std::string(128, 'w')},
                               {7, "abc" + letters.substr(0, 124)}}));
  for (const auto& [label, name] : names) EXPECT_TRUE(formats::is_label_name(name)) << label;
  EXPECT_THAT(notes, testing::IsEmpty());
}

TEST(GivenNames, beyond_their_number_or_of_numbers_that_are_no_labels_are_counted) {
  std::vector<std::string> notes;
  GivenNames given{{std::numeric_limits<std::int64_t>::min(), "a"}, {std::int64_t{1} << 31, "b"}, {9, "first"}};
  for (int label = 0; label < 1100; ++label) given.emplace_back(label, "c");
  const LabelNames names = label_names_from(given, notes);
  EXPECT_EQ(names.size(), formats::most_label_names);
  EXPECT_EQ(names.at(9), "first");
  EXPECT_THAT(notes,
              testing::ElementsAre("79 names of labels left out; 1024 are kept, one for each integer of 32 bits"));
}

TEST(NamesOfLabels, are_kept_in_a_packed_grid_and_in_the_data_of_one_label) {
  const TemporaryFolder folder;
  NeutralVolume volume = volume_of<float>({8, 8, 8}, [](const Index3& p) { return static_cast<float>(p.x / 2); });
  pack_volume(volume, folder / "without.rho");
  volume.label_names = {{1, "liver \"left\" \\"}, {3, "b\u00f6se"}};
  pack_volume(volume, folder / "with.rho");
  const formats::BrickGrid with(formats::PackedFile::open(folder / "with.rho"));
  EXPECT_EQ(with.description().fields[0].label_names, volume.label_names);
  EXPECT_EQ(with.file().version(), "1.8");
  EXPECT_EQ(read_file(folder / "without.rho").find("label_names"), std::string::npos);

  volume = volume_of<std::uint8_t>({20, 8, 8}, [](const Index3& p) { return static_cast<std::uint8_t>(p.x / 5); });
  volume.label_names = {{1, "liver"}};
  pack_volume(volume, folder / "labels.rho");
  const formats::BrickGrid grid(formats::PackedFile::open(folder / "labels.rho"));
  const std::vector<Label> labels = find_labels(grid, 0).value();
  const auto names_in = [&](std::size_t label) {
    return formats::BrickGrid(pack_indicator(grid, 0, labels.at(label))).description().fields[0].label_names;
  };
  EXPECT_EQ(names_in(0), (LabelNames{{1, "liver"}}));
  EXPECT_EQ(names_in(2), LabelNames{}) << "label 3 has no name";
  EXPECT_THAT(export_vti(folder / "labels.rho", folder / "labels.vti").notes,
              testing::Contains(testing::HasSubstr("the names of the labels of field")));
}

TEST(NamesOfLabels, are_kept_in_a_packed_mesh_where_the_field_stays_the_same) {
  const TemporaryFolder folder;
  NeutralMesh mesh = box_mesh({});
  NeutralField part{.name = "part", .unit = {}, .values = {}};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) part.values.push_back(static_cast<double>(c % 2));
  part.label_names = {{0, "air"}, {1, "iron"}};
  mesh.cell_fields.push_back(part);
  const auto packed = [&](const PackMeshOptions& options) {
    pack_mesh(mesh, folder / "m.rho", options);
    return formats::TetMesh(formats::PackedFile::open(folder / "m.rho"));
  };
  const formats::TetMesh both = packed({.cells_to_points = true, .replace_existing = true});
  EXPECT_EQ(both.description().cell_fields.at(0).label_names, part.label_names);
  EXPECT_EQ(both.description().fields.at(0).label_names, LabelNames{}) << "means of labels are no labels";
  EXPECT_EQ(both.file().version(), "1.8");
  EXPECT_EQ(unpack_mesh(both).cell_fields.at(0).label_names, part.label_names);

  add_point_field(mesh, "flow", [](const Vec3& p) { return p.x; });
  mesh.cell_fields[0].label_names.clear();
  EXPECT_EQ(packed({.replace_existing = true}).file().version(), "1.7");
}

}  // namespace
}  // namespace rhoray::preprocess
