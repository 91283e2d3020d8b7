#include <netcdf.h>
#include <vtkCompositeDataIterator.h>
#include <vtkExodusIIReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <numeric>

#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

/// An Exodus file written by hand through the netCDF library, as SAND92-2137 describes it.
struct ExodusFile {
  struct Block {
    int id;
    std::string type;
    std::size_t nodes_of_each;
    std::vector<int> nodes;  ///< counted from 1
  };
  std::vector<std::array<double, 3>> points;
  std::vector<Block> blocks;
  std::vector<double> times;
  std::vector<std::string> point_names, cell_names;
  /// Value of variable v at step s, for point or element number n; of elements in block b.
  static double point_value(std::size_t s, std::size_t v, std::size_t n) {
    return 1000.0 * static_cast<double>(s) + 100.0 * static_cast<double>(v) + static_cast<double>(n) + 0.1;
  }
  static double cell_value(std::size_t s, std::size_t v, std::size_t b, std::size_t n) {
    return -point_value(s, v, n) - 10.0 * static_cast<double>(b);
  }
  std::vector<int> truth;  ///< for each block and cell variable; empty = no table
  std::vector<std::string> block_names;
  int format = NC_64BIT_OFFSET;
  bool points_together = false, values_together = false;

  void write(const std::filesystem::path& path) const;
};

void must(int status) {
  ASSERT_EQ(status, NC_NOERR) << ::nc_strerror(status);
}

class NetcdfWriter {
 public:
  NetcdfWriter(const std::filesystem::path& path, int format) {
    must(::nc_create(path.c_str(), NC_CLOBBER | format, &id));
  }
  ~NetcdfWriter() { must(::nc_close(id)); }

  int dimension(const std::string& name, std::size_t size) {
    int result = 0;
    must(::nc_def_dim(id, name.c_str(), size, &result));
    return result;
  }
  int variable(const std::string& name, nc_type type, std::vector<int> dimensions) {
    int result = 0;
    must(::nc_def_var(id, name.c_str(), type, static_cast<int>(dimensions.size()), dimensions.data(), &result));
    return result;
  }
  void attribute(int variable, const std::string& name, const std::string& text) {
    must(::nc_put_att_text(id, variable, name.c_str(), text.size(), text.c_str()));
  }
  int id = 0;
};

