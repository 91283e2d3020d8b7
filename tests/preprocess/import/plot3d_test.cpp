#include <cstdlib>

#include "preprocess/import/mesh/plot3d_layout.h"
#include "preprocess/import/readers.h"
#include "preprocess/input_file.h"
#include "tests/preprocess/import/vtk_cells.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::ElementsAre;
using testing::HasSubstr;

/// How a pair of files is written here. Blocks of 3 x 2 x 2 points, bent, one behind the other
/// along x.
struct Style {
  bool is_text = false, is_big_endian = false, has_records = false, has_block_count = false, has_iblank = false;
  bool is_double = false;
  std::size_t blocks = 1;

  std::string words() const {
    return concat(is_text ? "text" : "binary", is_big_endian ? " big" : " little", has_records ? " records" : "",
                  has_block_count ? " counted" : "", has_iblank ? " iblank" : "", is_double ? " 64" : " 32", " blocks ",
                  blocks);
  }
};

constexpr std::size_t points_per_block = 12;

double place(std::size_t block, std::size_t point, int axis) {
  const std::size_t i = point % 3, j = point / 3 % 2, k = point / 6;
  return axis == 0   ? static_cast<double>(2 * block + i)
         : axis == 1 ? static_cast<double>(j) + 0.25 * static_cast<double>(k)
                     : static_cast<double>(k);
}

/// Along x the same whichever block it is asked of; q counts density, momentum, energy.
double value(std::size_t block, std::size_t point, int q) {
  return 100 * q + 10 * place(block, point, 0) + 4 * place(block, point, 1) + place(block, point, 2);
}

class Writer {
 public:
  explicit Writer(const Style& style) : style_(style) {}

  void begin() { record_.clear(); }
  void add(double number, bool is_integer = false) {
    if (style_.is_text)
      record_ += concat(number, is_integer ? "" : "e0", "\n");
    else if (is_integer)
      append(static_cast<std::int32_t>(number));
    else if (style_.is_double)
      append(number);
    else
      append(static_cast<float>(number));
  }
  void end() {
    const auto length = static_cast<std::int32_t>(record_.size());
    const bool marks = style_.has_records && !style_.is_text;
    const std::string marker = marks ? bytes_of_values(std::vector{length}, style_.is_big_endian) : "";
    content_ += marker + record_ + marker;
  }
  const std::string& content() const { return content_; }

 private:
  template <class T>
  void append(T number) {
    record_ += bytes_of_values(std::vector{number}, style_.is_big_endian);
  }

  const Style& style_;
  std::string record_, content_;
};

void add_header(Writer& writer, const Style& style) {
  if (style.has_block_count) {
    writer.begin();
    writer.add(static_cast<double>(style.blocks), true);
    writer.end();
  }
  writer.begin();
  for (std::size_t block = 0; block < style.blocks; ++block)
    for (const int size : {3, 2, 2}) writer.add(size, true);
  writer.end();
}

/// Point 2 of the first block is blanked, the others are 1, 2, -3 in turn.
int blank(std::size_t block, std::size_t point) {
  return block == 0 && point == 2 ? 0 : std::array{1, 2, -3}[point % 3];
}

std::string grid_file(const Style& style) {
  Writer writer(style);
  add_header(writer, style);
  for (std::size_t block = 0; block < style.blocks; ++block) {
    writer.begin();
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < points_per_block; ++i) writer.add(place(block, i, axis));
    for (std::size_t i = 0; style.has_iblank && i < points_per_block; ++i) writer.add(blank(block, i), true);
    writer.end();
  }
  return writer.content();
}

std::string solution_file(const Style& style) {
  Writer writer(style);
  add_header(writer, style);
  for (std::size_t block = 0; block < style.blocks; ++block) {
    writer.begin();
    for (const double condition : {0.5, 2.0, 1000.0, 3.0}) writer.add(condition);
    writer.end();
    writer.begin();
    for (int q = 0; q < 5; ++q)
      for (std::size_t i = 0; i < points_per_block; ++i) writer.add(value(block, i, q));
    writer.end();
  }
  return writer.content();
}

