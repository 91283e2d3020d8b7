#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

TEST(InfoCommand, tells_of_a_grid_what_was_put_in) {
  const Workbench bench;
  bench.make_ball_raw();
  ASSERT_EQ(
      bench.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "--spacing", "0.5,1,2", "--origin", "-1,0,1", "-q"})
          .exit_code,
      0);
  const RunResult result = bench.rhoray({"info", "ball.rho", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["kind"], "grid");
  EXPECT_EQ(json["samples"], nlohmann::json({24, 24, 24}));
  EXPECT_EQ(json["cells"], 23 * 23 * 23);
  EXPECT_EQ(json["geometry"]["spacing"], nlohmann::json({0.5, 1.0, 2.0}));
  EXPECT_EQ(json["geometry"]["origin"], nlohmann::json({-1.0, 0.0, 1.0}));
  EXPECT_EQ(json["box"]["high"], nlohmann::json({10.5, 23.0, 47.0}));
  const std::string bytes = read_file(bench / "ball.raw");
  const auto [lo, hi] = std::minmax_element(bytes.begin(), bytes.end(), [](char a, char b) {
    return static_cast<unsigned char>(a) < static_cast<unsigned char>(b);
  });
  EXPECT_EQ(json["fields"][0]["range"],
            nlohmann::json({static_cast<unsigned char>(*lo) * 1.0, static_cast<unsigned char>(*hi) * 1.0}));
  std::uint64_t counted = 0;
  for (const auto& count : json["fields"][0]["histogram"]) counted += count.get<std::uint64_t>();
  EXPECT_EQ(counted, bytes.size());
  EXPECT_THAT(json["provenance"]["command"].get<std::string>(), HasSubstr("--spacing 0.5,1,2"));

  const RunResult text = bench.rhoray({"info", "ball.rho"});
  EXPECT_THAT(text.out, HasSubstr("24 x 24 x 24"));
  EXPECT_THAT(text.out, HasSubstr("0.5 x 1 x 2"));
  EXPECT_THAT(text.out, HasSubstr("█"));
  // Percentiles of whole numbers are whole numbers; nearly half of the samples are 0.
  EXPECT_THAT(text.out, testing::ContainsRegex("percentiles p1 0, p50 [0-9]+, p99 [0-9]+; Otsu's threshold "));
}

