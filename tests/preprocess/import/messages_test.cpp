#include "preprocess/process/messages.h"

#include <sys/mman.h>
#include <unistd.h>

#include <limits>

#include "tests/preprocess/import/support.h"
#include "tests/support/memory_file.h"
#include "tests/support/resealed.h"

namespace rhoray::preprocess {
namespace {

using tests::expect_refusal;

/// Through an anonymous file, as between two processes.
template <class Thing>
formats::PackedFile sent(const Thing& thing) {
  const int descriptor = ::memfd_create("handover", MFD_CLOEXEC);
  send(thing, descriptor);
  formats::PackedFile file = formats::PackedFile::from_descriptor(descriptor, "parcel");
  ::close(descriptor);
  return file;
}

TEST(Handover, carries_a_volume_unchanged) {
  const std::vector<std::int16_t> values = tests::known_values<std::int16_t>();
  NeutralVolume volume;
  volume.sample_count = {tests::size_x, tests::size_y, tests::size_z};
  volume.type = formats::ElementType::I16;
  volume.samples = std::as_bytes(std::span(values));
  volume.world_from_grid = {{0, 2, 0}, {-1, 0, 0}, {0, 0.1, 3}, {1e9, -7, 1.0 / 3}};
  volume.length_unit = "mm";
  volume.space = formats::Space::lps;
  volume.sources = {{"/a b/c.raw", true, 1, 2, 3, -4}, {"/gone", false, 0, 0, 0, 0}};
  volume.field_name = "density";
  volume.field_unit = "";
  volume.label_names = {{-3, "left lung"}, {7, "17 b\u00f6se"}};
  volume.other_fields = {"mass", ""};
  volume.vectors = {{"flow", 3}, {"", 2}};
  volume.notes = {"first note", "", "third \xff note"};
  const NeutralVolume taken = receive_volume(sent(volume));
  tests::expect_known_values(taken, formats::ElementType::I16);
  EXPECT_EQ(taken.world_from_grid, volume.world_from_grid);
  EXPECT_EQ(taken.length_unit, "mm");
  EXPECT_EQ(taken.space, formats::Space::lps);
  EXPECT_EQ(taken.sources, volume.sources);
  EXPECT_EQ(taken.field_name, "density");
  EXPECT_EQ(taken.field_unit, "");
  EXPECT_EQ(taken.label_names, volume.label_names);
  EXPECT_EQ(taken.other_fields, volume.other_fields);
  ASSERT_EQ(taken.vectors.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(taken.vectors[i].name, volume.vectors[i].name);
    EXPECT_EQ(taken.vectors[i].component_count, volume.vectors[i].component_count);
  }
  EXPECT_EQ(taken.notes, volume.notes);
}

TEST(Handover, leaves_samples_in_their_file_where_they_are_mapped_again) {
  tests::TemporaryFolder folder;
  const std::string bytes = tests::bytes_of_values(tests::known_values<std::int16_t>());
  tests::write_file(folder / "samples", "seven!!" + bytes + "more");
  NeutralVolume volume;
  volume.sample_count = {tests::size_x, tests::size_y, tests::size_z};
  volume.type = formats::ElementType::I16;
  volume.samples_file = folder / "samples";
  volume.samples_first_byte = 7;
  const NeutralVolume taken = receive_volume(sent(volume));
  tests::expect_known_values(taken, formats::ElementType::I16);
  EXPECT_TRUE(taken.owned_samples.empty());

  volume.samples_first_byte = 12;  // beyond the end
  expect_refusal([&] { receive_volume(sent(volume)); }, ErrorCode::invalid, {"beyond the end of their file"});
  volume.samples_file = folder / "none";
  expect_refusal([&] { receive_volume(sent(volume)); }, ErrorCode::unreadable, {"none"});
}

/// A reader that a hostile file has taken over could name a file that it may not show.
TEST(Handover, takes_samples_only_from_the_file_asked_about_or_one_that_it_names) {
  tests::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "data");
  const std::string bytes = tests::bytes_of_values(tests::known_values<std::int16_t>());
  for (const char* name : {"asked.nrrd", "data/samples one.raw", "secret", "key", "samples"})
    tests::write_file(folder / name, bytes);
  const std::string whole = (folder / "samples").string();
  tests::write_file(folder / "header.mhd", "ElementDataFile = data/samples one.raw\r\nNote = no-key keys secret.txt\n");
  tests::write_file(folder / "whole.nhdr", "data file:" + whole);
  NeutralVolume volume;
  volume.sample_count = {tests::size_x, tests::size_y, tests::size_z};
  volume.type = formats::ElementType::I16;
  const auto taken = [&](const char* named, const char* asked) {
    volume.samples_file = folder / named;
    tests::expect_known_values(receive_volume(sent(volume), folder / asked), formats::ElementType::I16);
  };
  taken("asked.nrrd", "asked.nrrd");
  taken("data/samples one.raw", "header.mhd");
  taken("samples", "whole.nhdr");
  for (const char* named : {"secret", "key", "samples", "../key"})
    expect_refusal([&] { taken(named, "header.mhd"); }, ErrorCode::internal,
                   {"parcel", named, "header.mhd, which was asked about"});
  expect_refusal([&] { taken("samples", "asked.nrrd"); }, ErrorCode::internal, {"asked.nrrd"});
}

NeutralMesh small_mesh() {
  NeutralMesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {std::numeric_limits<double>::infinity(), 1, 1}};
  mesh.cells = {{0, 1, 2, 3}, {1, 2, 3, 4}};
  mesh.cell_ids = {0, 7};
  mesh.point_fields = {{"voltage", "mV", 1, false, {1, 2, 3, 4, 5}}, {"flow", "", 3, true, Array<double>(15, 0.5)}};
  mesh.cell_fields = {{"tissue", "", 1, true, {4, 9}, {{4, "bone"}, {9, "skin"}}}};
  mesh.length_unit = "cm";
  mesh.notes = {"6 lines left out"};
  return mesh;
}

