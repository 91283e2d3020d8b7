#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/made_grid.h"
#include "tests/tools/workbench.h"

// Tests info, verify, pack and render with grids of several fields, positions along axes, and
// omitted bricks.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;

float ramp(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<float>(i + 10 * j + 100 * k);
}
float half(std::int64_t i, std::int64_t j, std::int64_t k) {
  return i < 4 ? std::numeric_limits<float>::quiet_NaN() : ramp(i, j, k);
}
float below_zero(std::int64_t i, std::int64_t j, std::int64_t k) {
  return -half(i, j, k);
}

/// all.rho: sparse, uneven along x, two fields, the second with a certificate.
void make_grid_with_all(const Workbench& bench) {
  MadeGrid grid = made_grid({.is_sparse = true, .axes = {{{-1, 0, 0.5, 0.75, 2, 3, 4, 5, 100}, {}, {}}}},
                            {{"density", half}, {"pressure", below_zero, true}});
  grid.description.world_from_grid = {{2, 0, 0}, {0, 3, 0}, {0, 0, 4}, {10, 20, 30}};
  grid.description.fields[1].unit = "Pa";
  write_file(bench / "all.rho", grid.file());
}

/// two.vti: 6 x 5 x 4 samples at the points, 'east' = i and 'up' = 10 k.
void make_two_fields(const Workbench& bench) {
  std::string east, up;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 6; ++i) {
        east += concat(i, " ");
        up += concat(10 * k, " ");
      }
  write_file(bench / "two.vti", concat(R"(<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">
<ImageData WholeExtent="0 5 0 4 0 3" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 5 0 4 0 3"><PointData>
<DataArray type="Float32" Name="east" format="ascii">)",
                                       east, R"(</DataArray>
<DataArray type="Int16" Name="up" format="ascii">)",
                                       up, "</DataArray>\n</PointData></Piece></ImageData></VTKFile>\n"));
}