void ExodusFile::write(const std::filesystem::path& path) const {
  NetcdfWriter file(path, format);
  const float version = 5.22F;
  const int word_bytes = 8, is_large = points_together ? 0 : 1;
  for (const char* name : {"api_version", "version"})
    must(::nc_put_att_float(file.id, NC_GLOBAL, name, NC_FLOAT, 1, &version));
  must(::nc_put_att_int(file.id, NC_GLOBAL, "floating_point_word_size", NC_INT, 1, &word_bytes));
  must(::nc_put_att_int(file.id, NC_GLOBAL, "file_size", NC_INT, 1, &is_large));
  file.attribute(NC_GLOBAL, "title", "by hand");
  const int name_dim = file.dimension("len_name", 33);
  file.dimension("len_string", 33);
  file.dimension("len_line", 81);
  const int axes = file.dimension("num_dim", 3), nodes = file.dimension("num_nodes", points.size());
  const int block_dim = file.dimension("num_el_blk", blocks.size());
  std::size_t elements = 0;
  for (const Block& block : blocks) elements += block.nodes.size() / block.nodes_of_each;
  file.dimension("num_elem", elements);
  const int steps = file.dimension("time_step", NC_UNLIMITED);
  const int time_whole = file.variable("time_whole", NC_DOUBLE, {steps});
  const int ids = file.variable("eb_prop1", NC_INT, {block_dim});
  file.attribute(ids, "name", "ID");
  const int status = file.variable("eb_status", NC_INT, {block_dim});
  const int names_of_blocks = block_names.empty() ? -1 : file.variable("eb_names", NC_CHAR, {block_dim, name_dim});
  std::vector<int> coordinates;
  if (points_together)
    coordinates = {file.variable("coord", NC_DOUBLE, {axes, nodes})};
  else
    for (const char* name : {"coordx", "coordy", "coordz"})
      coordinates.push_back(file.variable(name, NC_DOUBLE, {nodes}));
  std::vector<int> connects, block_dims;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Block& block = blocks[b];
    block_dims.push_back(file.dimension(concat("num_el_in_blk", b + 1), block.nodes.size() / block.nodes_of_each));
    const int each = file.dimension(concat("num_nod_per_el", b + 1), block.nodes_of_each);
    connects.push_back(file.variable(concat("connect", b + 1), NC_INT, {block_dims[b], each}));
    file.attribute(connects[b], "elem_type", block.type);
  }
  std::vector<int> point_values, cell_values;
  int point_name = 0, cell_name = 0, table = 0;
  if (!point_names.empty()) {
    const int count = file.dimension("num_nod_var", point_names.size());
    point_name = file.variable("name_nod_var", NC_CHAR, {count, name_dim});
    if (values_together)
      point_values = {file.variable("vals_nod_var", NC_DOUBLE, {steps, count, nodes})};
    else
      for (std::size_t v = 0; v < point_names.size(); ++v)
        point_values.push_back(
            file.variable(concat("vals_nod_var", v + 1), v == 0 ? NC_FLOAT : NC_DOUBLE, {steps, nodes}));
  }
  if (!cell_names.empty()) {
    const int count = file.dimension("num_elem_var", cell_names.size());
    cell_name = file.variable("name_elem_var", NC_CHAR, {count, name_dim});
    if (!truth.empty()) table = file.variable("elem_var_tab", NC_INT, {block_dim, count});
    for (std::size_t v = 0; v < cell_names.size(); ++v)
      for (std::size_t b = 0; b < blocks.size(); ++b)
        cell_values.push_back(
            !truth.empty() && truth[b * cell_names.size() + v] == 0
                ? -1
                : file.variable(concat("vals_elem_var", v + 1, "eb", b + 1), NC_DOUBLE, {steps, block_dims[b]}));
  }
  must(::nc_enddef(file.id));

  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& point : points) values.push_back(point[axis]);
    const std::size_t start[] = {points_together ? axis : 0, 0}, count[] = {1, points.size()};
    must(::nc_put_vara_double(file.id, coordinates[points_together ? 0 : axis], points_together ? start : start + 1,
                              points_together ? count : count + 1, values.data()));
  }
  std::vector<int> block_ids, ones(blocks.size(), 1);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    block_ids.push_back(blocks[b].id);
    must(::nc_put_var_int(file.id, connects[b], blocks[b].nodes.data()));
  }
  must(::nc_put_var_int(file.id, ids, block_ids.data()));
  must(::nc_put_var_int(file.id, status, ones.data()));
  for (std::size_t b = 0; b < block_names.size(); ++b) {
    const std::size_t start[] = {b, 0}, count[] = {1, block_names[b].size()};
    if (count[1] > 0) must(::nc_put_vara_text(file.id, names_of_blocks, start, count, block_names[b].c_str()));
  }
  const auto put_names = [&](int variable, const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::size_t start[] = {i, 0}, count[] = {1, names[i].size()};
      must(::nc_put_vara_text(file.id, variable, start, count, names[i].c_str()));
    }
  };
  if (!point_names.empty()) put_names(point_name, point_names);
  if (!cell_names.empty()) put_names(cell_name, cell_names);
  if (!truth.empty()) must(::nc_put_var_int(file.id, table, truth.data()));
  for (std::size_t s = 0; s < times.size(); ++s) {
    const std::size_t step[] = {s};
    must(::nc_put_var1_double(file.id, time_whole, step, &times[s]));
    for (std::size_t v = 0; v < point_names.size(); ++v) {
      std::vector<double> values;
      for (std::size_t n = 0; n < points.size(); ++n) values.push_back(point_value(s, v, n));
      const std::size_t start[] = {s, values_together ? v : 0, 0};
      const std::size_t all[] = {1, 1, points.size()}, own[] = {1, points.size()};
      must(::nc_put_vara_double(file.id, point_values[values_together ? 0 : v], start, values_together ? all : own,
                                values.data()));
    }
    for (std::size_t v = 0; v < cell_names.size(); ++v)
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        const int variable = cell_values[v * blocks.size() + b];
        if (variable < 0) continue;
        std::vector<double> values;
        for (std::size_t n = 0; n < blocks[b].nodes.size() / blocks[b].nodes_of_each; ++n)
          values.push_back(cell_value(s, v, b, n));
        const std::size_t start[] = {s, 0}, count[] = {1, values.size()};
        must(::nc_put_vara_double(file.id, variable, start, count, values.data()));
      }
  }
}

