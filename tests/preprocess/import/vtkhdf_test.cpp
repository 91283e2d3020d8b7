#include <netcdf.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkHDFReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <numeric>

#include "preprocess/import/readers.h"
#include "preprocess/import_volume.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"

// The netCDF library writes the files, as HDF5; VTK's reader says what they mean.

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

/// Writes groups, attributes and arrays below the group VTKHDF.
class HdfFile {
 public:
  HdfFile(const std::filesystem::path& path, const std::string& type, std::vector<int> version = {1, 0}) {
    check(::nc_create(path.c_str(), NC_NETCDF4 | NC_CLOBBER, &file_));
    root_ = group("VTKHDF");
    check(::nc_put_att_int(root_, NC_GLOBAL, "Version", NC_INT64, version.size(), version.data()));
    check(::nc_put_att_text(root_, NC_GLOBAL, "Type", type.size(), type.data()));
  }
  ~HdfFile() { check(::nc_close(file_)); }
  HdfFile(const HdfFile&) = delete;
  HdfFile& operator=(const HdfFile&) = delete;

  int root() const { return root_; }
  int group(const char* name) { return group(name, root_ == 0 ? file_ : root_); }
  int group(const char* name, int parent) {
    int id = 0;
    check(::nc_def_grp(parent, name, &id));
    return id;
  }
  void doubles(const char* name, const std::vector<double>& numbers) {
    check(::nc_put_att_double(root_, NC_GLOBAL, name, NC_DOUBLE, numbers.size(), numbers.data()));
  }
  void integers(const char* name, const std::vector<int>& numbers) {
    check(::nc_put_att_int(root_, NC_GLOBAL, name, NC_INT64, numbers.size(), numbers.data()));
  }
  void array(int in, const char* name, int type, const std::vector<std::size_t>& shape,
             const std::vector<double>& numbers) {
    std::vector<int> axes;
    for (const std::size_t size : shape) {
      int axis = 0;
      check(::nc_def_dim(root_, concat("axis", axis_count_++).c_str(), size, &axis));
      axes.push_back(axis);
    }
    int id = 0;
    check(::nc_def_var(in, name, type, static_cast<int>(axes.size()), axes.data(), &id));
    check(::nc_put_var_double(in, id, numbers.data()));
  }

 private:
  static void check(int status) { ASSERT_EQ(status, NC_NOERR) << ::nc_strerror(status); }
  int file_ = 0, root_ = 0, axis_count_ = 0;
};

