#include <vtkNew.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

class Pvtu : public testing::Test {
 protected:
  /// Two tetrahedra and a polyhedron on 14 points; the first ones are at first_place, first_place +
  /// 1/4, ...
  static vtkSmartPointer<vtkUnstructuredGrid> piece(double first_place, double first_value) {
    const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (int i = 0; i < 14; ++i) points->InsertNextPoint(first_place + i, 0, 0);
    grid->SetPoints(points);
    insert(*grid, CellKind::tetrahedron, {0, 1, 2, 3});
    insert(*grid, CellKind::polyhedron, cube_stream(4));
    insert(*grid, CellKind::tetrahedron, {10, 11, 12, 13});
    add_fields(*grid, first_value);
    return grid;
  }

  void write_piece(vtkUnstructuredGrid* grid, const std::string& name) {
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetInputData(grid);
    writer->SetFileName((folder_ / name).c_str());
    ASSERT_EQ(writer->Write(), 1);
  }

  void write_whole(const std::vector<std::string>& sources) {
    std::string pieces;
    for (const std::string& source : sources) pieces += "<Piece Source=\"" + source + "\"/>\n";
    write_file(folder_ / "a.pvtu",
               "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\">\n<PUnstructuredGrid "
               "GhostLevel=\"0\">\n<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>\n" +
                   pieces + "</PUnstructuredGrid>\n</VTKFile>\n");
  }

  CellMesh read() { return read_cells(folder_ / "a.pvtu", {}); }

  TemporaryFolder folder_;
};

TEST_F(Pvtu, puts_its_pieces_together_at_their_common_points) {
  std::filesystem::create_directory(folder_ / "parts");
  write_piece(piece(0, 0), "parts/0.vtu");
  write_piece(piece(12, 1200), "parts/1.vtu");  // two points in common, 100 i both times
  write_piece(vtkSmartPointer<vtkUnstructuredGrid>::New(), "parts/empty.vtu");
  write_whole({"parts/0.vtu", "parts/empty.vtu", "parts/1.vtu"});
  const CellMesh mesh = read();
  ASSERT_EQ(mesh.points.size(), 26U);
  for (std::size_t i = 0; i < 26; ++i) {
    EXPECT_EQ(mesh.points[i][0], static_cast<double>(i));
    EXPECT_EQ(mesh.point_fields[0].values[i], 100.0 * static_cast<double>(i));
  }
  EXPECT_EQ(mesh.kinds.size(), 6U);
  EXPECT_EQ(nodes_of(mesh, 3), (std::vector<std::uint64_t>{12, 13, 14, 15}));
  EXPECT_EQ(nodes_of(mesh, 4), cube_stream(16));
  EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(1, 8, 15, 1201, 1208, 1215));
  EXPECT_EQ(mesh.point_fields[0].unit, "mV");
  EXPECT_TRUE(mesh.cell_ids.empty());
  EXPECT_THAT(mesh.notes, ElementsAre(HasSubstr("2 points merged")));
}

TEST_F(Pvtu, leaves_ghost_cells_and_fields_of_single_pieces_out) {
  const auto first = piece(0, 0), second = piece(12, 1200);
  first->GetCellData()->AddArray(ghosts({0, 0, 1}));
  vtkNew<vtkFloatArray> extra;
  extra->SetName("rank");
  extra->SetNumberOfTuples(14);
  extra->FillComponent(0, 3);
  second->GetPointData()->AddArray(extra);
  write_piece(first, "0.vtu");
  write_piece(second, "1.vtu");
  write_whole({"0.vtu", "1.vtu"});
  const CellMesh mesh = read();
  EXPECT_THAT(mesh.cell_ids, ElementsAre(0, 1, 3, 4, 5));
  EXPECT_THAT(mesh.cell_fields[0].values, ElementsAre(1, 8, 1201, 1208, 1215));
  EXPECT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_THAT(mesh.notes,
              ElementsAre(HasSubstr("1 ghost cell"), HasSubstr("'rank' at points left out: not every piece"),
                          HasSubstr("2 points merged")));
}

TEST_F(Pvtu, tells_which_merged_values_differ) {
  write_piece(piece(0, 0), "0.vtu");
  write_piece(piece(12, 1200.5), "1.vtu");
  write_whole({"0.vtu", "1.vtu"});
  EXPECT_THAT(read().notes, ElementsAre(HasSubstr("2 points merged"),
                                        HasSubstr("'v' differs at 2 of the merged points, by up to 0.5")));
}

TEST_F(Pvtu, refuses_pieces_that_are_missing_twice_there_or_of_another_kind) {
  write_piece(piece(0, 0), "0.vtu");
  const auto refuses = [&](const std::vector<std::string>& sources, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    write_whole(sources);
    expect_refusal([&] { read(); }, error_code, words);
  };
  refuses({"0.vtu", "1.vtu"}, ErrorCode::unreadable, {"a.pvtu, element Piece 1", "1.vtu"});
  refuses({"0.vtu", "0.vtu"}, ErrorCode::invalid, {"element Piece 1", "'0.vtu' once more"});
  refuses({}, ErrorCode::invalid, {"no pieces"});
  refuses({""}, ErrorCode::invalid, {"no attribute Source"});
  refuses({"a.pvtu"}, ErrorCode::unsupported, {"a.pvtu", "'PUnstructuredGrid'"});
  write_file(folder_ / "1.vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\"");
  refuses({"0.vtu", "1.vtu"}, ErrorCode::invalid, {"1.vtu"});
  write_piece(vtkSmartPointer<vtkUnstructuredGrid>::New(), "empty.vtu");
  refuses({"empty.vtu"}, ErrorCode::invalid, {"a.pvtu", "at least one that fills space"});
}

TEST_F(Pvtu, refuses_every_beginning_of_its_file) {
  write_piece(piece(0, 0), "0.vtu");
  write_piece(piece(12, 1200), "1.vtu");
  write_whole({"0.vtu", "1.vtu"});
  const std::string content = read_file(folder_ / "a.pvtu");
  const int passed =
      check_every_beginning(folder_ / "a.pvtu", content, [&] { return read().kinds.size() == 6; }, {.stride = 3});
  EXPECT_LE(passed, static_cast<int>(std::string_view("</VTKFile>\n").size()) + 1);
}

}  // namespace
}  // namespace rhoray::preprocess