/// Two tetrahedra, one more in a block of its own, a shell and a sphere between them.
ExodusFile small_file() {
  ExodusFile file;
  file.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1.5}, {2, 2, 2}};
  file.blocks = {{10, "TETRA", 4, {1, 2, 3, 4, 2, 3, 4, 5}},
                 {20, "SHELL4", 4, {1, 2, 3, 4}},
                 {7, "sphere", 1, {1}},
                 {30, "tet4", 4, {2, 3, 5, 6}}};
  file.times = {0, 0.5, 2};
  file.point_names = {"T", "V_X", "V_Y", "V_Z", "DISPLX", "DISPLY", "DISPLZ"};
  file.cell_names = {"p", "q"};
  file.truth = {1, 0, 1, 1, 1, 1, 1, 1};
  return file;
}

const NeutralField& field_of(const std::vector<NeutralField>& fields, const std::string& name) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const NeutralField& field) { return field.name == name; });
  if (found == fields.end()) throw std::runtime_error("no field " + name);
  return *found;
}

TEST(Exodus, keeps_the_names_of_blocks_that_have_one) {
  TemporaryFolder folder;
  ExodusFile file = small_file();
  file.block_names = {"rotor", "", "ball", "the stator"};
  file.write(folder / "a.e");
  const CellMesh mesh = read_cells(folder / "a.e", {});
  EXPECT_EQ(field_of(mesh.cell_fields, "block").label_names,
            (formats::LabelNames{{7, "ball"}, {10, "rotor"}, {30, "the stator"}}));
  EXPECT_TRUE(field_of(mesh.cell_fields, "p").label_names.empty());
}

TEST(Exodus, reads_blocks_and_fields_of_the_last_time_step) {
  TemporaryFolder folder;
  const ExodusFile file = small_file();
  file.write(folder / "a.e");
  const CellMesh mesh = read_cells(folder / "a.e", {});
  EXPECT_THAT(mesh.kinds, testing::Each(CellKind::tetrahedron));
  EXPECT_THAT(mesh.cell_nodes, testing::ElementsAre(0, 1, 2, 3, 1, 2, 3, 4, 1, 2, 4, 5));
  EXPECT_THAT(mesh.cell_ids, testing::ElementsAre(0, 1, 4));
  EXPECT_EQ(mesh.points[4], (std::array{1.0, 1.0, 1.5}));
  EXPECT_THAT(field_of(mesh.cell_fields, "block").values, testing::ElementsAre(10, 10, 30));
  const NeutralField& t = field_of(mesh.point_fields, "T");
  for (std::size_t n = 0; n < 6; ++n) EXPECT_EQ(t.values[n], static_cast<float>(ExodusFile::point_value(2, 0, n)));
  EXPECT_TRUE(t.was_single_precision);
  const NeutralField& v = field_of(mesh.point_fields, "V");
  EXPECT_EQ(v.component_count, 3);
  EXPECT_FALSE(v.was_single_precision);
  for (std::size_t n = 0; n < 6; ++n)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(v.values[3 * n + c], ExodusFile::point_value(2, 1 + c, n));
  const NeutralField& p = field_of(mesh.cell_fields, "p");
  EXPECT_THAT(p.values, testing::ElementsAre(ExodusFile::cell_value(2, 0, 0, 0), ExodusFile::cell_value(2, 0, 0, 1),
                                             ExodusFile::cell_value(2, 0, 3, 0)));
  const NeutralField& q = field_of(mesh.cell_fields, "q");
  EXPECT_TRUE(std::isnan(q.values[0]) && std::isnan(q.values[1])) << "the truth table says that block 10 lacks q";
  EXPECT_EQ(q.values[2], ExodusFile::cell_value(2, 1, 3, 0));
  EXPECT_THAT(mesh.notes,
              testing::UnorderedElementsAre(testing::HasSubstr("using the last of 3 time steps (t = 2)"),
                                            testing::HasSubstr("not displaced by field 'DISPL'"),
                                            "1 quadrilateral, 1 vertex left out: only cells that fill space are kept"));
}

