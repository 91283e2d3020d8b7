#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkRectilinearGridWriter.h>
#include <vtkSLCReader.h>
#include <vtkXMLRectilinearGridWriter.h>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/families.h"
#include "tests/preprocess/import/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::ElementsAre;
using testing::HasSubstr;

NeutralVolume read(const std::filesystem::path& path, const std::string& field = {}) {
  return read_volume(path, {.raw = {}, .field = field});
}

const std::vector<double> uneven_x{0, 1, 4}, even_y{10, 10.5, 11, 11.5}, falling_z{5, 4, 2, 1, -1};

template <class Coordinates>
vtkNew<vtkRectilinearGrid> rectilinear() {
  vtkNew<vtkRectilinearGrid> grid;
  grid->SetDimensions(size_x, size_y, size_z);
  const auto array_of = [](const std::vector<double>& positions) {
    vtkNew<Coordinates> array;
    for (const double position : positions) array->InsertNextTuple1(position);
    return array;
  };
  grid->SetXCoordinates(array_of(uneven_x));
  grid->SetYCoordinates(array_of(even_y));
  grid->SetZCoordinates(array_of(falling_z));
  vtkNew<vtkFloatArray> points, cells;
  points->SetName("points");
  for (const int value : known_values<int>()) points->InsertNextValue(static_cast<float>(value));
  grid->GetPointData()->AddArray(points);
  cells->SetName("cells");
  for (int i = 0; i < 2 * 3 * 4; ++i) cells->InsertNextValue(static_cast<float>(i));
  grid->GetCellData()->AddArray(cells);
  return grid;
}

void expect_rectilinear(const std::filesystem::path& path) {
  const NeutralVolume volume = read(path, "points");
  expect_known_values(volume, ElementType::F32);
  EXPECT_EQ(volume.axes[0], uneven_x);
  EXPECT_TRUE(volume.axes[1].empty());
  EXPECT_THAT(volume.axes[2], ElementsAre(-5, -4, -2, -1, 1));
  expect_map(volume.world_from_grid, {{1, 0, 0}, {0, 0.5, 0}, {0, 0, -1}, {0, 10, 0}});
  EXPECT_THAT(volume.other_fields, ElementsAre("cells"));
  const NeutralVolume cells = read(path, "cells");
  EXPECT_EQ(cells.sample_count, Index3(2, 3, 4));
  EXPECT_THAT(cells.axes[0], ElementsAre(0.5, 2.5));
  EXPECT_THAT(cells.axes[2], ElementsAre(-4.5, -3, -1.5, 0));
  expect_near(cells.world_from_grid.origin, {0, 10.25, 0});
  EXPECT_THAT(cells.notes, ElementsAre(HasSubstr("at its cell's centre")));
}

TEST(Rectilinear, axes_with_uneven_steps_keep_a_table) {
  TemporaryFolder folder;
  vtkNew<vtkXMLRectilinearGridWriter> xml;
  xml->SetInputData(rectilinear<vtkFloatArray>());
  xml->SetFileName((folder / "a.vtr").c_str());
  ASSERT_EQ(xml->Write(), 1);
  expect_rectilinear(folder / "a.vtr");
  for (const bool binary : {false, true}) {
    vtkNew<vtkRectilinearGridWriter> legacy;
    legacy->SetInputData(rectilinear<vtkDoubleArray>());
    legacy->SetFileName((folder / "a.vtk").c_str());
    binary ? legacy->SetFileTypeToBinary() : legacy->SetFileTypeToASCII();
    ASSERT_EQ(legacy->Write(), 1);
    expect_rectilinear(folder / "a.vtk");
  }
}

