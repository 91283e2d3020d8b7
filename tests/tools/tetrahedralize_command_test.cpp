#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/base/text.h"
#include "tests/support/conformity.h"
#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct OffBox {
  double lo = 0, hi = 1;
  int facet_count = 12;  ///< fewer leave the box open
};

/// A cube between two corners on the diagonal, as OFF, in triangles.
std::string box_off(const OffBox& box) {
  std::string text = concat("OFF\n8 ", box.facet_count, " 0\n");
  for (int i = 0; i < 8; ++i)
    text += concat(i & 1 ? box.hi : box.lo, " ", i & 2 ? box.hi : box.lo, " ", i & 4 ? box.hi : box.lo, "\n");
  const char* facets[] = {"0 2 3", "0 3 1", "4 5 7", "4 7 6", "0 1 5", "0 5 4",
                          "2 6 7", "2 7 3", "0 4 6", "0 6 2", "1 3 7", "1 7 5"};
  for (int f = 0; f < box.facet_count; ++f) text += concat("3 ", facets[f], "\n");
  return text;
}

/// inner.off inside outer.off, and open.off without one side.
Workbench& with_boxes(Workbench& bench) {
  write_file(bench / "outer.off", box_off({.lo = 0, .hi = 3}));
  write_file(bench / "inner.off", box_off({.lo = 1, .hi = 2}));
  write_file(bench / "open.off", box_off({.lo = 0, .hi = 1, .facet_count = 10}));
  return bench;
}

/// Volume and largest cell volume of a region.
struct RegionSize {
  double volume = 0, largest_cell = 0;
};
std::map<double, RegionSize> region_sizes(const preprocess::NeutralMesh& mesh) {
  std::map<double, RegionSize> sizes;
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
    preprocess::NeutralMesh one;
    one.points = mesh.points;
    one.cells = {mesh.cells[c]};
    const double volume = mesh_volume(one);
    RegionSize& size = sizes[mesh.cell_fields.at(0).values[c]];
    size.volume += volume;
    size.largest_cell = std::max(size.largest_cell, volume);
  }
  return sizes;
}

