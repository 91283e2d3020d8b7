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
  refused("ball.raw", 7, "ball.raw: is not a surface");
  refused("-o x.msh", 2, "expected .vtu");
}

}  // namespace
}  // namespace rhoray::tests