std::vector<double> ascending(std::size_t count) {
  std::vector<double> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

void write_image(const std::filesystem::path& path, int first = 0) {
  HdfFile file(path, "ImageData");
  file.integers("WholeExtent", {first, first + 3, 0, 2, 0, 1});
  file.doubles("Origin", {1, 2, 3});
  file.doubles("Spacing", {2, 3, 4});
  const std::vector<double> upright{1, 0, 0, 0, 1, 0, 0, 0, 1}, turned{0, 1, 0, -1, 0, 0, 0, 0, 1};
  file.doubles("Direction", first == 0 ? upright : turned);
  const int points = file.group("PointData");
  file.array(points, "density", NC_SHORT, {2, 3, 4}, ascending(24));
  file.array(points, "flow", NC_FLOAT, {2, 3, 4, 3}, ascending(72));
  if (first != 0) file.array(file.group("CellData"), "region", NC_UBYTE, {1, 2, 3}, ascending(6));
}

/// Two partitions: a tetrahedron, and a hexahedron that shares no point with it.
void write_mesh(const std::filesystem::path& path) {
  HdfFile file(path, "UnstructuredGrid");
  const int root = file.root();
  file.array(root, "NumberOfPoints", NC_INT64, {2}, {4, 8});
  file.array(root, "NumberOfCells", NC_INT64, {2}, {1, 1});
  file.array(root, "NumberOfConnectivityIds", NC_INT64, {2}, {4, 8});
  file.array(root, "Points", NC_FLOAT, {12, 3},
             {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,  //
              5, 0, 0, 6, 0, 0, 6, 1, 0, 5, 1, 0, 5, 0, 1, 6, 0, 1, 6, 1, 1, 5, 1, 1});
  file.array(root, "Offsets", NC_INT64, {4}, {0, 4, 0, 8});
  file.array(root, "Connectivity", NC_INT64, {12}, {0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7});
  file.array(root, "Types", NC_UBYTE, {2}, {10, 12});
  const int points = file.group("PointData");
  file.array(points, "potential", NC_DOUBLE, {12}, ascending(12));
  file.array(points, "stress", NC_FLOAT, {12, 6}, ascending(72));
  file.array(file.group("CellData"), "tissue", NC_INT, {2}, {7, 9});
}

TEST(VtkHdf, reads_image_data_as_vtk_does) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf";
  write_image(path);
  EXPECT_EQ(foreign_kind(path), ForeignKind::volume);
  const NeutralVolume volume = read_volume(path, {});
  EXPECT_EQ(volume.field_name, "density");
  EXPECT_EQ(volume.type, ElementType::I16);
  EXPECT_EQ(volume.sample_count, Index3(4, 3, 2));
  EXPECT_EQ(values_of(volume), ascending(24));
  vtkNew<vtkHDFReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  auto* image = vtkImageData::SafeDownCast(reader->GetOutputAsDataSet());
  ASSERT_NE(image, nullptr);
  ASSERT_EQ(image->GetNumberOfPoints(), 24);
  for (vtkIdType i = 0; i < 24; ++i) {
    EXPECT_EQ(values_of(volume)[static_cast<std::size_t>(i)], image->GetPointData()->GetArray("density")->GetTuple1(i));
    const Vec3 place = volume.world_from_grid.point(Vec3(Index3(i % 4, i / 4 % 3, i / 12)));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(place[axis], image->GetPoint(i)[axis], 1e-12) << i;
  }
  const std::vector<double> flow = values_of(read_volume(path, {.field = "flow.y"}));
  for (std::size_t i = 0; i < 24; ++i)
    EXPECT_EQ(flow[i], image->GetPointData()->GetArray("flow")->GetTuple3(static_cast<vtkIdType>(i))[1]);
  expect_refusal([&] { read_volume(path, {.field = "flow"}); }, ErrorCode::usage, {"flow.mag, flow.x"});
}

/// VTK 9.1 cannot read these: it takes the extent for a place in the array, and cells for points,
/// and drops the direction.
TEST(VtkHdf, reads_a_direction_values_of_cells_and_an_extent_that_does_not_begin_at_zero) {
  TemporaryFolder folder;
  write_image(folder / "a.vtkhdf", 5);
  const NeutralVolume volume = read_volume(folder / "a.vtkhdf", {});
  EXPECT_EQ(values_of(volume), ascending(24));
  expect_near(volume.world_from_grid.origin, {1, 2 - 5 * 2, 3});  // column x of the direction is (0, -1, 0)
  const NeutralVolume cells = read_volume(folder / "a.vtkhdf", {.field = "region"});
  EXPECT_EQ(cells.sample_count, Index3(3, 2, 1));
  EXPECT_EQ(values_of(cells), ascending(6));
}

TEST(VtkHdf, reads_the_partitions_of_an_unstructured_grid_as_vtk_does) {
  TemporaryFolder folder;
  const auto path = folder / "a.hdf";
  write_mesh(path);
  EXPECT_EQ(foreign_kind(path), ForeignKind::mesh);
  const CellMesh mesh = read_cells(path, {});
  vtkNew<vtkHDFReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  auto* grid = vtkUnstructuredGrid::SafeDownCast(reader->GetOutputAsDataSet());
  ASSERT_NE(grid, nullptr);
  ASSERT_EQ(mesh.kinds.size(), static_cast<std::size_t>(grid->GetNumberOfCells()));
  ASSERT_EQ(mesh.points.size(), static_cast<std::size_t>(grid->GetNumberOfPoints()));
  for (std::size_t c = 0; c < mesh.kinds.size(); ++c) {
    EXPECT_EQ(static_cast<int>(mesh.kinds[c]), grid->GetCellType(static_cast<vtkIdType>(c)));
    const std::uint64_t first = mesh.cell_offsets[c];
    ASSERT_EQ(mesh.cell_offsets[c + 1] - first, grid->GetCell(static_cast<vtkIdType>(c))->GetNumberOfPoints());
    for (std::uint64_t k = first; k < mesh.cell_offsets[c + 1]; ++k)
      EXPECT_EQ(mesh.cell_nodes[k], grid->GetCell(static_cast<vtkIdType>(c))->GetPointId(static_cast<int>(k - first)));
  }
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(mesh.points[i][static_cast<std::size_t>(axis)], grid->GetPoint(static_cast<vtkIdType>(i))[axis]);
  ASSERT_EQ(mesh.point_fields.size(), 2U);
  EXPECT_EQ(mesh.point_fields[0].name, "potential");
  EXPECT_EQ(mesh.point_fields[1].component_count, 6);
  EXPECT_EQ(mesh.point_fields[1].values[71], 71);
  ASSERT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_THAT(mesh.cell_fields[0].values, testing::ElementsAre(7, 9));
}

