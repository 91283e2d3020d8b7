// Values written for others: VTI and VTU are read by VTK and by our own importer, NPY by numpy.

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

#include <limits>
#include <tuple>

#include "preprocess/export_grid.h"
#include "preprocess/export_tets.h"
#include "preprocess/import_mesh.h"
#include "preprocess/import_volume.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "tests/preprocess/import/support.h"
#include "tests/support/fields.h"
#include "tests/support/made_grid.h"
#include "tests/support/meshes.h"
#include "tests/support/run_program.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;

/// Calls act with a zero of each type that packed grids are made of here.
template <class Act>
void for_each_type(const Act& act) {
  std::apply(
      [&](auto... zeros) { (act(zeros), ...); },
      std::tuple<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>{});
}

class Export : public testing::Test {
 protected:
  Export() { ::setenv("RHORAY_WORKER_DIR", RHORAY_WORKERS, 1); }

  /// 7 x 6 x 5 samples that all differ, packed as a.rho.
  template <class T>
  std::vector<double> pack(const Affine& map = {}, const std::string& name = "a & \"b\"") {
    const auto sample = [](const Index3& s) { return static_cast<T>(s.x + 7 * s.y + 42 * s.z + 3); };
    NeutralVolume volume = volume_of<T>({7, 6, 5}, sample, map);
    volume.field_name = name;
    volume.field_unit = "HU";
    pack_volume(volume, folder_ / "a.rho", {.brick_edge = 4, .replace_existing = true});
    std::vector<double> expected;
    for (int n = 0; n < 7 * 6 * 5; ++n) expected.push_back(static_cast<double>(static_cast<T>(n + 3)));
    return expected;
  }

  TemporaryFolder folder_;
};

const Affine turned{{0.1, 2, 0}, {3, 0, 0.1}, {0, 0.2, -0.7}, {10, 20, 1e6 / 3}};

TEST_F(Export, writes_vti_that_comes_back_bit_for_bit) {
  const Affine parallel = axis_parallel_map({0.1, 1.0 / 3, 0.7}, {-1e6 / 7, 0.1, 3});
  const auto round_trip = [&]<class T>(T) {
    const std::vector<double> expected = pack<T>(parallel);
    const ExportReport report = export_vti(folder_ / "a.rho", folder_ / "a.vti", {.replace_existing = true});
    EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder_ / "a.vti"));
    const NeutralVolume volume = import_volume(folder_ / "a.vti");
    EXPECT_EQ(volume.field_name, "a & \"b\"");
    EXPECT_EQ(formats::element_name(volume.type), formats::element_name(formats::element_type_of<T>()));
    EXPECT_EQ(volume.sample_count, Index3(7, 6, 5));
    EXPECT_EQ(volume.world_from_grid, parallel);
    EXPECT_EQ(values_of(volume), expected);
  };
  for_each_type(round_trip);
}

TEST_F(Export, writes_each_field_of_a_grid_into_one_vti) {
  const auto first = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<float>(i + 5 * j + 20 * k);
  };
  const auto second = [&](std::int64_t i, std::int64_t j, std::int64_t k) { return -first(i, j, k); };
  write_file(folder_ / "a.rho", made_grid({.sample_count = {5, 4, 3}}, {{"first", first}, {"second", second}}).file());
  export_vti(folder_ / "a.rho", folder_ / "a.vti");
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName((folder_ / "a.vti").c_str());
  reader->Update();
  for (const auto& [name, sign] : {std::pair("first", 1), std::pair("second", -1)}) {
    std::vector<double> expected;
    for (int n = 0; n < 60; ++n) expected.push_back(sign * n);
    ImportVolumeOptions options;
    options.field = name;
    EXPECT_EQ(values_of(import_volume(folder_ / "a.vti", options)), expected);
    vtkDataArray* const array = reader->GetOutput()->GetPointData()->GetArray(name);
    ASSERT_NE(array, nullptr) << name;
    for (int n = 0; n < 60; ++n) EXPECT_EQ(array->GetComponent(n, 0), sign * n) << name;
  }
}

