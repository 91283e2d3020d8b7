// Volumes in XDMF files: the expected ones are those that the same numbers give as VTI and VTR.
#include <map>
#include <numeric>
#include <random>

#include "preprocess/import/readers.h"
#include "preprocess/import/reading/grid_cover.h"
#include "tests/preprocess/import/support.h"
#include "tests/preprocess/import/xdmf_files.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using formats::ElementType;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class XdmfVolume : public testing::Test {
 protected:
  NeutralVolume read(const std::string& content, const std::string& field = {}, const std::string& time = {}) {
    write_file(folder_ / "a.xdmf", content);
    return read_volume(folder_ / "a.xdmf", {.raw = {}, .field = field, .time = time});
  }
  NeutralVolume read_vtk(const char* name, const std::string& content) {
    write_file(folder_ / name, content);
    return read_volume(folder_ / name, {});
  }

  TemporaryFolder folder_;
};

void expect_same(const NeutralVolume& found, const NeutralVolume& expected) {
  EXPECT_EQ(found.sample_count, expected.sample_count);
  EXPECT_EQ(found.type, expected.type);
  EXPECT_EQ(values_of(found), values_of(expected));
  expect_map(found.world_from_grid, expected.world_from_grid, 0);
  EXPECT_EQ(found.axes, expected.axes);
  EXPECT_EQ(found.field_name, expected.field_name);
}

std::string lattice(const std::string& sizes, const std::string& origin, const std::string& spacing) {
  return concat("<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"", sizes, "\"/>\n") +
         geometry(item("3", origin) + item("3", spacing), "ORIGIN_DXDYDZ");
}

std::string tables(const std::string& sizes, const std::string& x, const std::string& y, const std::string& z) {
  const auto axis = [](const std::string& words) {
    return item(concat(1 + std::count(words.begin(), words.end(), ' ')), words, "Precision=\"8\"");
  };
  return concat("<Topology TopologyType=\"3DRectMesh\" NumberOfElements=\"", sizes, "\"/>\n") +
         geometry(axis(x) + axis(y) + axis(z), "VXVYVZ");
}

TEST_F(XdmfVolume, of_an_even_grid_is_that_of_vti) {
  const NeutralVolume expected = read_vtk(
      "a.vti",
      "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 2 0 3 0 4\" "
      "Origin=\"1 2 3\" Spacing=\"0.5 0.25 2\"><Piece Extent=\"0 2 0 3 0 4\"><PointData><DataArray type=\"Float32\" "
      "Name=\"a\" format=\"ascii\">" +
          values_in_text() + "</DataArray></PointData></Piece></ImageData></VTKFile>");
  // sizes, origin and spacing in the order z, y, x
  const std::string even = lattice("5 4 3", "3 2 1", "2 0.25 0.5");
  expect_same(read(xdmf(grid("a", even + attribute("a", item("5 4 3", values_in_text(), "Precision=\"4\""))))),
              expected);
  {
    const Hdf5Writer file(folder_ / "a.h5");
    file.array("a", H5T_IEEE_F32BE, {5, 4, 3}, known_values<double>(), {2, 4, 3});
  }
  expect_same(read(xdmf(grid("a", even + attribute("a", item("5 4 3", "a.h5:/a", "Format=\"HDF\""))))), expected);
}

TEST_F(XdmfVolume, of_an_uneven_grid_is_that_of_vtr) {
  const auto axis = [](const char* numbers) {
    return concat("<DataArray type=\"Float64\" Name=\"x\" format=\"ascii\">", numbers, "</DataArray>");
  };
  const NeutralVolume expected =
      read_vtk("a.vtr",
               "<VTKFile type=\"RectilinearGrid\" version=\"0.1\"><RectilinearGrid WholeExtent=\"0 2 0 3 0 4\"><Piece "
               "Extent=\"0 2 0 3 0 4\"><PointData><DataArray type=\"Int32\" Name=\"a\" format=\"ascii\">" +
                   values_in_text() + "</DataArray></PointData><Coordinates>" + axis("0 1 3") + axis("0 1 2 5") +
                   axis("0 1 2 3 9") + "</Coordinates></Piece></RectilinearGrid></VTKFile>");
  const std::string values = attribute("a", item("5 4 3", values_in_text(), "NumberType=\"Int\""));
  // XDMF 3's library writes sizes as x, y, z here
  for (const char* sizes : {"5 4 3", "3 4 5"})
    expect_same(read(xdmf(grid("a", tables(sizes, "0 1 3", "0 1 2 5", "0 1 2 3 9") + values))), expected);
}

