#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

/// ball.raw, off the world's origin, three times: as NRRD in LPS, as NIfTI in RAS, and without a
/// space. The patient's right is at the smaller index i.
class Spaces : public testing::Test {
 protected:
  Spaces() {
    bench_.make_ball_raw();
    const std::string samples = read_file(bench_ / "ball.raw");
    const std::string nrrd = "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n";
    write_file(bench_ / "lps.nrrd", nrrd +
                                        "space: left-posterior-superior\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n"
                                        "space origin: (-10,30,50)\n\n" +
                                        samples);
    write_file(bench_ / "plain.nrrd",
               nrrd + "space dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (-10,30,50)\n\n" +
                   samples);
    write_file(bench_ / "ras.nii", nifti() + samples);
  }

  /// A NIfTI-1 header (nifti1.h) with the place of lps.nrrd, in RAS: x and y change their signs.
  static std::string nifti() {
    std::string header(352, '\0');
    const auto put = [&](std::size_t at, const auto& value) { std::memcpy(&header[at], &value, sizeof value); };
    put(0, std::int32_t{348});
    for (const auto& [axis, count] : {std::pair{0, 3}, {1, 24}, {2, 24}, {3, 24}, {4, 1}})
      put(40 + 2 * static_cast<std::size_t>(axis), static_cast<std::int16_t>(count));
    put(70, std::int16_t{2});  // bytes
    put(72, std::int16_t{8});
    for (std::size_t axis = 1; axis < 4; ++axis) put(76 + 4 * axis, 2.0F);
    put(108, 352.0F);
    put(254, std::int16_t{1});
    const float rows[3][4] = {{-2, 0, 0, 10}, {0, -2, 0, -30}, {0, 0, 2, 50}};
    put(280, rows);
    std::memcpy(&header[344], "n+1", 4);
    return header;
  }

  Json drawn(const std::string& file, std::vector<std::string> words = {}) const {
    words.insert(words.begin(),
                 {"render", file, "--iso", "100", "--size", "80x60", "-o", "p.exr", "--force", "--json"});
    const RunResult result = bench_.rhoray(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  }

  Workbench bench_;
};

TEST_F(Spaces, show_the_same_body_in_the_same_place) {
  const Json lps = drawn("lps.nrrd", {"--pick", "40,30"}), ras = drawn("ras.nii", {"--pick", "40,30"});
  EXPECT_EQ(lps["camera"], ras["camera"]);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(lps["picks"][0]["position"][axis].get<double>(), ras["picks"][0]["position"][axis].get<double>(), 1e-4);
  // World coordinates are RAS: the ball's middle is at -(-10 + 23), -(30 + 23), 50 + 23.
  const Json target = lps["camera"]["target"];
  EXPECT_NEAR(target[0].get<double>(), -13, 1);
  EXPECT_NEAR(target[1].get<double>(), -53, 1);
  EXPECT_NEAR(target[2].get<double>(), 73, 1);
}

TEST_F(Spaces, join_in_one_scene) {
  const RunResult both = bench_.rhoray({"render", "lps.nrrd", "ras.nii", "--size", "80x60", "-o", "both.exr"});
  EXPECT_EQ(both.exit_code, 0) << both.err;
  EXPECT_THAT(both.err, Not(HasSubstr("does not say in which space")));
  const RunResult unknown = bench_.rhoray({"render", "lps.nrrd", "plain.nrrd", "--size", "80x60", "-o", "u.exr"});
  EXPECT_THAT(unknown.err, HasSubstr("note: plain.nrrd does not say in which space it lies"));
}

TEST_F(Spaces, are_seen_from_the_front) {
  // The front of a body is at +y in RAS and at -y in LPS; without a body it is at -y.
  const auto from = [&](const std::string& file, const std::string& view, std::vector<std::string> words = {}) {
    words.insert(words.end(), {"--view", view});
    const Json camera = drawn(file, words)["camera"];
    Vec3 eye;
    for (int axis = 0; axis < 3; ++axis)
      eye[axis] = camera["position"][axis].get<double>() - camera["target"][axis].get<double>();
    return eye.normalized();
  };
  const auto is_near = [](const Vec3& a, const Vec3& b) { return (a - b).length() < 1e-9; };
  EXPECT_TRUE(is_near(from("lps.nrrd", "front"), {0, 1, 0}));
  EXPECT_TRUE(is_near(from("lps.nrrd", "right"), {1, 0, 0}));
  EXPECT_TRUE(is_near(from("lps.nrrd", "front", {"--space", "lps"}), {0, -1, 0}));
  EXPECT_TRUE(is_near(from("lps.nrrd", "right", {"--space", "lps"}), {-1, 0, 0}));
  EXPECT_TRUE(is_near(from("plain.nrrd", "front"), {0, -1, 0}));
  EXPECT_TRUE(is_near(from("plain.nrrd", "right"), {1, 0, 0}));
}

TEST_F(Spaces, make_the_same_picture_again) {
  const Json first = drawn("lps.nrrd", {"--space", "lps"});
  const std::string bytes = read_file(bench_ / "p.exr");
  EXPECT_THAT(first["reproduce"].get<std::string>(), HasSubstr("--space lps"));
  ASSERT_EQ(bench_.shell(first["reproduce"].get<std::string>() + " --force").exit_code, 0);
  EXPECT_TRUE(read_file(bench_ / "p.exr") == bytes);
}

TEST_F(Spaces, are_shown) {
  EXPECT_THAT(bench_.rhoray({"info", "lps.nrrd"}).out, HasSubstr("LPS: x to the patient's left"));
  ASSERT_EQ(bench_.rhoray({"pack", "ras.nii", "-q"}).exit_code, 0);
  EXPECT_EQ(Json::parse(bench_.rhoray({"info", "ras.rho", "--json"}).out)["space"], "RAS");
  EXPECT_EQ(Json::parse(bench_.rhoray({"info", "plain.nrrd", "--json"}).out)["space"], "");
}

}  // namespace
}  // namespace rhoray::tests