TEST(Exodus, takes_the_time_step_that_was_asked_for) {
  TemporaryFolder folder;
  small_file().write(folder / "a.exo");
  const auto step_of = [&](const std::string& time, std::size_t notes) {
    const CellMesh mesh = read_cells(folder / "a.exo", {.time = time});
    EXPECT_EQ(mesh.notes.size(), 2 + notes) << time;
    return static_cast<int>(field_of(mesh.point_fields, "V").values[0]) / 1000;
  };
  EXPECT_EQ(step_of("first", 0), 0);
  EXPECT_EQ(step_of("last", 0), 2);
  EXPECT_EQ(step_of("#1", 0), 1);
  EXPECT_EQ(step_of("0.5", 0), 1);
  EXPECT_EQ(step_of("0.7", 1), 1);
  EXPECT_EQ(step_of("-5", 1), 0);
  EXPECT_EQ(step_of("1e9", 1), 2);
  for (const char* time : {"#3", "#", "#-1", "middle", "nan"})
    expect_refusal([&] { read_cells(folder / "a.exo", {.time = time}); }, ErrorCode::usage,
                   {"a.exo", "time step", time});
  ExodusFile still = small_file();
  still.times.clear();
  still.write(folder / "a.exo");
  const CellMesh mesh = read_cells(folder / "a.exo", {});
  EXPECT_TRUE(mesh.point_fields.empty());
  EXPECT_THAT(mesh.notes, testing::Contains(testing::HasSubstr("no time steps")));
  expect_refusal([&] { read_cells(folder / "a.exo", {.time = "first"}); }, ErrorCode::usage, {"no time steps"});
}

/// The same mesh in every format of netCDF and both ways to lay it out.
TEST(Exodus, reads_every_format_of_netcdf) {
  TemporaryFolder folder;
  small_file().write(folder / "a.e");
  const CellMesh expected = read_cells(folder / "a.e", {});
  for (const int format : {0, NC_64BIT_OFFSET, NC_64BIT_DATA, NC_NETCDF4, NC_NETCDF4 | NC_CLASSIC_MODEL})
    for (const bool together : {false, true}) {
      SCOPED_TRACE(testing::Message() << format << together);
      ExodusFile file = small_file();
      file.format = format;
      file.points_together = file.values_together = together;
      file.write(folder / "b.g");
      const CellMesh mesh = read_cells(folder / "b.g", {});
      EXPECT_EQ(mesh.points, expected.points);
      EXPECT_EQ(mesh.cell_nodes, expected.cell_nodes);
      EXPECT_EQ(field_of(mesh.point_fields, "V").values, field_of(expected.point_fields, "V").values);
      EXPECT_EQ(field_of(mesh.cell_fields, "p").values, field_of(expected.cell_fields, "p").values);
    }
}

/// A program that ends while it writes leaves netCDF's fill values, 9.97e36, where it wrote
/// nothing.
TEST(Exodus, takes_values_that_were_never_written_as_no_data) {
  TemporaryFolder folder;
  for (const int format : {NC_64BIT_OFFSET, NC_NETCDF4}) {
    ExodusFile file = small_file();
    file.format = format;
    file.write(folder / "a.e");
    {
      int id = 0, variable = 0;
      must(::nc_open((folder / "a.e").c_str(), NC_WRITE, &id));
      must(::nc_inq_varid(id, "time_whole", &variable));
      const std::size_t start[] = {3}, count[] = {1};
      const double time = 3;
      must(::nc_put_vara_double(id, variable, start, count, &time));
      must(::nc_inq_varid(id, "vals_nod_var1", &variable));
      const std::size_t place[] = {3, 1};
      const double value = 7;
      must(::nc_put_var1_double(id, variable, place, &value));
      must(::nc_close(id));
    }
    const CellMesh mesh = read_cells(folder / "a.e", {});
    const NeutralField& t = field_of(mesh.point_fields, "T");
    for (std::size_t n = 0; n < 6; ++n) EXPECT_TRUE(n == 1 ? t.values[n] == 7 : std::isnan(t.values[n])) << n;
    EXPECT_THAT(field_of(mesh.point_fields, "V").values, testing::Each(testing::IsNan()));
    EXPECT_THAT(field_of(mesh.cell_fields, "p").values, testing::Each(testing::IsNan()));
    EXPECT_THAT(mesh.notes, testing::Contains("field 'T': 5 values were never written"));
    EXPECT_THAT(mesh.notes, testing::Contains("field 'V': 18 values were never written"));
    EXPECT_EQ(field_of(read_cells(folder / "a.e", {.time = "2"}).point_fields, "V").values[0],
              ExodusFile::point_value(2, 1, 0));
  }
}