TEST_F(XdmfVolume, takes_cells_vectors_and_tensors_by_the_common_rule) {
  std::vector<int> numbers(48);
  std::iota(numbers.begin(), numbers.end(), 0);
  const std::string content =
      xdmf(grid("a", lattice("3 3 3", "0 0 0", "1 1 1") +
                         attribute("v", item("2 2 2 3", in_words(std::vector<int>(24, 2))), "Cell", "Vector") +
                         attribute("t", item("2 2 2 6", in_words(numbers)), "Cell", "Tensor6")));
  const NeutralVolume mag = read(content);
  EXPECT_EQ(mag.field_name, "v.mag");
  EXPECT_EQ(mag.sample_count, Index3(2, 2, 2));
  expect_near(mag.world_from_grid.origin, {0.5, 0.5, 0.5});
  EXPECT_NEAR(values_of(mag)[0], std::sqrt(12.0), 1e-6);
  // the second number of the file is xy, the fourth yy
  EXPECT_EQ(values_of(read(content, "t.xy"))[1], 7);
  EXPECT_EQ(values_of(read(content, "t.yy"))[1], 9);
}

TEST_F(XdmfVolume, has_time_steps_and_takes_the_first_by_default) {
  const auto step = [](const char* time, const char* value) {
    return grid("s", concat("<Time Value=\"", time, "\"/>\n") + lattice("2 2 2", "0 0 0", "1 1 1") +
                         attribute("a", item("2 2 2", in_words(std::vector<std::string>(8, value)))));
  };
  const std::string content = xdmf(collection("c", "Temporal", step("1", "10") + step("2", "20")));
  EXPECT_EQ(values_of(read(content))[0], 10);
  EXPECT_THAT(read(content).notes, ElementsAre("using the first of 2 time steps; choose another with --time"));
  EXPECT_EQ(values_of(read(content, "", "last"))[0], 20);
  EXPECT_EQ(values_of(read(content, "", "2"))[0], 20);
}

/// Blocks of 2 x 2 x 2 cells of a grid of 4 x 4 x 2, as Athena writes them; a value tells its
/// place.
std::string block(int x, int y, bool even, const std::string& name = "a") {
  std::string points, cells;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        points += concat(x + i + 10 * (y + j) + 100 * k, " ");
        if (i < 2 && j < 2 && k < 2) cells += concat(x + i + 10 * (y + j) + 100 * k, " ");
      }
  const auto three = [](int first) { return concat(0.1 * first, " ", 0.1 * (first + 1), " ", 0.1 * (first + 2)); };
  // an origin of six digits does not meet the last point of the block before
  const auto third = [](int first) { return first == 0 ? "0" : "0.666667"; };
  return grid("block", (even ? lattice("3 3 3", concat("0 ", third(y), " ", third(x)), "0.333333 0.333333 0.333333")
                             : tables("3 3 3", three(x), three(y), "0 0.1 0.2")) +
                           attribute(name, item("2 2 2", cells, "NumberType=\"Int\""), "Cell") +
                           attribute("p", item("3 3 3", points, "NumberType=\"Int\"")));
}

TEST_F(XdmfVolume, joins_blocks_that_make_one_grid) {
  for (const bool even : {false, true}) {
    const std::string content =
        xdmf(collection("c", "Spatial", block(2, 2, even) + block(0, 0, even) + block(0, 2, even) + block(2, 0, even)));
    const NeutralVolume cells = read(content, "a"), points = read(content, "p");
    EXPECT_EQ(cells.sample_count, Index3(4, 4, 2));
    EXPECT_EQ(points.sample_count, Index3(5, 5, 3));
    const std::vector<double> in_cells = values_of(cells), at_points = values_of(points);
    for (int i = 0; i < 32; ++i)
      EXPECT_EQ(in_cells[static_cast<std::size_t>(i)], i % 4 + 10 * (i / 4 % 4) + 100 * (i / 16));
    for (int i = 0; i < 75; ++i)
      EXPECT_EQ(at_points[static_cast<std::size_t>(i)], i % 5 + 10 * (i / 5 % 5) + 100 * (i / 25));
    const double step = even ? 1.0 / 3 : 0.1;
    expect_map(points.world_from_grid, axis_parallel_map({step, step, step}, {0, 0, 0}), even ? 1e-6 : 1e-12);
    EXPECT_TRUE(points.axes[0].empty());
  }
}

TEST_F(XdmfVolume, refuses_blocks_that_do_not_make_one_grid) {
  const auto refuses = [&](const std::string& blocks, ErrorCode code, const std::vector<std::string>& words) {
    expect_refusal([&] { read(xdmf(collection("c", "Spatial", blocks))); }, code, words);
  };
  refuses(block(0, 0, true) + block(2, 0, true) + block(0, 2, true), ErrorCode::unsupported, {"3 that leave a gap"});
  refuses(block(0, 0, true) + block(0, 0, true), ErrorCode::unsupported,
          {"a.xdmf, blocks: found 2 that leave a gap or overlap"});
  refuses(block(0, 0, false) + block(1, 0, false), ErrorCode::unsupported, {"overlap"});
  const std::string coarse = grid("b", tables("2 2 2", "0.2 0.4", "0 0.2", "0 0.2") +
                                           attribute("a", item("1 1 1", "1", "NumberType=\"Int\""), "Cell") +
                                           attribute("p", item("2 2 2", "1 2 3 4 5 6 7 8", "NumberType=\"Int\"")));
  refuses(block(0, 0, false) + coarse, ErrorCode::unsupported, {"blocks along y", "different resolution"});
  refuses(block(0, 0, true) + block(2, 0, true, "b"), ErrorCode::invalid, {"Grid: found other attributes"});
  refuses(block(0, 0, true) + grid("mesh", tet_cells + tet_points), ErrorCode::unsupported,
          {"Topology: found the type 'tetrahedron'", "3DRectMesh"});
}