TEST(TetrahedralizeCommand, makes_regions_of_nested_surfaces_and_limits_one_of_them) {
  Workbench bench;
  const RunResult run = with_boxes(bench).rhoray(
      {"tetrahedralize", "outer.off", "inner.off", "--max-volume", "2:0.01", "-o", "both.vtu", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("facets of inner.off are numbered from 12"));
  const auto sizes = region_sizes(preprocess::import_mesh(bench / "both.vtu"));
  ASSERT_EQ(sizes.size(), 2U);
  EXPECT_NEAR(sizes.at(1).volume, 26, 1e-9);
  EXPECT_NEAR(sizes.at(2).volume, 1, 1e-9);
  EXPECT_LT(sizes.at(2).largest_cell, 0.02) << "smoothing at the end may enlarge some";
  EXPECT_GT(sizes.at(1).largest_cell, 0.02);
  EXPECT_EQ(nlohmann::json::parse(run.out)["cells"], preprocess::import_mesh(bench / "both.vtu").cells.size());
}

TEST(TetrahedralizeCommand, leaves_the_faulty_facets_in_a_file_and_replaces_it_only_with_force) {
  Workbench bench;
  with_boxes(bench);
  const RunResult first = bench.rhoray({"tetrahedralize", "open.off"});
  EXPECT_EQ(first.exit_code, 4);
  EXPECT_THAT(first.err, AllOf(HasSubstr("4 open edges"), HasSubstr("faulty facets are in open.faults.ply"),
                               HasSubstr("--repair fixes")));
  EXPECT_FALSE(std::filesystem::exists(bench / "open.vtu"));
  EXPECT_EQ(preprocess::import_surface(bench / "open.faults.ply").facet_offsets.size(), 5U) << "one for each open edge";

  write_file(bench / "open.faults.ply", "mine");
  const RunResult second = bench.rhoray({"tetrahedralize", "open.off"});
  EXPECT_EQ(second.exit_code, 4);
  EXPECT_THAT(second.err, AllOf(HasSubstr("4 open edges"), HasSubstr("was not changed")));
  EXPECT_EQ(read_file(bench / "open.faults.ply"), "mine");

  const RunResult third = bench.rhoray({"tetrahedralize", "open.off", "--force"});
  EXPECT_EQ(third.exit_code, 4);
  EXPECT_NE(read_file(bench / "open.faults.ply"), "mine");
}

TEST(TetrahedralizeCommand, replaces_no_file_that_it_reads) {
  Workbench bench;
  with_boxes(bench);
  bench.make_box_vtu();
  std::filesystem::create_symlink("inner.off", bench / "inner.vtu");
  std::filesystem::copy(bench / "open.off", bench / "x.off");
  ASSERT_EQ(bench.rhoray({"tetrahedralize", "x.off"}).exit_code, 4);
  const std::map<std::string, std::string> before = bench.contents();
  for (const char* const options :
       {"--size-field box.vtu:height -o box.vtu", "--size-field distance:inner.off:1:2:0.5 -o inner.vtu"}) {
    const RunResult run = bench.shell(std::string("rhoray tetrahedralize outer.off --force ") + options);
    EXPECT_EQ(run.exit_code, 2) << options << run.err;
    EXPECT_THAT(run.err, HasSubstr("is a file of the input; expected another name"));
    EXPECT_TRUE(bench.contents() == before) << options;
  }
  const RunResult faults = bench.shell("rhoray tetrahedralize x.faults.ply -o x.vtu --force");
  EXPECT_EQ(faults.exit_code, 4);
  EXPECT_THAT(faults.err, HasSubstr("x.faults.ply is an input and was not changed"));
  EXPECT_TRUE(bench.contents() == before);
}

TEST(TetrahedralizeCommand, fills_a_hole_however_wide_and_says_so) {
  Workbench bench;
  const RunResult run = with_boxes(bench).rhoray(
      {"tetrahedralize", "open.off", "--repair", "--max-move", "0.001", "-o", "closed.vtu", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("1 hole filled"));
  const nlohmann::json repair = nlohmann::json::parse(run.out)["repair"];
  EXPECT_LE(repair["moved"].get<double>(), repair["distance_error"].get<double>());
  EXPECT_NEAR(mesh_volume(preprocess::import_mesh(bench / "closed.vtu")), 1, 1e-9);
}

/// A prism over an L, beginning at a corner from which no fan covers it; volume 3.
std::string l_prism(bool as_poly) {
  const char* outline[] = {"2 0", "2 1", "1 1", "1 2", "0 2", "0 0"};
  std::string text = as_poly ? "12 3 0 0\n" : "OFF\n12 8 0\n";
  for (int i = 0; i < 12; ++i) text += concat(as_poly ? concat(i, " ") : "", outline[i % 6], i < 6 ? " 0\n" : " 1\n");
  const char* facets[] = {"6 5 4 3 2 1 0", "6 6 7 8 9 10 11", "4 0 1 7 6",   "4 1 2 8 7",
                          "4 2 3 9 8",     "4 3 4 10 9",      "4 4 5 11 10", "4 5 0 6 11"};
  if (as_poly) text += "8 0\n";
  for (const char* facet : facets) text += concat(as_poly ? "1 0\n" : "", facet, "\n");
  return text;
}

/// A box of 3 x 3 x 1 with a tunnel through faces with openings; volume 8.
constexpr const char* tunnel_poly =
    "16 3 0 0\n0 0 0 0\n1 3 0 0\n2 3 3 0\n3 0 3 0\n4 1 1 0\n5 2 1 0\n6 2 2 0\n7 1 2 0\n"
    "8 0 0 1\n9 3 0 1\n10 3 3 1\n11 0 3 1\n12 1 1 1\n13 2 1 1\n14 2 2 1\n15 1 2 1\n"
    "10 0\n2 1\n4 0 1 2 3\n4 4 5 6 7\n1 1.5 1.5 0\n2 1\n4 8 9 10 11\n4 12 13 14 15\n1 1.5 1.5 1\n"
    "1\n4 0 1 9 8\n1\n4 1 2 10 9\n1\n4 2 3 11 10\n1\n4 3 0 8 11\n"
    "1\n4 4 5 13 12\n1\n4 5 6 14 13\n1\n4 6 7 15 14\n1\n4 7 4 12 15\n";

TEST(TetrahedralizeCommand, repairs_polygons_and_openings_without_changing_them) {
  Workbench bench;
  write_file(bench / "l.off", l_prism(false));
  write_file(bench / "l.poly", l_prism(true));
  write_file(bench / "tunnel.poly", tunnel_poly);
  for (const auto& [surface, volume] : {std::pair{"l.off", 3.0}, {"l.poly", 3.0}, {"tunnel.poly", 8.0}}) {
    const RunResult run =
        bench.rhoray({"tetrahedralize", surface, "--repair", "-o", "filled.vtu", "--force", "--json"});
    ASSERT_EQ(run.exit_code, 0) << surface << run.err;
    const nlohmann::json repair = nlohmann::json::parse(run.out)["repair"];
    EXPECT_EQ(repair["crossing_pairs"], 0) << surface;
    EXPECT_EQ(repair["farthest_new_from_old"], 0) << surface;
    EXPECT_EQ(repair["farthest_old_from_new"], 0) << surface;
    EXPECT_NEAR(mesh_volume(preprocess::import_mesh(bench / "filled.vtu")), volume, 1e-9) << surface;
  }
}

TEST(TetrahedralizeCommand, notes_that_a_repair_does_not_use_the_sizes_beside_the_surface) {
  Workbench bench;
  with_boxes(bench);
  write_file(bench / "outer.mtr", "8 1\n1\n1\n1\n1\n1\n1\n1\n1\n");
  const auto cell_count = [&](const std::vector<std::string>& options, const char* note) {
    std::vector<std::string> words{"tetrahedralize", "outer.off", "-o", "filled.vtu", "--force", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const RunResult run = bench.rhoray(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err.find("(.mtr) are not used") != run.err.npos, note != std::string()) << run.err;
    EXPECT_THAT(run.err, HasSubstr(note));
    return nlohmann::json::parse(run.out).at("cells").get<std::size_t>();
  };
  const std::size_t sized = cell_count({}, "");
  const std::size_t repaired = cell_count({"--repair"}, "(.mtr) are not used: --repair changes the points");
  const std::size_t wrapped = cell_count({"--wrap", "0.3"}, "(.mtr) are not used: --wrap changes the points");
  std::filesystem::remove(bench / "outer.mtr");
  EXPECT_EQ(repaired, cell_count({"--repair"}, ""));
  EXPECT_EQ(wrapped, cell_count({"--wrap", "0.3"}, ""));
  EXPECT_GT(sized, cell_count({}, "")) << "do the sizes still make a difference?";
}

TEST(TetrahedralizeCommand, refuses_before_it_begins_what_makes_no_sense) {
  Workbench bench;
  with_boxes(bench);
  bench.make_box_vtu();
  bench.make_ball_raw();
  const auto refused = [&](const std::string& options, int exit_code, const std::string& words) {
    const RunResult run = bench.shell("rhoray tetrahedralize outer.off " + options);
    EXPECT_EQ(run.exit_code, exit_code) << options;
    EXPECT_THAT(run.err, HasSubstr(words)) << options;
    EXPECT_FALSE(std::filesystem::exists(bench / "outer.vtu")) << options;
  };
  refused("--max-volume 1:2:3", 2, "expected V or REGION:V");
  refused("--max-volume 1:x", 2, "--max-volume: ");
  refused("--max-volume 1:-1", 2, "--max-volume");
  refused("--max-volume 1:0.5,", 2, "--max-volume: ");
  refused("--max-volume 7:0.5", 2, "has no region 7 whose volume could be limited; it has 1");
  refused("--size-field distance:inner.off:1:2", 2, "expected distance:SURFACE:NEAR:FAR:GROWTH");
  refused("--size-field distance:inner.off:1:2:x", 2, "--size-field: ");
  refused("--size-field distance:inner.off:2:1:0.1", 2, "expected 0 < near <= far");
  refused("--size-field distance:box.vtu:1:2:0.1", 7, "box.vtu: is not a surface");
  refused("--size-field inner.off", 2, "is neither a volume nor a mesh");
  refused("--size-field box.vtu", 2, "has 2 scalar point fields; expected one, or FILE:FIELD");
  refused("--size-field box.vtu:hight", 2, "did you mean height?");
  refused("--size-field gone.vtu", 3, "gone.vtu");
  refused("--max-move 0.1", 2, "--max-move: needs --repair; found no --repair");
  refused("--wrap 0.1 --max-move 0.1", 2, "--max-move: needs --repair; found --wrap");
  refused("--repair --max-move 2", 2, "--max-move");
  refused("--largest-part", 2, "--largest-part: needs --repair");
  refused("--time-limit 0", 2, "--time-limit");
  refused("inner.off --sizes outer.off", 2, "found several");
  refused("--repair --sizes inner.off", 2, "--sizes: cannot be combined with --repair");
  refused("--wrap 0.1 --sizes inner.off", 2, "--sizes: cannot be combined with --wrap");
  refused("ball.raw", 7, "ball.raw: is not a surface");
  refused("-o x.msh", 2, "expected .vtu");
}

}  // namespace
}  // namespace rhoray::tests