TEST(VtkHdf, refuses_times_other_versions_and_types_and_damage_in_one_line) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf";
  {
    HdfFile file(path, "ImageData");
    file.integers("WholeExtent", {0, 1, 0, 1, 0, 1});
    file.group("Steps");
  }
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::unsupported, {"group Steps", "several time steps"});
  { HdfFile file(path, "ImageData", {3, 0}); }
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::unsupported,
                 {"attribute Version: found 3.0", "1.0 to 2.x"});
  { HdfFile file(path, "PolyData"); }
  EXPECT_EQ(foreign_kind(path), ForeignKind::unknown);
  EXPECT_THAT(advice_on(path), testing::HasSubstr("only image data and unstructured grids"));
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::unsupported, {"attribute Type", "'PolyData'"});
  { HdfFile file(path, "ImageData"); }
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::invalid, {"WholeExtent"});
  write_file(path, "no HDF5");
  EXPECT_EQ(foreign_kind(path), ForeignKind::unknown);
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::invalid, {"a.vtkhdf", "netCDF or HDF5"});
  {
    HdfFile file(path, "ImageData");
    file.integers("WholeExtent", {0, 1000000, 0, 1000000, 0, 1});
    file.array(file.group("PointData"), "a", NC_FLOAT, {2, 2, 2}, ascending(8));
  }
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::invalid, {"'VTKHDF/PointData/a'", "2 x 2 x 2"});
}

/// A VTKHDF image of 2 x 2 x 4 points whose array `v` has been made by HDF5's library.
void write_image_with(const std::filesystem::path& path, const std::function<void(const Hdf5Writer&)>& add_array) {
  {
    HdfFile file(path, "ImageData");
    file.integers("WholeExtent", {0, 3, 0, 1, 0, 1});
    file.group("PointData");
  }
  add_array(Hdf5Writer(path, H5F_ACC_RDWR));
}

/// HDF5 reads zeros where nothing was written.
TEST(VtkHdf, refuses_numbers_that_were_never_written) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf";
  const hid_t chunks = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk[] = {1, 1, 4};
  H5Pset_chunk(chunks, 3, chunk);
  write_image_with(path, [&](const Hdf5Writer& file) {
    H5Dclose(file.make("VTKHDF/PointData/v", H5T_IEEE_F32LE, {2, 2, 4}, H5P_DEFAULT));
  });
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::invalid,
                 {"a.vtkhdf, data set 'VTKHDF/PointData/v'", "never written"});
  write_image_with(path, [&](const Hdf5Writer& file) { file.part("VTKHDF/PointData/v", {2, 2, 4}, chunks); });
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::invalid, {"found 1 of 4 chunks"});
  H5Pclose(chunks);
  write_image_with(path, [&](const Hdf5Writer& file) {
    file.array("VTKHDF/PointData/v", H5T_IEEE_F32LE, {2, 2, 4}, ascending(16), {1, 1, 4});
  });
  EXPECT_EQ(values_of(read_volume(path, {})), ascending(16));
}