TEST_F(XdmfVolume, refuses_grids_that_do_not_fit_their_numbers) {
  const std::string values = attribute("a", item("2 2 2", "1 2 3 4 5 6 7 8"));
  const std::string even = lattice("2 2 2", "0 0 0", "1 1 1");
  const struct {
    std::string content;
    std::vector<std::string> words;
  } lies[] = {
      {lattice("2 2 3", "0 0 0", "1 1 1") + values, {"found 8 numbers of attribute 'a'", "for each of 12 points"}},
      {lattice("1000000 1000000 1000000", "0 0 0", "1 1 1") + values, {"for each of 1000000000000000000 points"}},
      {lattice("4294967296 4294967296 1", "0 0 0", "1 1 1") + values, {"a.xdmf, line 6, Topology", "fits in memory"}},
      {lattice("2 0 2", "0 0 0", "1 1 1") + values, {"a size of 0"}},
      {lattice("2 2", "0 0 0", "1 1 1") + values, {"found 2 sizes in Dimensions; expected 3: z, y, x"}},
      {lattice("2 2 2", "0 0 0", "1 1 0") + values, {"a spacing of 0"}},
      {lattice("2 2 2", "0 0 nan", "1 1 1") + values, {"finite numbers"}},
      {"<Topology TopologyType=\"3DCoRectMesh\" Dimensions=\"2 2 2\"/>\n" +
           geometry(item("2", "0 0") + item("3", "1 1 1"), "ORIGIN_DXDYDZ") + values,
       {"found 2 numbers; expected 3: z, y, x"}},
      {tables("2 2 2", "0 1 2", "0 1", "0 1") + values, {"found 2 x 2 x 3 positions"}},
      {tables("2 2 2", "0 0", "0 1", "0 1") + values, {"x coordinate 1", "rise, or fall"}},
      {even, {"Grid: found no Attribute"}},
      {even + attribute("a", item("8", "1 2 3 4 5 6 7 8"), "Cell", "Vector") +
           attribute("b", item("3", "1 2 3"), "Cell"),
       {"found 3 numbers for each cell; expected 1, as a scalar has"}},
  };
  for (const auto& lie : lies)
    expect_refusal([&] { read(xdmf(grid("a", lie.content))); }, ErrorCode::invalid, lie.words);
}

TEST(GridCover, agrees_with_counting_each_cell) {
  std::mt19937_64 random(7);
  const auto below = [&](std::int64_t count) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(count));
  };
  int covered = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const GridExtent whole{{2, -1, 0}, {4, 1, trial % 2}};
    std::vector<GridExtent> parts;
    // the whole, cut in two at random some times; then perhaps one part moves
    parts.push_back(whole);
    for (std::int64_t cuts = below(4); cuts > 0; --cuts) {
      GridExtent& first = parts[static_cast<std::size_t>(below(std::ssize(parts)))];
      const int axis = static_cast<int>(below(3));
      const std::int64_t steps = first.last[axis] - first.first[axis];
      if (steps < 2) continue;
      GridExtent second = first;
      first.last[axis] = second.first[axis] = first.first[axis] + 1 + below(steps - 1);
      parts.push_back(second);
    }
    if (below(2) == 0) {
      GridExtent& moved = parts[static_cast<std::size_t>(below(std::ssize(parts)))];
      const int axis = static_cast<int>(below(3));
      const std::int64_t by = below(3) - 1;
      (below(2) == 0 ? moved.first : moved.last)[axis] += by;
      if (moved.last[axis] < moved.first[axis]) continue;
    }
    std::map<std::array<std::int64_t, 3>, int> times;
    bool is_inside = true;
    for (const GridExtent& part : parts) {
      const Index3 size = owner_count(part, true);
      for (int axis = 0; axis < 3; ++axis)
        is_inside = is_inside && part.first[axis] >= whole.first[axis] && part.last[axis] <= whole.last[axis] &&
                    part.first[axis] + size[axis] <= whole.first[axis] + owner_count(whole, true)[axis];
      for (std::int64_t i = 0; i < volume(size); ++i)
        ++times[{part.first.x + i % size.x, part.first.y + i / size.x % size.y, part.first.z + i / size.x / size.y}];
    }
    const bool is_covered = is_inside && std::ssize(times) == volume(owner_count(whole, true)) &&
                            std::all_of(times.begin(), times.end(), [](const auto& cell) { return cell.second == 1; });
    EXPECT_EQ(cover_once(whole, parts), is_covered) << trial;
    covered += is_covered ? 1 : 0;
  }
  EXPECT_GT(covered, 1000);
  EXPECT_LT(covered, 3500);
}

}  // namespace
}  // namespace rhoray::preprocess
