#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <locale>

#include "preprocess/export/output_stream.h"
#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/vtk/vtk_errors.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

template <class Array>
void add_array(vtkFieldData& data, const NeutralField& field) {
  vtkNew<Array> array;
  array->SetName(field.name.c_str());
  array->SetNumberOfComponents(field.component_count);
  array->SetNumberOfTuples(static_cast<vtkIdType>(field.values.size()) / field.component_count);
  using Number = std::remove_pointer_t<decltype(array->GetPointer(0))>;
  for (std::size_t i = 0; i < field.values.size(); ++i)
    array->SetValue(static_cast<vtkIdType>(i), static_cast<Number>(field.values[i]));
  data.AddArray(array);
}

void add_fields(vtkFieldData& data, const std::vector<NeutralField>& fields, std::uint64_t owners,
                const std::filesystem::path& path) {
  for (const NeutralField& field : fields) {
    check_field(field, owners, path);
    if (field.was_single_precision)
      add_array<vtkFloatArray>(data, field);
    else
      add_array<vtkDoubleArray>(data, field);
  }
}

void add_points(vtkUnstructuredGrid& grid, const NeutralMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    points->SetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  grid.SetPoints(points);
}

void add_cells(vtkUnstructuredGrid& grid, const NeutralMesh& mesh, const std::filesystem::path& path) {
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(mesh.cells.size()), static_cast<vtkIdType>(4 * mesh.cells.size()));
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    vtkIdType corners[4];
    for (std::size_t k = 0; k < 4; ++k) {
      if (mesh.cells[cell][k] >= mesh.points.size())
        refuse_input(path, concat("cell ", cell), concat("point ", mesh.cells[cell][k]),
                     concat("below ", mesh.points.size()));
      corners[k] = static_cast<vtkIdType>(mesh.cells[cell][k]);
    }
    cells->InsertNextCell(4, corners);
  }
  constexpr int tetrahedron = 10;
  grid.SetCells(tetrahedron, cells);
}

/// VTK's writer, with a stream that keeps the reason of a failure.
class StreamWriter : public vtkXMLUnstructuredGridWriter {
 public:
  static StreamWriter* New();
  vtkTypeMacro(StreamWriter, vtkXMLUnstructuredGridWriter);

  void SetStream(std::ostream* stream) { Stream = stream; }

 protected:
  int WriteInternal() override {
    Stream->imbue(std::locale::classic());
    return WriteData();
  }
};
vtkStandardNewMacro(StreamWriter);

}  // namespace

void write_vtu(const NeutralMesh& mesh, const std::filesystem::path& path) {
  const VtkErrors errors;
  vtkNew<vtkUnstructuredGrid> grid;
  add_points(*grid, mesh);
  add_cells(*grid, mesh, path);
  add_fields(*grid->GetPointData(), mesh.point_fields, mesh.points.size(), path);
  add_fields(*grid->GetCellData(), mesh.cell_fields, mesh.cells.size(), path);
  OutputStream file(path);
  vtkNew<StreamWriter> writer;
  writer->SetStream(&file);
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  const bool is_written = writer->Write() == 1;
  writer->SetStream(nullptr);
  file.check();
  if (!is_written || errors.any())
    throw Error(ErrorCode::resource, concat(path.string(), ": VTK cannot write it"),
                "-v prints the reason that VTK gives");
  file.finish();
}

}  // namespace rhoray::preprocess