/// HDF5 follows links to other files and reads numbers from them, even from a pipe.
TEST(VtkHdf, refuses_what_leads_to_other_files) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf", secret = folder / "secret.bin", other = folder / "other.h5";
  write_file(secret, std::string(64, '1'));
  { Hdf5Writer(other).array("v", H5T_IEEE_F32LE, {2, 2, 4}, ascending(16)); }
  const hid_t external = H5Pcreate(H5P_DATASET_CREATE), mapped = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(external, secret.c_str(), 0, 64);
  const hsize_t shape[] = {2, 2, 4};
  const hid_t space = H5Screate_simple(3, shape, nullptr);
  H5Pset_virtual(mapped, space, other.c_str(), "/v", space);
  for (const hid_t creation : {external, mapped}) {
    write_image_with(path, [&](const Hdf5Writer& file) {
      H5Dclose(file.make("VTKHDF/PointData/v", H5T_IEEE_F32LE, {2, 2, 4}, creation));
    });
    expect_refusal([&] { read_volume(path, {}); }, ErrorCode::unsupported,
                   {"a.vtkhdf, data set 'VTKHDF/PointData/v'", "numbers in other files"});
  }
  H5Sclose(space);
  H5Pclose(mapped);
  H5Pclose(external);
  write_image_with(path, [&](const Hdf5Writer& file) {
    H5Lcreate_external(other.c_str(), "/v", file.id(), "VTKHDF/PointData/v", H5P_DEFAULT, H5P_DEFAULT);
  });
  expect_refusal([&] { read_volume(path, {}); }, ErrorCode::unsupported,
                 {"a.vtkhdf, link 'VTKHDF/PointData/v'", "to another file"});
}

TEST(VtkHdf, refuses_cells_that_point_outside) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf";
  const auto refuses = [&](std::vector<double> kinds, std::vector<double> nodes, std::vector<double> ends,
                           const std::vector<std::string>& words) {
    {
      HdfFile file(path, "UnstructuredGrid");
      for (const char* name : {"NumberOfPoints", "NumberOfConnectivityIds"})
        file.array(file.root(), name, NC_INT64, {1}, {4});
      file.array(file.root(), "NumberOfCells", NC_INT64, {1}, {1});
      file.array(file.root(), "Points", NC_FLOAT, {4, 3}, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
      file.array(file.root(), "Offsets", NC_INT64, {2}, ends);
      file.array(file.root(), "Connectivity", NC_INT64, {4}, nodes);
      file.array(file.root(), "Types", NC_INT, {1}, kinds);
    }
    try {
      read_cells(path, {});
      ADD_FAILURE() << "read";
    } catch (const Error& error) {
      for (const std::string& word : words) EXPECT_THAT(error.what(), testing::HasSubstr(word));
    }
  };
  refuses({10}, {0, 1, 2, 4}, {0, 4}, {"4"});
  refuses({10}, {0, 1, 2, -1}, {0, 4}, {"a.vtkhdf"});
  refuses({10}, {0, 1, 2, 3}, {0, 5}, {"a.vtkhdf"});
  refuses({266}, {0, 1, 2, 3}, {0, 4}, {"'Types'", "kind 266"});
  refuses({42}, {0, 1, 2, 3}, {0, 4}, {"polyhedra"});
}

TEST(VtkHdf, refuses_partitions_whose_counts_overflow_together) {
  TemporaryFolder folder;
  const auto path = folder / "a.vtkhdf";
  // 65,536 times 2^48 points are 2^64, which 64 bits would take for 0; the last partition has 4.
  std::vector<double> points(65536, 0x1p48), ones(65537, 0);
  points.push_back(4), ones.back() = 1;
  {
    HdfFile file(path, "UnstructuredGrid");
    file.array(file.root(), "NumberOfPoints", NC_INT64, {points.size()}, points);
    file.array(file.root(), "NumberOfCells", NC_INT64, {ones.size()}, ones);
    file.array(file.root(), "NumberOfConnectivityIds", NC_INT64, {points.size()}, points);
    file.array(file.root(), "Points", NC_FLOAT, {4, 3}, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
    file.array(file.root(), "Offsets", NC_INT64, {65538}, std::vector<double>(65538));
    file.array(file.root(), "Connectivity", NC_INT64, {4}, ascending(4));
    file.array(file.root(), "Types", NC_INT, {1}, {10});
  }
  expect_refusal([&] { read_cells(path, {}); }, ErrorCode::invalid, {"'NumberOfPoints'", "in all"});
}

/// HDF5 itself may end the process on some of them: through the worker, that is a sentence, too.
TEST(VtkHdf, every_beginning_of_a_file_ends_as_a_sentence) {
  ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1);
  TemporaryFolder folder;
  write_image(folder / "whole.vtkhdf");
  const std::string content = read_file(folder / "whole.vtkhdf");
  const auto is_whole = [&] { return values_of(import_volume(folder / "a.vtkhdf")) == ascending(24); };
  EXPECT_EQ(check_every_beginning(folder / "a.vtkhdf", content, is_whole, {.stride = 997}), 0);
}

}  // namespace
}  // namespace rhoray::preprocess