std::vector<Style> styles() {
  std::vector<Style> all;
  for (const bool has_block_count : {false, true})
    for (const bool has_iblank : {false, true})
      for (const std::size_t blocks : {1U, 2U}) {
        if (blocks > 1 && !has_block_count) continue;
        Style style{.has_block_count = has_block_count, .has_iblank = has_iblank, .blocks = blocks};
        for (style.is_big_endian = false;; style.is_big_endian = true) {
          for (const bool has_records : {false, true})
            for (const bool is_double : {false, true}) {
              style.has_records = has_records;
              style.is_double = is_double;
              all.push_back(style);
            }
          if (style.is_big_endian) break;
        }
        all.push_back(
            {.is_text = true, .has_block_count = has_block_count, .has_iblank = has_iblank, .blocks = blocks});
      }
  return all;
}

void expect_blocks(const CellMesh& mesh, const Style& style, bool has_solution = true) {
  // Two blocks have the four points of a face in common, once without field and once with equal
  // values.
  ASSERT_EQ(mesh.points.size(), style.blocks * points_per_block - (style.blocks - 1) * 4);
  for (std::size_t i = 0; i < points_per_block; ++i)
    EXPECT_EQ(mesh.points[i], (std::array{place(0, i, 0), place(0, i, 1), place(0, i, 2)}));
  ASSERT_EQ(mesh.kinds.size(), 2 * style.blocks - (style.has_iblank ? 1 : 0));
  EXPECT_EQ(nodes_of(mesh, 0), (std::vector<std::uint64_t>{0, 1, 4, 3, 6, 7, 10, 9}));
  if (style.has_iblank && style.blocks == 2) {
    EXPECT_THAT(mesh.cell_ids, ElementsAre(0, 2, 3));
  }
  const auto field = [&](const std::string& name) -> const NeutralField* {
    for (const NeutralField& one : mesh.point_fields)
      if (one.name == name) return &one;
    return nullptr;
  };
  const NeutralField* iblank = field("IBlank");
  ASSERT_EQ(iblank != nullptr, style.has_iblank);
  if (iblank != nullptr) {
    EXPECT_EQ(iblank->values[2], 0);
    EXPECT_EQ(iblank->values[5], -3);
  }
  if (!has_solution) return;
  const NeutralField *density = field("Density"), *momentum = field("Momentum"), *energy = field("StagnationEnergy");
  ASSERT_TRUE(density != nullptr && momentum != nullptr && energy != nullptr);
  EXPECT_EQ(momentum->component_count, 3);
  EXPECT_EQ(density->was_single_precision, !style.is_double || style.is_text);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const auto& [x, y, z] = mesh.points[i];
    const double base = 10 * x + 4 * y + z;
    EXPECT_EQ(density->values[i], base);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(momentum->values[3 * i + axis], base + 100 * (static_cast<double>(axis) + 1));
    EXPECT_EQ(energy->values[i], base + 400);
  }
}

TEST(Plot3d, reads_every_way_of_writing_it) {
  TemporaryFolder folder;
  const std::vector<Style> all = styles();
  EXPECT_EQ(all.size(), 54U);
  for (const Style& style : all) {
    SCOPED_TRACE(style.words());
    write_file(folder / "postxyz.bin", grid_file(style));
    write_file(folder / "postq.bin", solution_file(style));
    for (const char* name : {"postxyz.bin", "postq.bin"}) {  // either of the two leads to the other
      EXPECT_EQ(plot3d_layouts(ForeignFile(folder / name)).size(), 1U);
      EXPECT_EQ(foreign_kind(folder / name), ForeignKind::mesh);
      const CellMesh mesh = read_cells(folder / name, {});
      expect_blocks(mesh, style);
      EXPECT_THAT(mesh.notes, testing::Contains(HasSubstr("Mach number 0.5, angle of attack 2, Reynolds number 1000")));
    }
  }
}