TEST_F(Export, writes_vti_that_vtk_puts_into_the_same_place) {
  pack<float>(turned);
  const ExportReport report = export_vti(folder_ / "a.rho", folder_ / "a.vti");
  EXPECT_THAT(report.notes, testing::ElementsAre(testing::HasSubstr("HU")));
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName((folder_ / "a.vti").c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  ASSERT_EQ(image->GetNumberOfPoints(), 7 * 6 * 5);
  int at[3] = {6, 4, 2};
  const vtkIdType id = image->ComputePointId(at);
  double world[3];
  image->GetPoint(id, world);
  expect_near({world[0], world[1], world[2]}, turned.point({6, 4, 2}), 1e-9);
  EXPECT_EQ(image->GetPointData()->GetScalars()->GetComponent(id, 0), 6 + 7 * 4 + 42 * 2 + 3);
  expect_map(import_volume(folder_ / "a.vti").world_from_grid, turned, 1e-15 * 1e6);
}

TEST_F(Export, writes_npy_that_numpy_reads_in_the_order_z_y_x) {
  std::string python;
  for (const std::string candidate : {"python3", "/usr/bin/python3"})
    if (python.empty() && run_program({candidate, "-c", "import numpy"}).exit_code == 0) python = candidate;
  if (python.empty()) GTEST_SKIP() << "no python3 with numpy here";
  const auto expect_read = [&]<class T>(T, const std::string& dtype) {
    pack<T>();
    export_npy(folder_ / "a.rho", folder_ / "a.npy", {.replace_existing = true});
    const RunResult run = run_program(
        {python, "-c",
         "import numpy as np\na = np.load('a.npy')\nassert a.flags['C_CONTIGUOUS']\nprint(a.dtype, a.shape, "
         "(a == (np.arange(210) + 3).astype(a.dtype).reshape(5, 6, 7)).all())"},
        folder_.path());
    EXPECT_EQ(run.out, dtype + " (5, 6, 7) True\n") << run.err;
  };
  expect_read(std::uint8_t{}, "uint8");
  expect_read(std::int16_t{}, "int16");
  expect_read(std::uint32_t{}, "uint32");
  expect_read(float{}, "float32");
  expect_read(double{}, "float64");
  const ExportReport report = export_npy(folder_ / "a.rho", folder_ / "b.npy");
  EXPECT_THAT(report.notes, testing::ElementsAre(testing::HasSubstr("no geometry"), testing::HasSubstr("HU")));
}

TEST_F(Export, writes_nifti_that_comes_back) {
  const auto round_trip = [&]<class T>(T) {
    const std::vector<double> expected = pack<T>(turned);
    const ExportReport report = export_nifti(folder_ / "a.rho", folder_ / "a.nii", {.replace_existing = true});
    EXPECT_THAT(report.notes, testing::ElementsAre(testing::HasSubstr("RAS"), testing::HasSubstr("of a step"),
                                                   testing::HasSubstr("HU")));
    EXPECT_EQ(report.file_bytes, std::filesystem::file_size(folder_ / "a.nii"));
    const NeutralVolume volume = import_volume(folder_ / "a.nii");
    EXPECT_EQ(formats::element_name(volume.type), formats::element_name(formats::element_type_of<T>()));
    EXPECT_EQ(volume.sample_count, Index3(7, 6, 5));
    EXPECT_EQ(volume.space, formats::Space::ras);
    EXPECT_EQ(values_of(volume), expected);
    // The header holds positions up to a third of a million in single precision.
    expect_map(volume.world_from_grid, turned, 0.02);
  };
  for_each_type(round_trip);
}

TEST_F(Export, writes_nifti_in_ras) {
  NeutralVolume volume = volume_of<float>({4, 3, 2}, [](const Index3& s) { return static_cast<float>(s.x); },
                                          {{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}, {8, 4, -2}});
  volume.space = formats::Space::lps;
  volume.length_unit = "mm";
  pack_volume(volume, folder_ / "a.rho", {});
  EXPECT_THAT(export_nifti(folder_ / "a.rho", folder_ / "a.nii").notes, testing::IsEmpty());
  const NeutralVolume back = import_volume(folder_ / "a.nii");
  EXPECT_EQ(back.space, formats::Space::ras);
  EXPECT_EQ(back.length_unit, "mm");
  EXPECT_EQ(back.world_from_grid, (Affine{{-0.5, 0, 0}, {0, -0.25, 0}, {0, 0, 2}, {-8, -4, -2}}));
}

TEST_F(Export, says_when_nifti_moves_the_grid_and_refuses_what_no_reader_could_use) {
  const auto exported = [&](double spacing, double origin) {
    pack<float>(axis_parallel_map({spacing, spacing, spacing}, {origin, 0, 0}));
    return export_nifti(folder_ / "a.rho", folder_ / "a.nii", {.replace_existing = true});
  };
  EXPECT_THAT(exported(1, 0.3).notes, testing::Not(testing::Contains(testing::HasSubstr("of a step"))));
  EXPECT_THAT(exported(1, 100000000.3).notes, testing::Contains(testing::HasSubstr("by up to 0.3 of a step")));
  EXPECT_EQ(import_volume(folder_ / "a.nii").world_from_grid.origin.x, 1e8);
  std::filesystem::remove(folder_ / "a.nii");
  expect_refusal([&] { exported(1e-60, 0); }, ErrorCode::unsupported, {"a.rho: the axes span no volume"});
  expect_refusal([&] { exported(1e50, 0); }, ErrorCode::unsupported, {"a.rho: found a vector of length 1e+50"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.nii"));
}

/// The facts that a format may lose.
struct Facts {
  bool length_unit, space, field_unit, label_names;
  friend bool operator==(const Facts&, const Facts&) = default;
};

Facts facts_in(const std::vector<std::string>& notes) {
  const auto is_noted = [&](const std::string& fact) {
    return std::any_of(notes.begin(), notes.end(), [&](const std::string& note) {
      return note.find("does not store " + fact) != std::string::npos;
    });
  };
  return {is_noted("the unit mm of lengths"), is_noted("the space LPS"), is_noted("the unit HU of field 'organ'"),
          is_noted("the names of the labels of field 'organ'")};
}

TEST_F(Export, says_which_facts_a_format_loses) {
  NeutralVolume volume = volume_of<std::uint8_t>(
      {4, 5, 6}, [](const Index3& s) { return static_cast<std::uint8_t>(s.x / 2); },
      axis_parallel_map({1, 2, 3}, {0, 0, 0}));
  volume.length_unit = "mm";
  volume.space = formats::Space::lps;
  volume.field_name = "organ";
  volume.field_unit = "HU";
  volume.label_names = {{1, "liver"}};
  pack_volume(volume, folder_ / "a.rho");
  const auto exported = [&](const std::string& extension) {
    const std::filesystem::path output = folder_ / ("a" + extension);
    if (extension == ".vti") return export_vti(folder_ / "a.rho", output);
    if (extension == ".nii") return export_nifti(folder_ / "a.rho", output);
    if (extension == ".npy") return export_npy(folder_ / "a.rho", output);
    if (extension == ".stl") return export_grid_stl(folder_ / "a.rho", 0.5, output);
    return export_vdb(folder_ / "a.rho", output);
  };
  struct Row {
    const char* extension;
    Facts lost;
    bool is_read;  // by our importers as a volume
  };
  const Row rows[] = {{".vti", {true, true, true, true}, true},   {".nii", {false, false, true, true}, true},
                      {".npy", {true, true, true, true}, true},   {".vdb", {false, true, false, true}, true},
                      {".nvdb", {true, true, true, true}, false}, {".stl", {true, true, false, false}, false}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.extension);
    EXPECT_EQ(facts_in(exported(row.extension).notes), row.lost);
    if (!row.is_read) continue;
    const NeutralVolume back = import_volume(folder_ / (std::string("a") + row.extension));
    EXPECT_EQ((Facts{back.length_unit != "mm", back.space == formats::Space::unknown, back.field_unit != "HU",
                     back.label_names.empty()}),
              row.lost);
  }
}

TEST_F(Export, says_which_facts_of_a_mesh_vtu_loses) {
  NeutralMesh mesh = box_mesh({}, [](const Vec3& p) { return p.x; });
  mesh.length_unit = "mm";
  mesh.point_fields[0].unit = "mV";
  NeutralField organ{.name = "organ", .unit = "HU", .values = {}, .label_names = {{1, "liver"}}};
  organ.values.assign(mesh.cells.size(), 1);
  mesh.cell_fields.push_back(organ);
  pack_mesh(mesh, folder_ / "m.rho");
  const ExportReport report = export_vtu(folder_ / "m.rho", folder_ / "m.vtu");
  EXPECT_EQ(facts_in(report.notes), (Facts{true, false, true, true}));
  EXPECT_THAT(report.notes, testing::Contains(testing::HasSubstr("does not store the unit mV of field 'value'")));
  const NeutralMesh back = import_mesh(folder_ / "m.vtu");
  EXPECT_EQ(back.length_unit + back.point_fields[0].unit + back.cell_fields[0].unit, "");
  EXPECT_TRUE(back.cell_fields[0].label_names.empty());
}

TEST_F(Export, says_which_of_several_fields_it_wrote) {
  std::vector<NeutralVolume> fields;
  for (const char* name : {"first", "second"}) {
    fields.push_back(volume_of<float>({3, 3, 3}, [](const Index3& s) { return static_cast<float>(s.x); }));
    fields.back().field_name = name;
  }
  pack_grid(fields, folder_ / "a.rho", {});
  const auto is_choice = testing::HasSubstr("'first' is written; choose another with --field");
  EXPECT_THAT(export_npy(folder_ / "a.rho", folder_ / "a.npy").notes, testing::Contains(is_choice));
  EXPECT_THAT(export_npy(folder_ / "a.rho", folder_ / "b.npy", {.field = "first"}).notes,
              testing::Not(testing::Contains(is_choice)));
  EXPECT_THAT(export_vti(folder_ / "a.rho", folder_ / "a.vti").notes, testing::IsEmpty());
}

TEST_F(Export, replaces_nothing_and_leaves_nothing_behind_when_it_is_refused) {
  pack<float>({}, "density");
  write_file(folder_ / "a.vti", "precious");
  expect_refusal([&] { export_vti(folder_ / "a.rho", folder_ / "a.vti"); }, ErrorCode::usage, {"a.vti"});
  expect_refusal([&] { export_npy(folder_ / "a.rho", folder_ / "a.npy", {.field = "heat"}); }, ErrorCode::usage,
                 {"'heat'", "'density'"});
  const Progress interrupted = [](std::string_view, std::uint64_t done, std::uint64_t) {
    if (done > 0) throw Error(ErrorCode::interrupted, "enough");
  };
  expect_refusal([&] { export_npy(folder_ / "a.rho", folder_ / "a.npy", {}, interrupted); }, ErrorCode::interrupted,
                 {});
  EXPECT_EQ(read_file(folder_ / "a.vti"), "precious");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 2);
}

TEST_F(Export, writes_vtu_with_the_same_points_fields_and_cell_ids) {
  NeutralMesh mesh = box_mesh({.cells = {4, 4, 4}, .box = Box3({1e6, 0, 0}, {1e6 + 1, 2, 3}), .jitter = 0.1},
                              [](const Vec3& p) { return p.x - 1e6 + p.y * p.z; });
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  mesh.cells[5][1] = mesh.cells[5][0];  // will be dropped, so that ids are no longer positions
  pack_mesh(mesh, folder_ / "m.rho");
  export_vtu(folder_ / "m.rho", folder_ / "m.vtu");
  const NeutralMesh read = import_mesh(folder_ / "m.vtu");
  EXPECT_EQ(read.points, mesh.points);
  ASSERT_EQ(read.cells.size(), mesh.cells.size() - 1);
  ASSERT_EQ(read.point_fields.size(), 2U);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_EQ(read.point_fields[f].name, mesh.point_fields[f].name);
    EXPECT_EQ(read.point_fields[f].values, mesh.point_fields[f].values);
  }
  ASSERT_EQ(read.cell_fields.size(), 1U);
  EXPECT_EQ(read.cell_fields[0].name, "cell_id");
  EXPECT_EQ(read.cell_fields[0].values[4], 4);
  EXPECT_EQ(read.cell_fields[0].values[5], 6);
}

}  // namespace
}  // namespace rhoray::preprocess