/// The coordinates in another file, which HDF5 reads like those in this one.
TEST(Exodus, refuses_numbers_in_other_files) {
  TemporaryFolder folder;
  ExodusFile file = small_file();
  file.format = NC_NETCDF4;
  file.write(folder / "a.e");
  {
    const Hdf5Writer hdf5(folder / "a.e", H5F_ACC_RDWR);
    H5Lcreate_external((folder / "b.e").c_str(), "/coordx", hdf5.id(), "other", H5P_DEFAULT, H5P_DEFAULT);
  }
  expect_refusal([&] { read_cells(folder / "a.e", {}); }, ErrorCode::unsupported,
                 {"a.e, link 'other'", "another file"});
}

/// A cell as VTK's own reader finds it in a file: its kind and the positions of its corners. Cells
/// are in the order of the blocks.
struct VtkCell {
  int kind;
  std::vector<std::array<double, 3>> corners;
};
std::vector<VtkCell> cells_by_vtk(const std::filesystem::path& path) {
  vtkNew<vtkExodusIIReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  std::vector<VtkCell> cells;
  const auto iterator = vtkSmartPointer<vtkCompositeDataIterator>::Take(reader->GetOutput()->NewIterator());
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem()) {
    auto* grid = vtkUnstructuredGrid::SafeDownCast(iterator->GetCurrentDataObject());
    if (grid == nullptr) continue;
    for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
      vtkIdType count = 0;
      const vtkIdType* nodes = nullptr;
      grid->GetCellPoints(c, count, nodes);
      VtkCell& cell = cells.emplace_back();
      cell.kind = grid->GetCellType(c);
      for (vtkIdType i = 0; i < count; ++i) {
        std::array<double, 3>& corner = cell.corners.emplace_back();
        grid->GetPoint(nodes[i], corner.data());
      }
    }
  }
  return cells;
}

void expect_same_cells(const CellMesh& mesh, const std::vector<VtkCell>& expected) {
  ASSERT_EQ(mesh.kinds.size(), expected.size());
  for (std::size_t c = 0; c < expected.size(); ++c) {
    EXPECT_EQ(static_cast<int>(mesh.kinds[c]), expected[c].kind) << "cell " << c;
    ASSERT_EQ(mesh.cell_offsets[c + 1] - mesh.cell_offsets[c], expected[c].corners.size());
    for (std::size_t i = 0; i < expected[c].corners.size(); ++i)
      EXPECT_EQ(mesh.points[mesh.cell_nodes[mesh.cell_offsets[c] + i]], expected[c].corners[i])
          << "cell " << c << ", node " << i;
  }
}

TEST(Exodus, orders_the_nodes_of_each_kind_as_vtks_reader_does) {
  TemporaryFolder folder;
  for (const auto& [type, count] : std::vector<std::pair<std::string, int>>{{"TETRA", 4},
                                                                            {"TETRA10", 10},
                                                                            {"HEX", 8},
                                                                            {"HEX20", 20},
                                                                            {"HEX27", 27},
                                                                            {"WEDGE", 6},
                                                                            {"WEDGE15", 15},
                                                                            {"WEDGE18", 18},
                                                                            {"PYRAMID", 5},
                                                                            {"PYRAMID13", 13}}) {
    SCOPED_TRACE(type);
    ExodusFile file;
    for (int i = 0; i < count; ++i) file.points.push_back({1.0 * i, 0.25 * (i % 3), 0.5 * (i % 7)});
    std::vector<int> nodes(static_cast<std::size_t>(count));
    std::iota(nodes.rbegin(), nodes.rend(), 1);
    file.blocks = {{1, type, nodes.size(), nodes}};
    file.write(folder / "a.e");
    expect_same_cells(read_cells(folder / "a.e", {}), cells_by_vtk(folder / "a.e"));
  }
}

/// VTK 9.1 reads these as wedges of 6 nodes. Middle nodes of the triangle below, then of the one
/// above, as VTK has them.
TEST(Exodus, keeps_the_nodes_of_a_wedge_with_straight_uprights_in_their_order) {
  TemporaryFolder folder;
  ExodusFile file;
  file.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}, {2, 0, 1}, {0, 2, 1},
                 {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  file.blocks = {{1, "wedge12", 12, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}}};
  file.write(folder / "a.e");
  const CellMesh mesh = read_cells(folder / "a.e", {});
  EXPECT_THAT(mesh.kinds, testing::ElementsAre(CellKind::quadratic_linear_wedge));
  EXPECT_THAT(mesh.cell_nodes, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11));
}

