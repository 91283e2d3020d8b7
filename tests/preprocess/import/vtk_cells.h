#pragma once

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include "tests/preprocess/import/support.h"

namespace rhoray::tests {

using preprocess::CellKind;
using preprocess::CellMesh;

/// Cells of every kind that VTK 9.1 can hold, on 30 points, with nodes that mean nothing: what
/// counts is that they come back as they were. `nodes` of polyhedra are streams of faces.
struct EveryKind {
  std::vector<CellKind> kinds;
  std::vector<std::vector<std::uint64_t>> nodes;
  vtkSmartPointer<vtkUnstructuredGrid> grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
};

inline void add_points(vtkUnstructuredGrid& grid, int count, double shift = 0) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  for (int i = 0; i < count; ++i) points->InsertNextPoint(shift + i / 4.0, i % 7, i * i);
  grid.SetPoints(points);
}

/// A field v = 100 i (single precision, in mV) at points and c = 7 i + 1 in cells.
inline void add_fields(vtkUnstructuredGrid& grid, double first_value = 0) {
  const auto v = vtkSmartPointer<vtkFloatArray>::New();
  v->SetName("v");
  v->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), "mV");
  for (int i = 0; i < grid.GetNumberOfPoints(); ++i) v->InsertNextValue(static_cast<float>(first_value + 100 * i));
  grid.GetPointData()->AddArray(v);
  const auto c = vtkSmartPointer<vtkIntArray>::New();
  c->SetName("c");
  for (int i = 0; i < grid.GetNumberOfCells(); ++i) c->InsertNextValue(static_cast<int>(first_value) + 7 * i + 1);
  grid.GetCellData()->AddArray(c);
}

inline void insert(vtkUnstructuredGrid& grid, CellKind kind, const std::vector<std::uint64_t>& nodes) {
  const auto list = vtkSmartPointer<vtkIdList>::New();
  for (const std::uint64_t node : nodes) list->InsertNextId(static_cast<vtkIdType>(node));
  grid.InsertNextCell(static_cast<int>(kind), list);  // of a polyhedron it wants the same stream as CellMesh has
}

/// A cube of corners first .. first+7 (in the order of a hexahedron) as a stream of its faces.
inline std::vector<std::uint64_t> cube_stream(std::uint64_t first) {
  std::vector<std::uint64_t> stream{6};
  for (const std::array<std::uint64_t, 4>& face : {std::array<std::uint64_t, 4>{0, 3, 2, 1},
                                                   {4, 5, 6, 7},
                                                   {0, 1, 5, 4},
                                                   {1, 2, 6, 5},
                                                   {2, 3, 7, 6},
                                                   {3, 0, 4, 7}}) {
    stream.push_back(4);
    for (const std::uint64_t corner : face) stream.push_back(first + corner);
  }
  return stream;
}

inline EveryKind every_kind() {
  EveryKind all;
  add_points(*all.grid, 30);
  for (const auto& [kind, count] :
       std::vector<std::pair<int, int>>{{10, 4},  {11, 8},  {12, 8},  {13, 6},  {14, 5},  {15, 10}, {16, 12}, {24, 10},
                                        {25, 20}, {26, 15}, {27, 13}, {29, 27}, {31, 12}, {32, 18}, {33, 24}, {42, 0},
                                        {71, 20}, {72, 27}, {73, 18}, {42, 1},  {74, 14}, {10, 4}}) {
    all.kinds.push_back(static_cast<CellKind>(kind));
    std::vector<std::uint64_t>& nodes = all.nodes.emplace_back();
    if (kind == 42)
      nodes = cube_stream(static_cast<std::uint64_t>(9 * count));
    else
      for (int i = 0; i < count; ++i) nodes.push_back(static_cast<std::uint64_t>((kind + i) % 30));
    insert(*all.grid, all.kinds.back(), nodes);
  }
  add_fields(*all.grid);
  return all;
}

inline std::vector<std::uint64_t> nodes_of(const CellMesh& mesh, std::size_t cell) {
  return {mesh.cell_nodes.begin() + static_cast<std::ptrdiff_t>(mesh.cell_offsets[cell]),
          mesh.cell_nodes.begin() + static_cast<std::ptrdiff_t>(mesh.cell_offsets[cell + 1])};
}

inline void expect_every_kind(const CellMesh& mesh, const EveryKind& all) {
  ASSERT_EQ(mesh.points.size(), 30U);
  EXPECT_EQ(mesh.points[29], (std::array{29 / 4.0, 1.0, 841.0}));
  ASSERT_EQ(mesh.kinds.size(), all.kinds.size());
  for (std::size_t cell = 0; cell < all.kinds.size(); ++cell) {
    EXPECT_EQ(static_cast<int>(mesh.kinds[cell]), static_cast<int>(all.kinds[cell]));
    EXPECT_EQ(nodes_of(mesh, cell), all.nodes[cell]) << "cell " << cell;
  }
  EXPECT_TRUE(mesh.cell_ids.empty());
  ASSERT_EQ(mesh.point_fields.size(), 1U);
  EXPECT_EQ(mesh.point_fields[0].name, "v");
  EXPECT_EQ(mesh.point_fields[0].unit, "mV");
  EXPECT_TRUE(mesh.point_fields[0].was_single_precision);
  EXPECT_EQ(mesh.point_fields[0].values[29], 2900);
  ASSERT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_EQ(mesh.cell_fields[0].values.back(), 7 * (static_cast<double>(all.kinds.size()) - 1) + 1);
}

/// An array vtkGhostType.
inline vtkSmartPointer<vtkUnsignedCharArray> ghosts(const std::vector<unsigned char>& values) {
  const auto array = vtkSmartPointer<vtkUnsignedCharArray>::New();
  array->SetName("vtkGhostType");
  for (const unsigned char value : values) array->InsertNextValue(value);
  return array;
}

}  // namespace rhoray::tests