TEST(Plot3d, finds_the_other_file_by_its_name) {
  TemporaryFolder folder;
  const Style style;
  for (const auto& [grid, solution] : std::vector<std::pair<std::string, std::string>>{
           {"a.xyz", "a.q"}, {"b.x", "b.q"}, {"c.g", "c.q"}, {"d.p3d", "d.q"}, {"exyz.p3d", "eq.p3d"}}) {
    SCOPED_TRACE(grid);
    write_file(folder / grid, grid_file(style));
    const CellMesh alone = read_cells(folder / grid, {});
    expect_blocks(alone, style, false);
    EXPECT_THAT(alone.notes, ElementsAre(HasSubstr("no solution file found; looked for " + solution)));
    write_file(folder / solution, solution_file(style));
    expect_blocks(read_cells(folder / grid, {}), style);
    expect_blocks(read_cells(folder / solution, {}), style);
    std::filesystem::remove(folder / grid);
    expect_refusal([&folder, &name = solution] { read_cells(folder / name, {}); }, ErrorCode::unreadable,
                   {solution, "no grid beside it"});
  }
}

TEST(Plot3d, counts_cells_with_blanked_corners) {
  TemporaryFolder folder;
  write_file(folder / "a.xyz", grid_file({.has_iblank = true}));
  EXPECT_THAT(read_cells(folder / "a.xyz", {}).notes,
              testing::Contains(HasSubstr("1 cell with a hidden point left out")));
}

TEST(Plot3d, refuses_every_beginning_and_what_is_longer) {
  TemporaryFolder folder;
  // Without records a grid with IBLANK that is cut right before it is a grid without: nobody can
  // notice.
  for (const Style& style : {Style{}, Style{.has_records = true, .has_iblank = true}}) {
    const std::string content = grid_file(style);
    EXPECT_EQ(check_every_beginning(folder / "a.xyz", content,
                                    [&] { return read_cells(folder / "a.xyz", {}).kinds.empty(); }),
              0);
    for (const char* more : {"x", "1234", "12345678"}) {
      write_file(folder / "a.xyz", content + more);
      expect_refusal([&] { read_cells(folder / "a.xyz", {}); }, ErrorCode::invalid, {"a.xyz, size", "fit no layout"});
      EXPECT_EQ(foreign_kind(folder / "a.xyz"), ForeignKind::unknown);
    }
  }
  const std::string text = grid_file({.is_text = true});
  check_every_beginning(folder / "a.xyz", text, [&] { return read_cells(folder / "a.xyz", {}).kinds.size() == 2; },
                        {.stride = 5, .is_text = true});
}

TEST(Plot3d, passes_over_zeros_up_to_a_multiple_of_512_bytes) {
  TemporaryFolder folder;
  const Style style{.is_big_endian = true, .has_block_count = true, .blocks = 40};
  const std::string content = grid_file(style);
  const std::size_t missing = 512 - content.size() % 512;
  write_file(folder / "a.xyz", content + std::string(missing, '\0'));
  expect_blocks(read_cells(folder / "a.xyz", {}), style, false);
  const auto refuses = [&](const std::string& padding) {
    write_file(folder / "a.xyz", content + padding);
    expect_refusal([&] { read_cells(folder / "a.xyz", {}); }, ErrorCode::invalid, {"fit no layout"});
  };
  refuses(std::string(missing - 1, '\0'));
  refuses(std::string(missing + 1024, '\0'));
  refuses(std::string(missing, ' '));
}