TEST(InfoCommand, tells_of_a_mesh_the_same_before_and_after_packing) {
  const Workbench bench;
  bench.make_box();
  const RunResult result = bench.rhoray({"info", "box.vtu", "box.rho", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::size_t end = result.out.find('\n');
  const nlohmann::json foreign = nlohmann::json::parse(result.out.substr(0, end));
  const nlohmann::json packed = nlohmann::json::parse(result.out.substr(end + 1));
  EXPECT_EQ(foreign["kind"], "mesh");
  EXPECT_EQ(packed["kind"], "tets");
  for (const char* same : {"points", "cells", "box"}) EXPECT_EQ(foreign[same], packed[same]) << same;
  ASSERT_EQ(foreign["fields"].size(), 2U);
  for (std::size_t f = 0; f < 2; ++f)
    for (const char* same : {"name", "range", "no_data_count"})
      EXPECT_EQ(foreign["fields"][f][same], packed["fields"][f][same]) << same;
  EXPECT_THAT(bench.rhoray({"info", "box.vtu"}).out, HasSubstr("'length'"));
}

TEST(InfoCommand, tells_how_a_file_stores_its_data_only_on_demand) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  const std::map<std::string, std::vector<const char*>> rows{{"ball.rho", {"  layout ", "  levels ", "  memory "}},
                                                             {"box.rho", {"  clusters ", "  structure ", "  memory "}}};
  for (const auto& [file, names] : rows) {
    const RunResult plain = bench.rhoray({"info", file}), verbose = bench.rhoray({"info", file, "-v"});
    for (const char* name : names) {
      EXPECT_THAT(verbose.out, HasSubstr(name));
      EXPECT_THAT(plain.out, testing::Not(HasSubstr(name)));
    }
    for (const char* name : {"  field ", "  box ", "percentiles p1 ", "  made by "}) {
      EXPECT_THAT(plain.out, HasSubstr(name));
      EXPECT_THAT(verbose.out, HasSubstr(name));
    }
  }
}

TEST(PackCommand, tells_how_the_file_compares_with_raw_data_only_on_demand) {
  const Workbench bench;
  bench.make_ball_raw();
  const auto packed = [&](const char* how_much) {
    return bench.rhoray({"pack", "ball.raw", "--raw", "24x24x24:uint8", "--force", how_much}).err;
  };
  EXPECT_THAT(packed("-v"), HasSubstr("times the size of the raw data"));
  EXPECT_THAT(packed("--progress=none"), testing::Not(HasSubstr("raw data")));
}

TEST(InfoCommand, tells_of_a_volume_of_vectors_alone_and_pack_takes_their_magnitude) {
  const Workbench bench;
  write_file(bench / "flow.vti",
             "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData "
             "WholeExtent=\"0 1 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 1 0 1 0 1\"><PointData>"
             "<DataArray type=\"Float32\" Name=\"flow\" NumberOfComponents=\"2\" format=\"ascii\">"
             "3 4 0 0 0 0 0 0 0 0 0 0 0 0 5 12</DataArray></PointData></Piece></ImageData></VTKFile>\n");
  const RunResult info = bench.rhoray({"info", "flow.vti", "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const nlohmann::json json = nlohmann::json::parse(info.out);
  EXPECT_EQ(json["fields"][0]["name"], "flow.mag");
  EXPECT_EQ(json["fields"][0]["range"], nlohmann::json({0.0, 13.0}));
  EXPECT_EQ(json["vectors"],
            nlohmann::json({{{"name", "flow"}, {"components", 2}, {"scalars", "flow.mag, flow.x, flow.y"}}}));
  EXPECT_THAT(bench.rhoray({"info", "flow.vti"}).out,
              HasSubstr("vector      'flow'  2 components: flow.mag, flow.x, flow.y\n"));

  const RunResult packed = bench.rhoray({"pack", "flow.vti"});
  EXPECT_EQ(packed.exit_code, 0);
  EXPECT_THAT(packed.err, HasSubstr("using the magnitude of 2 components, 'flow.mag'; choose another with --field: "
                                    "flow.x, flow.y\n"));
  EXPECT_THAT(bench.rhoray({"render", "flow.vti", "--no-cache", "--mode", "mip", "--size", "16x16"}).err,
              HasSubstr("note: using the magnitude of 2 components, 'flow.mag'; choose another with --field: flow.x"));
  const RunResult refused = bench.rhoray({"pack", "flow.vti", "--field", "flow", "--force"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("found 2 components; expected one scalar of: flow.mag, flow.x, flow.y"));
}

TEST(InfoCommand, says_on_demand_what_may_be_wrong_and_what_packing_does) {
  const Workbench bench;
  preprocess::NeutralMesh mesh = box_mesh({});
  add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  std::swap(mesh.cells[7][0], mesh.cells[7][1]);
  mesh.points.push_back({5, 5, 5});
  mesh.point_fields[0].values.push_back(5);
  preprocess::export_mesh(mesh, bench / "box.vtu", false);
  ASSERT_EQ(bench.rhoray({"pack", "box.vtu", "-q"}).exit_code, 0);
  const RunResult text = bench.rhoray({"info", "box.vtu", "--stats"});
  EXPECT_THAT(text.out, HasSubstr("flipped cells: 1 (cell 7); turned"));
  EXPECT_THAT(text.out, HasSubstr("points without a cell: 1 (point 125); dropped"));
  EXPECT_THAT(line_after(text.out, "  not found"), HasSubstr("flat cells"));
  EXPECT_THAT(bench.rhoray({"info", "box.vtu"}).out, testing::Not(HasSubstr("found")));

  const auto counts = [&](const char* file) {
    std::map<std::string, std::uint64_t> found;
    const RunResult result = bench.rhoray({"info", file, "--stats", "--json"});
    const nlohmann::json json = nlohmann::json::parse(result.out);
    for (const nlohmann::json& finding : json["findings"])
      if (finding["count"] != 0) found[finding["name"]] = finding["count"];
    return found;
  };
  EXPECT_EQ(counts("box.vtu"),
            (std::map<std::string, std::uint64_t>{{"flipped cells", 1}, {"points without a cell", 1}}));
  EXPECT_TRUE(counts("box.rho").empty());  // packing has corrected both
}

TEST(InfoCommand, goes_on_after_a_file_that_it_cannot_read) {
  const Workbench bench;
  bench.make_ball();
  const RunResult result = bench.rhoray({"info", "missing.rho", "ball.rho"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.out, HasSubstr("ball.rho"));
  EXPECT_THAT(result.err, HasSubstr("missing.rho"));
}

TEST(VerifyCommand, passes_sound_files_and_names_every_damaged_block) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  for (const char* deep : {"--json", "--deep"}) {
    const RunResult sound = bench.rhoray({"verify", "ball.rho", "box.rho", deep});
    EXPECT_EQ(sound.exit_code, 0) << sound.out << sound.err;
  }
  const nlohmann::json info = nlohmann::json::parse(bench.rhoray({"info", "box.rho", "--json"}).out);
  for (const nlohmann::json& array : info["arrays"]) {
    const std::string name = array["name"];
    SCOPED_TRACE(name);
    std::string bytes = read_file(bench / "box.rho");
    const std::size_t at = array["first_byte"].get<std::size_t>();
    bytes[at] = static_cast<char>(bytes[at] ^ 16);
    write_file(bench / "damaged.rho", bytes);
    const RunResult found = bench.rhoray({"verify", "damaged.rho", "--json"});
    EXPECT_EQ(found.exit_code, 4);
    const nlohmann::json json = nlohmann::json::parse(found.out);
    EXPECT_EQ(json["ok"], false);
    ASSERT_EQ(json["damaged_blocks"].size(), 1U);
    const nlohmann::json& block = json["damaged_blocks"][0];
    EXPECT_LE(block["first_byte"].get<std::size_t>(), at);
    EXPECT_GT(block["first_byte"].get<std::size_t>() + block["byte_count"].get<std::size_t>(), at);
    EXPECT_THAT(block["arrays"].get<std::vector<std::string>>(), testing::Contains(name));
    EXPECT_THAT(bench.rhoray({"verify", "damaged.rho"}).out, HasSubstr(name));
  }
}

TEST(VerifyCommand, finds_a_broken_header_or_seal) {
  const Workbench bench;
  bench.make_ball();
  const std::string good = read_file(bench / "ball.rho");
  for (const std::size_t at : {std::size_t{20}, good.size() - 1, good.size() - 60}) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    write_file(bench / "damaged.rho", bytes);
    const RunResult found = bench.rhoray({"verify", "damaged.rho"});
    EXPECT_EQ(found.exit_code, 4) << at;
    EXPECT_THAT(found.out, HasSubstr("damaged.rho")) << at;
  }
}

}  // namespace
}  // namespace rhoray::tests
