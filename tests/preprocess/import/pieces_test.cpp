#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLRectilinearGridWriter.h>
#include <vtkXMLStructuredGridWriter.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

// Structured grids of VTK whose pieces are files of their own.
namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

using Extent = std::array<int, 6>;

/// Cuts the lattice of the known values in two along x and along z.
const std::vector<Extent> quarters{{0, 1, 0, 3, 0, 2}, {1, 2, 0, 3, 0, 2}, {0, 1, 0, 3, 2, 4}, {1, 2, 0, 3, 2, 4}};

std::string text_of(const Extent& extent) {
  std::string text;
  for (const int number : extent) text += concat(text.empty() ? "" : " ", number);
  return text;
}

double place(int axis, int i) {
  return axis == 0 ? i : axis == 1 ? i * i : 0.5 * i;
}

/// Gives a part of the lattice its values at points and in cells.
template <class Grid>
vtkSmartPointer<Grid> part(const Extent& extent) {
  const auto grid = vtkSmartPointer<Grid>::New();
  grid->SetExtent(const_cast<int*>(extent.data()));
  vtkNew<vtkFloatArray> values, in_cells;
  values->SetName("a");
  in_cells->SetName("c");
  for (int k = extent[4]; k <= extent[5]; ++k)
    for (int j = extent[2]; j <= extent[3]; ++j)
      for (int i = extent[0]; i <= extent[1]; ++i) {
        values->InsertNextValue(static_cast<float>(value_at(i, j, k)));
        if (i < extent[1] && j < extent[3] && k < extent[5])
          in_cells->InsertNextValue(static_cast<float>(value_at(i, j, k)));
      }
  grid->GetPointData()->AddArray(values);
  grid->GetCellData()->AddArray(in_cells);
  return grid;
}

template <class Writer, class Grid>
void write(Grid* grid, const std::filesystem::path& path) {
  vtkNew<Writer> writer;
  writer->SetInputData(grid);
  writer->SetFileName(path.c_str());
  ASSERT_EQ(writer->Write(), 1);
}

struct Whole {
  std::string type, extension;
  std::string attributes = "Origin=\"1 2 3\" Spacing=\"2 3 4\"";
  std::string extent = "0 2 0 3 0 4";
};

void write_whole(const TemporaryFolder& folder, const Whole& whole, const std::vector<Extent>& pieces = quarters) {
  std::string text = concat("<VTKFile type=\"P", whole.type, "\" version=\"0.1\"><P", whole.type, " WholeExtent=\"",
                            whole.extent, "\" GhostLevel=\"0\" ", whole.attributes, ">");
  for (std::size_t p = 0; p < pieces.size(); ++p)
    text += concat("<Piece Extent=\"", text_of(pieces[p]), "\" Source=\"", p, ".", whole.extension, "\"/>");
  write_file(folder / concat("a.p", whole.extension), text + concat("</P", whole.type, "></VTKFile>"));
}

class Pieces : public testing::Test {
 protected:
  void write_images(const std::vector<Extent>& pieces = quarters) {
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const auto image = part<vtkImageData>(pieces[p]);
      image->SetOrigin(1, 2, 3);
      image->SetSpacing(2, 3, 4);
      write<vtkXMLImageDataWriter>(image.Get(), folder_ / concat(p, ".vti"));
    }
    write_whole(folder_, images_, pieces);
  }

  TemporaryFolder folder_;
  Whole images_{.type = "ImageData", .extension = "vti"};
};

TEST_F(Pieces, of_an_image_make_one_volume) {
  write_images();
  const NeutralVolume volume = read_volume(folder_ / "a.pvti", {});
  expect_known_values(volume, ElementType::F32);
  expect_map(volume.world_from_grid, axis_parallel_map({2, 3, 4}, {1, 2, 3}));
  const NeutralVolume cells = read_volume(folder_ / "a.pvti", {.field = "c"});
  EXPECT_EQ(cells.sample_count, Index3(2, 3, 4));
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 2; ++i) EXPECT_EQ(values_of(cells)[at++], value_at(i, j, k));
}

TEST_F(Pieces, of_a_rectilinear_grid_keep_its_positions) {
  for (std::size_t p = 0; p < quarters.size(); ++p) {
    const auto grid = part<vtkRectilinearGrid>(quarters[p]);
    vtkNew<vtkFloatArray> positions[3];
    for (int axis = 0; axis < 3; ++axis)
      for (int i = quarters[p][static_cast<std::size_t>(2 * axis)];
           i <= quarters[p][static_cast<std::size_t>(2 * axis + 1)]; ++i)
        positions[axis]->InsertNextValue(static_cast<float>(place(axis, i)));
    grid->SetXCoordinates(positions[0]);
    grid->SetYCoordinates(positions[1]);
    grid->SetZCoordinates(positions[2]);
    write<vtkXMLRectilinearGridWriter>(grid.Get(), folder_ / concat(p, ".vtr"));
  }
  write_whole(folder_, {.type = "RectilinearGrid", .extension = "vtr", .attributes = ""});
  const NeutralVolume volume = read_volume(folder_ / "a.pvtr", {});
  expect_known_values(volume, ElementType::F32);
  EXPECT_THAT(volume.axes[1], testing::ElementsAre(0, 1, 4, 9));
  expect_map(volume.world_from_grid, axis_parallel_map({1, 1, 0.5}, {0, 0, 0}));
}