TEST(Rectilinear, steps_that_differ_by_rounding_alone_are_even) {
  TemporaryFolder folder;
  std::string text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 11 1 1\n";
  text += "X_COORDINATES 11 float\n";
  for (int i = 0; i < 11; ++i) text += concat(static_cast<float>(100 + i * 0.1), "\n");
  text += "Y_COORDINATES 1 float\n7\nZ_COORDINATES 1 float\n8\nPOINT_DATA 11\nSCALARS s float\nLOOKUP_TABLE default\n";
  for (int i = 0; i < 11; ++i) text += "1\n";
  write_file(folder / "a.vtk", text);
  const NeutralVolume volume = read(folder / "a.vtk");
  EXPECT_TRUE(volume.axes[0].empty());
  expect_map(volume.world_from_grid, {{0.1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {100, 7, 8}}, 1e-5);  // F32 near 100
}

TEST(Rectilinear, refuses_positions_that_turn_back_and_sizes_that_do_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::string& x, const std::string& sizes, const std::vector<std::string>& words) {
    write_file(folder / "a.vtk", concat("# vtk DataFile Version 3.0\nt\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS ",
                                        sizes, "\nX_COORDINATES 3 double\n", x,
                                        "\nY_COORDINATES 1 double\n0\nZ_COORDINATES 1 double\n0\nPOINT_DATA 3\n"
                                        "SCALARS s double\nLOOKUP_TABLE default\n1 2 3\n"));
    expect_refusal([&] { read(folder / "a.vtk"); }, ErrorCode::invalid, words);
  };
  refuses("0 2 1", "3 1 1", {"x coordinate 2", "1 after 2"});
  refuses("0 0 1", "3 1 1", {"x coordinate 1", "0 after 0"});
  refuses("0 nan 1", "3 1 1", {"x coordinate 1"});
  refuses("0 1 2", "4 1 1", {"DIMENSIONS", "3 x 1 x 1"});
}

std::string cube_text(const std::string& atoms = "1", const std::string& x_count = "3") {
  std::string text =
      "title\nsecond line\n" + atoms + " 1 2 3\n" + x_count + " 0.5 0.1 0\n4 0 0.25 0\n5 0 0 2\n6 6.0 0 0 0\n";
  if (atoms == "-1") text += "1 42\n";
  for (int i = 0; i < size_x; ++i)
    for (int j = 0; j < size_y; ++j)
      for (int k = 0; k < size_z; ++k) text += concat(value_at(i, j, k), k % 6 == 5 ? "\n" : " ");
  return text;
}

TEST(GaussianCube, turns_its_order_and_keeps_slanted_axes) {
  TemporaryFolder folder;
  for (const std::string atoms : {"1", "-1"}) {
    write_file(folder / "a.cube", cube_text(atoms));
    const NeutralVolume volume = read(folder / "a.cube");
    expect_known_values(volume, ElementType::F64);
    expect_map(volume.world_from_grid, {{0.5, 0.1, 0}, {0, 0.25, 0}, {0, 0, 2}, {1, 2, 3}});
    EXPECT_EQ(volume.length_unit, "bohr");
  }
  write_file(folder / "a.cube", cube_text("1", "-3"));
  EXPECT_EQ(read(folder / "a.cube").length_unit, "angstrom");
}

TEST(GaussianCube, refuses_every_beginning_of_itself) {
  TemporaryFolder folder;
  EXPECT_EQ(check_every_beginning(folder / "a.cube", cube_text(),
                                  [&] { return values_of(read(folder / "a.cube")) == known_values<double>(); },
                                  {.is_text = true}),
            1);  // without the last space
  write_file(folder / "a.cube", cube_text("999999999"));
  expect_refusal([&] { read(folder / "a.cube"); }, ErrorCode::invalid, {"999999999 atoms"});
  write_file(folder / "a.cube", cube_text("1", "999999999"));
  expect_refusal([&] { read(folder / "a.cube"); }, ErrorCode::invalid, {"999999999 x 4 x 5"});
}

TEST(GaussianCube, takes_one_value_for_each_sample_where_the_header_counts_them) {
  TemporaryFolder folder;
  std::string text = cube_text();
  const std::size_t end = text.find(" 1 2 3\n") + 6;
  write_file(folder / "a.cube", text.insert(end, "    1"));
  expect_known_values(read(folder / "a.cube"), ElementType::F64);
  const auto refuses = [&](const std::string& count, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(folder / "a.cube", std::string(text).replace(end + 4, 1, count));
    expect_refusal([&] { read(folder / "a.cube"); }, error_code, words);
  };
  refuses("2", ErrorCode::unsupported, {"line 3", "2 values for each sample", "1"});
  refuses("many", ErrorCode::invalid, {"line 3"});
  refuses("1 1", ErrorCode::invalid, {"line 3"});
}