TEST(Plot3d, refuses_sizes_that_are_not_those_of_the_grid) {
  TemporaryFolder folder;
  write_file(folder / "a.xyz", grid_file({}));
  write_file(folder / "a.q", solution_file({.has_block_count = true, .blocks = 2}));
  expect_refusal([&] { read_cells(folder / "a.xyz", {}); }, ErrorCode::invalid,
                 {"a.q, header", "1 more block", "a.xyz"});
  write_file(folder / "a.q", grid_file({}));
  expect_refusal([&] { read_cells(folder / "a.xyz", {}); }, ErrorCode::invalid,
                 {"a.q, size", "expected a PLOT3D solution"});
}

TEST(Plot3d, refuses_one_layer_attacks_on_counts_and_other_files) {
  TemporaryFolder folder;
  const auto path = folder / "a.bin";
  const auto refuses = [&](const std::string& content, ErrorCode error_code, const std::vector<std::string>& words) {
    write_file(path, content);
    expect_refusal([&] { read_cells(path, {}); }, error_code, words);
  };
  const auto integers = [](const std::vector<std::int32_t>& numbers) { return bytes_of_values(numbers); };
  refuses(integers({4, 5, 1}) + std::string(20 * 12, '\0'), ErrorCode::unsupported, {"4 x 5 x 1 points", "one layer"});
  refuses(integers({2147483647, 2147483647, 2147483647}) + "0123", ErrorCode::invalid, {"fit no layout"});
  refuses(integers({0, 5, 5}), ErrorCode::invalid, {"fit no layout"});
  refuses(integers({-1, -1, -1}) + std::string(12, '\0'), ErrorCode::invalid, {"fit no layout"});
  refuses(integers({2147483647, 2, 2, 2}), ErrorCode::invalid, {"fit no layout"});
  refuses(std::string(1000, '\0'), ErrorCode::invalid, {"1000 bytes that fit no layout"});
  refuses("a molecule of three atoms\n", ErrorCode::invalid, {"fit no layout"});
  refuses("2 2 2 999999999999*1.5 18446744073709551615*2\n", ErrorCode::invalid, {"fit no layout"});
  refuses("1000000 1000000 1 3000000000000*0\n", ErrorCode::invalid, {"fit no layout"});
  refuses("2 2 2 8*0 8*1 8*x\n", ErrorCode::invalid, {"fit no layout"});
  refuses("", ErrorCode::invalid, {"an empty file"});
  EXPECT_EQ(foreign_kind(path), ForeignKind::unknown);
  EXPECT_EQ(foreign_kind(folder / "none.bin"), ForeignKind::unknown);
}

TEST(Plot3d, reads_fortran_s_repetitions_and_exponents) {
  TemporaryFolder folder;
  write_file(folder / "a.xyz", "2 2 2\n0 1, 0 1 0 1 0 1\n 2*0 2*1.5D+1 2*0 2*15.\n4*0, 4*-25d-1\n");
  const CellMesh mesh = read_cells(folder / "a.xyz", {});
  EXPECT_EQ(mesh.points[7], (std::array{1.0, 15.0, -2.5}));
  EXPECT_EQ(mesh.points[4], (std::array{0.0, 0.0, -2.5}));
}

/// One block of 2 x 2 x 7 points with IBLANK takes 12 + 28 * 16 bytes, two of 2 x 7 x 2 and 2 x 2 x
/// 2 without it 28 + 36 * 12: as many, and the sizes can be read in both ways.
TEST(Plot3d, names_the_candidates_where_several_layouts_fit) {
  TemporaryFolder folder;
  const std::string sizes = bytes_of_values(std::vector<std::int32_t>{2, 2, 7, 2, 2, 2, 2});
  write_file(folder / "a.xyz", sizes + std::string(460 - sizes.size(), '\0'));
  expect_refusal([&] { read_cells(folder / "a.xyz", {}); }, ErrorCode::unsupported,
                 {"2 layouts that fit", "a grid of 2 x 2 x 7 points, 32 bits, little-endian, IBLANK; or",
                  "a grid of 2 x 7 x 2 points and 1 more block, 32 bits, little-endian, with a block count"});
}

}  // namespace
}  // namespace rhoray::preprocess