TEST_F(Pieces, of_a_structured_grid_make_one_mesh) {
  for (std::size_t p = 0; p < quarters.size(); ++p) {
    const Extent& e = quarters[p];
    const auto grid = part<vtkStructuredGrid>(e);
    vtkNew<vtkPoints> points;
    for (int k = e[4]; k <= e[5]; ++k)
      for (int j = e[2]; j <= e[3]; ++j)
        for (int i = e[0]; i <= e[1]; ++i) points->InsertNextPoint(place(0, i), place(1, j), place(2, k));
    grid->SetPoints(points);
    write<vtkXMLStructuredGridWriter>(grid.Get(), folder_ / concat(p, ".vts"));
  }
  write_whole(folder_, {.type = "StructuredGrid", .extension = "vts", .attributes = ""});
  const CellMesh mesh = read_cells(folder_ / "a.pvts", {});
  ASSERT_EQ(mesh.points.size(), value_count);
  EXPECT_EQ(mesh.points[1 + 3 * (2 + 4 * 3)], (std::array{1.0, 4.0, 1.5}));
  EXPECT_EQ(mesh.kinds.size(), 24U);
  ASSERT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(std::vector<double>(mesh.point_fields[0].values.begin(), mesh.point_fields[0].values.end()),
            known_values<double>());
}

TEST_F(Pieces, that_do_not_make_up_the_whole_are_refused) {
  const auto refuses = [&](const Whole& whole, const std::vector<Extent>& pieces, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    write_whole(folder_, whole, pieces);
    expect_refusal([&] { read_volume(folder_ / "a.pvti", {}); }, error_code, words);
  };
  write_images();
  Whole larger = images_, huge = images_;
  larger.extent = "0 2 0 3 0 5";
  huge.extent = "0 2147483646 0 2147483646 0 2147483646";
  refuses(larger, quarters, ErrorCode::invalid, {"a.pvti", "do not make up WholeExtent"});
  refuses(huge, quarters, ErrorCode::invalid, {"a.pvti, attribute WholeExtent", "fits in memory"});
  refuses(images_, {quarters[0], quarters[1], quarters[2]}, ErrorCode::invalid, {"3 pieces that do not make up"});
  refuses(images_, {}, ErrorCode::invalid, {"no pieces"});
  std::filesystem::remove(folder_ / "3.vti");
  refuses(images_, quarters, ErrorCode::unreadable, {"element Piece 3", "no file"});
  write_images({quarters[0], quarters[0], quarters[2], quarters[3]});
  expect_refusal([&] { read_volume(folder_ / "a.pvti", {}); }, ErrorCode::invalid, {"do not make up WholeExtent"});
  write_images();
  std::string text = read_file(folder_ / "a.pvti");
  text.replace(text.find("GhostLevel=\"0\""), 14, "GhostLevel=\"1\"");
  write_file(folder_ / "a.pvti", text);
  expect_refusal([&] { read_volume(folder_ / "a.pvti", {}); }, ErrorCode::unsupported, {"GhostLevel", "'1'"});
  text.replace(text.find("1.vti"), 5, "0.vti");
  text.replace(text.find("GhostLevel=\"1\""), 14, "GhostLevel=\"0\"");
  write_file(folder_ / "a.pvti", text);
  expect_refusal([&] { read_volume(folder_ / "a.pvti", {}); }, ErrorCode::invalid, {"'0.vti' once more"});
}

/// A piece is cut off behind the values that are read, or refused.
TEST_F(Pieces, that_are_cut_off_are_refused) {
  write_images();
  const std::string content = read_file(folder_ / "2.vti");
  std::size_t read = 0;
  for (std::size_t size = 0; size < content.size(); size += 37) {
    write_file(folder_ / "2.vti", content.substr(0, size));
    try {
      expect_known_values(read_volume(folder_ / "a.pvti", {}), ElementType::F32);
      ++read;
    } catch (const Error& error) {
      EXPECT_THAT(std::string(error.what()), testing::HasSubstr("2.vti"));
    }
  }
  EXPECT_LT(read, 4U);
}

}  // namespace
}  // namespace rhoray::preprocess