std::string bov_text(const std::string& more = {}) {
  return "# a comment\nTIME: 1.5\nDATA_FILE: values.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: FLOAT\nVARIABLE: density\n"
         "BRICK_ORIGIN: 10 20 30\nBRICK_SIZE: 6 8 10\n" +
         more;
}

TEST(Bov, reads_the_file_that_its_header_names) {
  TemporaryFolder folder;
  write_file(folder / "values.bin", "skip" + bytes_of_values(known_values<float>(), true));
  write_file(folder / "a.bov", bov_text("DATA_ENDIAN: BIG\nBYTE_OFFSET: 4\nCENTERING: nodal\n"));
  const NeutralVolume volume = read(folder / "a.bov");
  expect_known_values(volume, ElementType::F32);
  EXPECT_EQ(volume.field_name, "density");
  expect_map(volume.world_from_grid, axis_parallel_map({3, 8.0 / 3, 2.5}, {10, 20, 30}));
  const auto map_with = [&](const std::string& lines) {
    write_file(folder / "a.bov", bov_text("DATA_ENDIAN: BIG\nBYTE_OFFSET: 4\n" + lines));
    return read(folder / "a.bov").world_from_grid;
  };
  for (const char* centering : {"zonal", "ZONAL", "Zonal"})
    expect_map(map_with(concat("CENTERING: ", centering, "\n")), axis_parallel_map({2, 2, 2}, {11, 21, 31}));
  // As VisIt, samples are at points unless the header says otherwise.
  for (const char* line : {"", "CENTERING: NODAL\n", "CENTERING: Nodal\n"})
    expect_map(map_with(line), axis_parallel_map({3, 8.0 / 3, 2.5}, {10, 20, 30}));
  expect_refusal([&] { map_with("CENTERING: facial\n"); }, ErrorCode::invalid, {"CENTERING", "'facial'"});
}

TEST(Bov, has_a_box_of_size_1_and_plural_types_as_in_visit) {
  TemporaryFolder folder;
  write_file(folder / "b.bin", bytes_of_values(known_values<std::uint8_t>()));
  for (const char* type : {"BYTE", "BYTES", "CHAR", "CHARS"}) {
    write_file(folder / "a.bov", concat("DATA_FILE: b.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: ", type, "\n"));
    const NeutralVolume volume = read(folder / "a.bov");
    expect_known_values(volume, ElementType::U8);
    expect_map(volume.world_from_grid, axis_parallel_map({0.5, 1.0 / 3, 0.25}, {0, 0, 0}));
  }
  write_file(folder / "b.bin", bytes_of_values(known_values<float>()));
  write_file(folder / "a.bov", "DATA_FILE: b.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: FLOATS\n");
  expect_known_values(read(folder / "a.bov"), ElementType::F32);
  write_file(folder / "a.bov", "DATA_FILE: b.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: FLOATING\n");
  expect_refusal([&] { read(folder / "a.bov"); }, ErrorCode::unsupported, {"FLOATING"});
}

TEST(Bov, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  write_file(folder / "values.bin", std::string(value_count * 4 - 1, 'x'));
  const auto refuses = [&](const std::string& text, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(folder / "a.bov", text);
    expect_refusal([&] { read(folder / "a.bov"); }, error_code, words);
  };
  refuses(bov_text(), ErrorCode::invalid, {"values.bin", "byte 239"});
  refuses(bov_text("DATA_COMPONENTS: 0\n"), ErrorCode::invalid, {"DATA_COMPONENTS"});
  refuses("DATA_FILE: none.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: FLOAT\n", ErrorCode::unreadable, {"none.bin"});
  refuses("DATA_FILE: b%04d.bin\nDATA_SIZE: 3 4 5\nDATA_FORMAT: FLOAT\n", ErrorCode::unsupported, {"several files"});
  refuses("DATA_SIZE: 3 4 5\n", ErrorCode::invalid, {"DATA_FILE"});
  refuses(bytes_of_values(known_values<float>()), ErrorCode::invalid, {"no text"});
  write_file(folder / "values.bin", std::string(value_count * 4, 'x'));
  refuses(bov_text("DATA_ENDIAN: MIDDLE\n"), ErrorCode::invalid, {"MIDDLE"});
}