TEST(Exodus, refuses_what_does_not_fit) {
  TemporaryFolder folder;
  const auto refuses = [&](const std::function<void(ExodusFile&)>& change, ErrorCode error_code,
                           const std::vector<std::string>& words) {
    ExodusFile file = small_file();
    change(file);
    file.write(folder / "a.e");
    expect_refusal([&] { read_cells(folder / "a.e", {}); }, error_code, words);
  };
  refuses([](ExodusFile& file) { file.blocks[0].type = "HEX"; }, ErrorCode::unsupported,
          {"a.e", "block 10", "2 elements 'HEX' of 4 nodes", "hexahedra (8, 20, 27)"});
  refuses([](ExodusFile& file) { file.blocks[3].type = "nfaced"; }, ErrorCode::unsupported, {"block 30", "'nfaced'"});
  refuses([](ExodusFile& file) { file.blocks[0].nodes[5] = 0; }, ErrorCode::invalid, {"cell 1", "point -1"});
  refuses([](ExodusFile& file) { file.blocks[0].nodes[5] = 7; }, ErrorCode::invalid, {"cell 1", "point 6", "0 to 5"});
  refuses(
      [](ExodusFile& file) {
        file.blocks = {file.blocks[1]};
        file.cell_names.clear();
        file.truth.clear();
      },
      ErrorCode::invalid, {"1 quadrilateral", "fills space"});
  {
    NetcdfWriter other(folder / "a.e", 0);
    other.dimension("x", 3);
  }
  expect_refusal([&] { read_cells(folder / "a.e", {}); }, ErrorCode::invalid, {"a.e", "num_el_blk"});
  write_file(folder / "a.e", "junk of some length, to be sure");
  expect_refusal([&] { read_cells(folder / "a.e", {}); }, ErrorCode::invalid, {"a.e, header", "netCDF"});
  expect_refusal([&] { read_cells(folder / "none.e", {}); }, ErrorCode::unreadable, {"none.e"});
}

/// The library itself reads zeros behind the end of a classic file.
TEST(Exodus, refuses_every_beginning_of_a_file) {
  TemporaryFolder folder;
  for (const int format : {0, NC_64BIT_OFFSET, NC_64BIT_DATA, NC_NETCDF4}) {
    ExodusFile file = small_file();
    file.format = format;
    file.write(folder / "a.e");
    const CellMesh expected = read_cells(folder / "a.e", {});
    EXPECT_LE(check_every_beginning(folder / "a.e", read_file(folder / "a.e"),
                                    [&] {
                                      const CellMesh mesh = read_cells(folder / "a.e", {});
                                      return mesh.cell_fields[1].values == expected.cell_fields[1].values &&
                                             std::isnan(mesh.cell_fields[2].values[0]) &&
                                             mesh.cell_fields[2].values[2] == expected.cell_fields[2].values[2];
                                    },
                                    {.stride = format == NC_NETCDF4 ? 307U : 41U}),
              format == NC_NETCDF4 ? 0 : 3);  // what pads the last value
  }
}

/// Whatever four bytes of the header say, the answer is an Error or a mesh that holds together.
TEST(Exodus, survives_any_number_in_the_header) {
  TemporaryFolder folder;
  small_file().write(folder / "a.e");
  const std::string content = read_file(folder / "a.e");
  int refused = 0, accepted = 0;
  for (std::size_t at = 4; at + 4 <= content.size() && at < 3000; at += 12)
    for (const std::string& number :
         {std::string("\x7f\xff\xff\xff", 4), std::string("\x00\x10\x00\x00", 4), std::string(4, '\0')}) {
      std::string changed = content;
      changed.replace(at, 4, number);
      write_file(folder / "b.e", changed);
      try {
        const CellMesh mesh = read_cells(folder / "b.e", {});
        for (const std::uint64_t node : mesh.cell_nodes) ASSERT_LT(node, mesh.points.size());
        ++accepted;
      } catch (const Error& error) {
        EXPECT_THAT(std::string(error.what()), testing::HasSubstr("b.e"));
        ++refused;
      }
    }
  EXPECT_GT(refused, 60);
  EXPECT_GT(accepted, 60);  // names and the like
}

}  // namespace
}  // namespace rhoray::preprocess