TEST(GridOfAllKinds, info_tells_of_every_field_of_spacing_of_bricks_and_of_the_certificate) {
  const Workbench bench;
  make_grid_with_all(bench);
  const RunResult result = bench.rhoray({"info", "all.rho", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["format_version"], "1.1");
  ASSERT_EQ(json["fields"].size(), 2U);
  EXPECT_EQ(json["fields"][0]["name"], "density");
  EXPECT_FALSE(json["fields"][0].contains("certificate"));
  EXPECT_EQ(json["fields"][1]["certificate"]["max_error"], 0.5);
  EXPECT_EQ(json["fields"][1]["certificate"]["max_at"], nlohmann::json({1.0, 2.0, 3.0}));
  EXPECT_EQ(json["fields"][1]["certificate"]["point_count"], 12345);
  EXPECT_EQ(json["geometry"]["spacing_range"],
            (nlohmann::json{nlohmann::json({0.5, 190.0}), nlohmann::json({3.0, 3.0}), nlohmann::json({4.0, 4.0})}));
  EXPECT_EQ(json["geometry"]["spacing"], nlohmann::json({2 * 101.0 / 8, 3.0, 4.0}));
  EXPECT_EQ(json["geometry"]["origin"], nlohmann::json({8.0, 20.0, 30.0}));
  EXPECT_EQ(json["box"]["high"], nlohmann::json({210.0, 35.0, 46.0}));
  EXPECT_EQ(json["layout"]["sparse"], true);
  EXPECT_EQ(json["layout"]["stored_bricks"], 8);
  EXPECT_EQ(json["layout"]["bricks"], 12);

  const RunResult text = bench.rhoray({"info", "all.rho", "-v"});
  for (const char* words : {"'density'", "'pressure'", "0.5 to 190 x 3 x 4 mm", "8 of 12 bricks of 4^3 samples",
                            "certified at 12,345 points: error at most 0.5 Pa at (1 2 3), rms 0.1 Pa"})
    EXPECT_THAT(text.out, HasSubstr(words));
}

TEST(GridOfAllKinds, passes_the_deep_check_and_is_found_out_when_its_errors_lie) {
  const Workbench bench;
  make_grid_with_all(bench);
  const RunResult sound = bench.rhoray({"verify", "--deep", "all.rho"});
  EXPECT_EQ(sound.exit_code, 0) << sound.out << sound.err;
  MadeGrid grid = made_grid({}, {{"density", ramp, true}});
  grid.description.certificates[0].max_error = 0.25;
  write_file(bench / "lie.rho", grid.file());
  const RunResult lie = bench.rhoray({"verify", "--deep", "lie.rho"});
  EXPECT_EQ(lie.exit_code, 4);
  EXPECT_THAT(lie.out, HasSubstr("the largest error of field 'density' is wrong: its bricks give 0.5"));
}

TEST(GridOfAllKinds, is_rendered_by_the_field_that_is_named) {
  const Workbench bench;
  make_grid_with_all(bench);
  // Each isovalue lies outside the other field's range.
  for (const auto& [field, isovalue] : {std::pair("density", "200"), std::pair("pressure", "-200")}) {
    const RunResult result = bench.rhoray({"render", "all.rho", "-o", concat(field, ".png"), "--field", field, "--iso",
                                           isovalue, "--size", "96x96", "--json"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const nlohmann::json json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json["field"], field);
    EXPECT_GT(json["statistics"]["hits"].get<int>(), 100);
  }
  const RunResult unknown = bench.rhoray({"render", "all.rho", "-o", "x.png", "--field", "presure"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("pressure"));
}

TEST(PackCommand, keeps_several_fields_of_a_volume_in_the_order_asked_for) {
  const Workbench bench;
  make_two_fields(bench);
  const RunResult packed = bench.rhoray({"pack", "two.vti", "--field", "up,east", "-o", "two.rho", "-q"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  EXPECT_EQ(bench.rhoray({"verify", "--deep", "two.rho"}).exit_code, 0);
  const nlohmann::json json = nlohmann::json::parse(bench.rhoray({"info", "two.rho", "--json"}).out);
  ASSERT_EQ(json["fields"].size(), 2U);
  EXPECT_EQ(json["fields"][0]["name"], "up");
  EXPECT_EQ(json["fields"][0]["type"], "I16");
  EXPECT_EQ(json["fields"][0]["range"], nlohmann::json({0.0, 30.0}));
  EXPECT_EQ(json["fields"][1]["name"], "east");
  EXPECT_EQ(json["fields"][1]["range"], nlohmann::json({0.0, 5.0}));
  EXPECT_THAT(json["provenance"]["command"].get<std::string>(), HasSubstr("--field up,east"));

  const RunResult twice = bench.rhoray({"pack", "two.vti", "--field", "up,up", "-o", "twice.rho"});
  EXPECT_EQ(twice.exit_code, 4);
  EXPECT_THAT(twice.err, HasSubstr("two fields 'up'"));
  const RunResult missing = bench.rhoray({"pack", "two.vti", "--field", "up,west", "-o", "missing.rho"});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("west"));
  EXPECT_FALSE(std::filesystem::exists(bench / "missing.rho"));
}

TEST(PackCommand, stores_only_bricks_with_data_where_the_layout_is_sparse) {
  const Workbench bench;
  make_two_fields(bench);
  const RunResult integers =
      bench.rhoray({"pack", "two.vti", "--field", "up", "--layout", "sparse", "-o", "two.rho", "-q"});
  EXPECT_EQ(integers.exit_code, 2);
  EXPECT_THAT(integers.err, HasSubstr("found samples of type I16; expected F32 or F64"));
  const RunResult packed = bench.rhoray(
      {"pack", "two.vti", "--type", "F32", "--layout", "sparse", "--brick-edge", "4", "-o", "two.rho", "-q"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  const nlohmann::json json = nlohmann::json::parse(bench.rhoray({"info", "two.rho", "--json"}).out);
  EXPECT_EQ(json["layout"]["sparse"], true);
  EXPECT_EQ(json["layout"]["brick_edge"], 4);
}

}  // namespace
}  // namespace rhoray::tests