std::string slc_text(bool packed, const std::string& slice) {
  std::string text = concat("11111\n3 4 5 8\n0.5 1 2\n1 0 0 ", packed ? 1 : 0, "\n2 1 X") + "iconXY";
  for (int k = 0; k < size_z; ++k) text += packed ? concat(slice.size(), " X", slice) : slice;
  return text;
}

TEST(Slc, reads_plain_and_packed_slices_as_vtk_does) {
  TemporaryFolder folder;
  std::string plain;
  for (int i = 0; i < 12; ++i) plain += static_cast<char>(i < 5 ? 7 : i);
  const std::string runs = std::string("\x05\x07\x87\x05\x06\x07\x08\x09\x0a\x0b", 10) + '\0';
  for (const bool packed : {false, true}) {
    write_file(folder / "a.slc", slc_text(packed, packed ? runs : plain));
    const NeutralVolume volume = read(folder / "a.slc");
    EXPECT_EQ(volume.sample_count, Index3(3, 4, 5));
    EXPECT_EQ(volume.length_unit, "mm");
    EXPECT_TRUE(volume.notes.empty());
    write_file(folder / "b.slc", slc_text(packed, packed ? runs : plain) + "more");
    EXPECT_THAT(read(folder / "b.slc").notes, ElementsAre(HasSubstr("4 bytes after the samples were left out")));
    expect_map(volume.world_from_grid, axis_parallel_map({0.5, 1, 2}, {0, 0, 0}));
    const std::vector<double> values = values_of(volume);
    vtkNew<vtkSLCReader> reader;
    reader->SetFileName((folder / "a.slc").c_str());
    reader->Update();
    ASSERT_EQ(reader->GetOutput()->GetNumberOfPoints(), 60);
    for (int i = 0; i < 60; ++i) {
      EXPECT_EQ(values[static_cast<std::size_t>(i)], reader->GetOutput()->GetPointData()->GetScalars()->GetTuple1(i));
      EXPECT_EQ(values[static_cast<std::size_t>(i)], plain[static_cast<std::size_t>(i) % 12]);
    }
  }
}

TEST(Slc, repeats_the_last_sample_that_volvis_leaves_out) {
  TemporaryFolder folder;
  write_file(folder / "a.slc", slc_text(true, std::string("\x0b\x09\x00", 3)));
  const NeutralVolume volume = read(folder / "a.slc");
  EXPECT_EQ(values_of(volume), std::vector<double>(60, 9));
  EXPECT_THAT(volume.notes, ElementsAre(HasSubstr("5 slices lack their last sample")));
}

TEST(Slc, refuses_every_beginning_of_itself) {
  TemporaryFolder folder;
  const std::string content = slc_text(true, std::string("\x0c\x09", 2));
  EXPECT_EQ(check_every_beginning(folder / "a.slc", content,
                                  [&] { return values_of(read(folder / "a.slc")) == std::vector<double>(60, 9); }),
            0);
  const auto refuses = [&](const std::string& text, ErrorCode error_code, const std::string& word) {
    write_file(folder / "a.slc", text);
    expect_refusal([&] { read(folder / "a.slc"); }, error_code, {word});
  };
  refuses(slc_text(true, std::string("\x0d\x09", 2)), ErrorCode::invalid, "slice 0");
  refuses(slc_text(true, std::string("\x03\x09\x00", 3)), ErrorCode::invalid, "slice 0");
  // twelve different bytes are announced, and one is there
  refuses(slc_text(true, std::string("\x8c\x09", 2)), ErrorCode::invalid, "slice 0");
  refuses("11111\n3 4 5 16\n1 1 1\n0 0 0 0\n0 0 X", ErrorCode::unsupported, "16 bits");
  refuses("11111\n30000 40000 50000 8\n1 1 1\n0 0 0 1\n0 0 X", ErrorCode::invalid, "sizes");
}

}  // namespace
}  // namespace rhoray::preprocess