TEST(Handover, carries_a_mesh_unchanged) {
  const NeutralMesh mesh = small_mesh();
  const NeutralMesh taken = receive_mesh(sent(mesh));
  EXPECT_EQ(taken.points, mesh.points);
  EXPECT_EQ(taken.cells, mesh.cells);
  EXPECT_EQ(taken.cell_ids, mesh.cell_ids);
  ASSERT_EQ(taken.point_fields.size(), 2U);
  EXPECT_EQ(taken.point_fields[0].name, "voltage");
  EXPECT_EQ(taken.point_fields[0].unit, "mV");
  EXPECT_FALSE(taken.point_fields[0].was_single_precision);
  EXPECT_EQ(taken.point_fields[0].values, mesh.point_fields[0].values);
  EXPECT_EQ(taken.point_fields[1].component_count, 3);
  EXPECT_TRUE(taken.point_fields[1].was_single_precision);
  EXPECT_EQ(taken.point_fields[1].values.size(), 15U);
  ASSERT_EQ(taken.cell_fields.size(), 1U);
  EXPECT_EQ(taken.cell_fields[0].values, mesh.cell_fields[0].values);
  EXPECT_EQ(taken.cell_fields[0].label_names, mesh.cell_fields[0].label_names);
  EXPECT_TRUE(taken.point_fields[0].label_names.empty());
  EXPECT_EQ(taken.length_unit, "cm");
  EXPECT_EQ(taken.notes, mesh.notes);
}

TEST(Handover, refuses_names_of_labels_that_no_importer_sends) {
  NeutralMesh mesh = small_mesh();
  for (const std::string& name :
       {std::string(), std::string("a\x1b[31m"), std::string(129, 'a'), std::string("\xff")}) {
    mesh.cell_fields[0].label_names = {{4, name}};
    expect_refusal([&] { receive_mesh(sent(mesh)); }, ErrorCode::invalid, {"no label with a name"});
  }
  formats::LabelNames& names = mesh.cell_fields[0].label_names;
  names.clear();
  for (int label = 0; label <= 1024; ++label) names[label] = "a";
  expect_refusal([&] { receive_mesh(sent(mesh)); }, ErrorCode::invalid, {"1025 names of labels"});
}

TEST(Handover, carries_a_surface_unchanged) {
  NeutralSurface surface;
  surface.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  surface.point_sizes = {1, 2, 3, 4, 5};
  surface.facet_offsets = {0, 3, 7};
  surface.facet_corners = {0, 1, 2, 1, 2, 3, 4};
  surface.facet_faces = {0, 1};
  surface.openings = {{1, {0.5, 0.25, 0}}};
  surface.holes = {{9, 8, 7}};
  surface.regions = {{{1, 2, 3}, 4, 5}};
  surface.notes = {"a note"};
  const NeutralSurface taken = receive_surface(sent(surface));
  EXPECT_EQ(taken.points, surface.points);
  EXPECT_EQ(taken.point_sizes, surface.point_sizes);
  EXPECT_EQ(taken.facet_offsets, surface.facet_offsets);
  EXPECT_EQ(taken.facet_corners, surface.facet_corners);
  EXPECT_EQ(taken.facet_faces, surface.facet_faces);
  ASSERT_EQ(taken.openings.size(), 1U);
  EXPECT_EQ(taken.openings[0].face, 1U);
  EXPECT_EQ(taken.openings[0].seed, surface.openings[0].seed);
  EXPECT_EQ(taken.holes, surface.holes);
  ASSERT_EQ(taken.regions.size(), 1U);
  EXPECT_EQ(taken.regions[0].seed, surface.regions[0].seed);
  EXPECT_EQ(taken.regions[0].attribute, 4);
  EXPECT_EQ(taken.regions[0].max_volume, 5);
  EXPECT_EQ(taken.notes, surface.notes);
}

