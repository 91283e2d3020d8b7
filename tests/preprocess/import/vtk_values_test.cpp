// Values on packed meshes, computed a second time by VTK's filters.

#include <vtkCellDataToPointData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>

#include "preprocess/subdivide.h"
#include "preprocess/unpack_mesh.h"
#include "render/dataset/loaded_dataset.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

vtkSmartPointer<vtkDoubleArray> array_of(const NeutralField& field) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(field.name.c_str());
  for (const double value : field.values) array->InsertNextValue(value);
  return array;
}

/// Warped cubes between 4^3 points: hexahedra, and every second one cut into two wedges.
TEST(VtkValues, means_of_cell_fields_are_those_of_vtk) {
  constexpr int edge = 4;
  CellMesh mesh;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-0.1, 0.1), any(-3, 5);
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int k = 0; k < edge; ++k)
    for (int j = 0; j < edge; ++j)
      for (int i = 0; i < edge; ++i) {
        mesh.points.push_back({i + shift(random), j + shift(random), k + shift(random)});
        points->InsertNextPoint(mesh.points.back().data());
      }
  grid->SetPoints(points);
  NeutralField field{.name = "number", .unit = {}, .values = {}};
  mesh.cell_offsets = {0};
  const auto add = [&](CellKind kind, const std::vector<std::uint64_t>& nodes) {
    insert(*grid, kind, nodes);
    mesh.kinds.push_back(kind);
    mesh.cell_nodes.insert(mesh.cell_nodes.end(), nodes.begin(), nodes.end());
    mesh.cell_offsets.push_back(mesh.cell_nodes.size());
    field.values.push_back(any(random));
  };
  for (std::uint64_t k = 0; k + 1 < edge; ++k)
    for (std::uint64_t j = 0; j + 1 < edge; ++j)
      for (std::uint64_t i = 0; i + 1 < edge; ++i) {
        const std::uint64_t a = i + edge * (j + edge * k), up = edge * edge;
        if ((i + j + k) % 2 == 0) {
          add(CellKind::hexahedron,
              {a, a + 1, a + 1 + edge, a + edge, a + up, a + up + 1, a + up + 1 + edge, a + up + edge});
        } else {
          add(CellKind::wedge, {a, a + edge, a + 1, a + up, a + up + edge, a + up + 1});
          add(CellKind::wedge, {a + 1, a + edge, a + 1 + edge, a + up + 1, a + up + edge, a + up + 1 + edge});
        }
      }
  grid->GetCellData()->AddArray(array_of(field));
  mesh.cell_fields = {field};

  vtkNew<vtkCellDataToPointData> means;
  means->SetInputData(grid);
  means->Update();
  vtkDataArray* const expected = means->GetOutput()->GetPointData()->GetArray("number");
  ASSERT_NE(expected, nullptr);

  const TemporaryFolder folder;
  const render::Dataset dataset = packed(folder, "m.rho", subdivide(mesh, {}), {.cells_to_points = true});
  const NeutralMesh found = unpack_mesh(formats::TetMesh(formats::PackedFile::open(folder / "m.rho")));
  ASSERT_EQ(found.point_fields.size(), 1U);
  ASSERT_GE(found.points.size(), mesh.points.size());
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    // Means are stored in single precision, which rounds values below 8 by at most 2^-22.
    EXPECT_NEAR(found.point_fields[0].values[p], expected->GetTuple1(static_cast<vtkIdType>(p)), 0x1p-22) << p;
}

TEST(VtkValues, picks_on_a_boundary_are_those_of_vtk) {
  NeutralMesh mesh = box_mesh({.cells = {5, 4, 3}, .box = {{10, -2, 3}, {12, 0, 4}}, .jitter = 0.1});
  add_point_field(mesh, "wave", [](const Vec3& p) { return std::sin(3 * p.x) * p.y + p.z * p.z; });
  NeutralField number{.name = "number", .unit = {}, .values = {}};
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) number.values.push_back(static_cast<double>(c % 17));
  mesh.cell_fields = {number};

  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const auto& point : mesh.points) points->InsertNextPoint(point.data());
  grid->SetPoints(points);
  for (const auto& cell : mesh.cells) insert(*grid, CellKind::tetrahedron, {cell.begin(), cell.end()});
  grid->GetPointData()->AddArray(array_of(mesh.point_fields[0]));
  grid->GetCellData()->AddArray(array_of(number));

  const TemporaryFolder folder;
  const render::Dataset boundary = packed(folder, "m.rho", mesh).boundary();
  for (const std::string field : {"wave", "number"}) {
    render::Scene scene;
    scene.layers[0].mode = render::Mode::triangles;
    scene.layers[0].method = render::method_of(render::Accuracy::float64);
    scene.layers[0].material.color_by = render::FieldColors{.field = field, .range = boundary.field(field)->range};
    scene.camera = render::fit_camera(boundary.bounds(), {.azimuth_deg = 33, .elevation_deg = 21}, 1);
    const render::Framebuffer found = picture(boundary, scene);
    const std::vector<render::Ray> rays = camera_rays(boundary, scene.camera, 96, 96);
    std::vector<std::size_t> picks;
    for (std::size_t p = 0; p < found.pixel_count(); p += 331)
      if (std::isfinite(found.depth[p])) picks.push_back(p);
    ASSERT_GE(picks.size(), 10U);

    vtkNew<vtkPoints> places;
    places->SetDataTypeToDouble();
    for (const std::size_t p : picks) {
      const Vec3 place =
          boundary.implementation().world_from_data.point(rays[p].origin + double{found.depth[p]} * rays[p].direction);
      places->InsertNextPoint(place.x, place.y, place.z);
    }
    vtkNew<vtkPolyData> at;
    at->SetPoints(places);
    vtkNew<vtkProbeFilter> probe;
    probe->SetInputData(at);
    probe->SetSourceData(grid);
    probe->ComputeToleranceOff();
    probe->SetTolerance(1e-5);  // rounding puts places outside
    probe->Update();
    vtkDataArray* const expected = probe->GetOutput()->GetPointData()->GetArray(field.c_str());
    ASSERT_NE(expected, nullptr);
    for (std::size_t i = 0; i < picks.size(); ++i)
      // The depth is a float: it moves the place by 2^-24 of the camera's distance.
      EXPECT_NEAR(found.value[picks[i]], expected->GetTuple1(static_cast<vtkIdType>(i)), 1e-5) << field << " " << i;
  }
}

}  // namespace
}  // namespace rhoray::preprocess