TEST(Handover, carries_empty_things) {
  EXPECT_TRUE(receive_surface(sent(NeutralSurface{})).points.empty());
  EXPECT_TRUE(receive_mesh(sent(NeutralMesh{})).cells.empty());
}

TEST(Handover, refuses_another_kind) {
  expect_refusal([] { receive_volume(sent(small_mesh())); }, ErrorCode::invalid,
                 {"parcel", "neutral-mesh", "neutral-volume"});
}

TEST(Handover, does_not_trust_counts_of_the_other_side) {
  NeutralMesh mesh = small_mesh();
  mesh.point_fields[0].values.pop_back();
  expect_refusal([&] { receive_mesh(sent(mesh)); }, ErrorCode::invalid, {"parcel", "point_fields.0"});
  mesh = small_mesh();
  mesh.cell_ids.push_back(8);
  expect_refusal([&] { receive_mesh(sent(mesh)); }, ErrorCode::invalid, {"cell_ids"});
  mesh = small_mesh();
  mesh.cells[1][3] = mesh.points.size();
  expect_refusal([&] { receive_mesh(sent(mesh)); }, ErrorCode::invalid, {"array 'cells'", "found point"});
  NeutralSurface surface;
  surface.points = {{0, 0, 0}};
  surface.facet_corners = {0, 0, 1};
  surface.facet_offsets = {0, 3};
  expect_refusal([&] { receive_surface(sent(surface)); }, ErrorCode::invalid, {"facet_corners"});
  surface.facet_corners = {0, 0, 0};
  surface.facet_offsets = {0, 4};
  expect_refusal([&] { receive_surface(sent(surface)); }, ErrorCode::invalid, {"facet_offsets"});
}

TEST(Handover, does_not_trust_a_shape_of_samples_that_its_facts_deny) {
  const std::vector<std::int16_t> values = tests::known_values<std::int16_t>();
  NeutralVolume volume;
  volume.sample_count = {3, 4, 5};
  volume.type = formats::ElementType::I16;
  volume.samples = std::as_bytes(std::span(values));
  const tests::MemoryFile memory;
  send(volume, memory.descriptor());
  const tests::MemoryFile lying(
      tests::with_header_change(memory.content(), R"("shape":[5,4,3,1])", R"("shape":[5,3,4,1])"));
  expect_refusal([&] { receive_volume(formats::PackedFile::from_descriptor(lying.descriptor(), "parcel")); },
                 ErrorCode::invalid, {"array 'samples'", "another shape or type"});
}

/// What our own side would stop at, as at a bug of ours.
TEST(Handover, does_not_trust_kinds_and_offsets_of_cells_nor_numbers_that_are_not_finite) {
  CellMesh cells;
  cells.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  cells.kinds = {CellKind::tetrahedron};
  cells.cell_offsets = {0, 4};
  cells.cell_nodes = {0, 1, 2, 3};
  EXPECT_EQ(receive_cell_mesh(sent(cells)).kinds.size(), 1U);
  cells.kinds = {static_cast<CellKind>(9)};
  expect_refusal([&] { receive_cell_mesh(sent(cells)); }, ErrorCode::invalid, {"array 'kinds'", "not known"});
  cells.kinds = {CellKind::tetrahedron};
  for (const std::uint64_t end : {3U, 5U}) {
    cells.cell_offsets = {0, end};
    expect_refusal([&] { receive_cell_mesh(sent(cells)); }, ErrorCode::invalid,
                   {"array 'cell_offsets'", "rising from 0 to the number of nodes"});
  }

  const std::vector<std::int16_t> values = tests::known_values<std::int16_t>();
  NeutralVolume volume;
  volume.sample_count = {tests::size_x, tests::size_y, tests::size_z};
  volume.type = formats::ElementType::I16;
  volume.samples = std::as_bytes(std::span(values));
  volume.world_from_grid.origin.y = std::numeric_limits<double>::quiet_NaN();
  expect_refusal([&] { receive_volume(sent(volume)); }, ErrorCode::invalid, {"array 'world_from_grid'", "not finite"});
}

}  // namespace
}  // namespace rhoray::preprocess
