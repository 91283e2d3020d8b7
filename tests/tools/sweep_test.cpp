#include "render/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "render/document.h"
#include "tests/tools/workbench.h"
#include "tools/pictures/pictures.h"
#include "tools/pictures/projection.h"
#include "tools/rhoray/data_choice.h"

/// Cameras and isovalues that move from key frame to key frame.
namespace rhoray::tests {
namespace {

using testing::HasSubstr;
using namespace tools;
using Json = nlohmann::json;

TEST(Track, is_exact_at_the_keys_and_between_two_numbers_never_beyond_them) {
  const std::vector<std::pair<double, double>> keys{{0, 1}, {1, 1}, {1.5, 7}, {4, 6.5}, {5, -20}};
  render::Track<double> track;
  for (const auto& [time, value] : keys) track.add(time, value);
  for (const auto& [time, value] : keys) EXPECT_EQ(track.at(time), value);
  for (std::size_t i = 0; i + 1 < keys.size(); ++i)
    for (int step = 1; step < 50; ++step) {
      const double value = track.at(std::lerp(keys[i].first, keys[i + 1].first, step / 50.0));
      EXPECT_GE(value, std::min(keys[i].second, keys[i + 1].second));
      EXPECT_LE(value, std::max(keys[i].second, keys[i + 1].second));
    }
  EXPECT_EQ(track.at(-3), 1);
  EXPECT_EQ(track.at(9), -20);
}

TEST(Track, goes_evenly_through_keys_on_a_line_and_its_rate_does_not_jump) {
  render::Track<double> line, curve;
  for (const double time : {0.0, 1.0, 2.5, 4.0}) {
    line.add(time, 3 * time - 1);
    curve.add(time, time * time);
  }
  for (double time = 0; time <= 4; time += 0.125) EXPECT_NEAR(line.at(time), 3 * time - 1, 1e-12);
  constexpr double h = 1e-6;
  for (const double key : {1.0, 2.5})
    EXPECT_NEAR((curve.at(key) - curve.at(key - h)) / h, (curve.at(key + h) - curve.at(key)) / h, 1e-4);
}

TEST(Track, is_exact_at_the_keys_and_turned_as_they_are) {
  const std::vector<std::pair<double, Vec3>> keys{{0, {1, 0, 0}}, {1, {0, 2, 0}}, {3, {-1, 0, 5}}, {4, {0, -1, 1}}};
  const auto turned = [](const Vec3& v) { return Vec3(0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y, v.z); };
  render::Track<Vec3> track, other;
  for (const auto& [time, place] : keys) track.add(time, place), other.add(time, turned(place));
  for (const auto& [time, place] : keys) EXPECT_EQ(track.at(time), place);
  for (double time = 0; time < 4; time += 0.1) EXPECT_LT((turned(track.at(time)) - other.at(time)).length(), 1e-12);
}

TEST(FrameNames, have_one_place_for_a_number) {
  EXPECT_EQ(render::numbered("a/out_%04d.png", 7), "a/out_0007.png");
  EXPECT_EQ(render::numbered("out_%d.png", 12345), "out_12345.png");
  EXPECT_EQ(render::numbered("%02d.exr", 123), "123.exr");
  for (const char* name : {"out.png", "out_%s.png", "out_%d_%d.png", "out_%4d.png", "out_%", "50%.png"})
    EXPECT_FALSE(render::numbered(name, 1)) << name;
}

class SweepCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    bench_ = new Workbench;
    bench_->make_ball();
  }
  static void TearDownTestSuite() {
    delete bench_;
    bench_ = nullptr;
  }
  static const Workbench& bench() { return *bench_; }

  static std::string scene(const std::string& keys, const std::string& more = "") {
    return concat(R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", "isovalue": 100}],
      "image": {"size": [48, 36], "background": "#ffffff", "antialias": 1}, "camera": {"elevation": 20, "keyframes": )",
                  keys, "}", more, "}");
  }

 private:
  static Workbench* bench_;
};
Workbench* SweepCommand::bench_ = nullptr;

TEST_F(SweepCommand, draws_numbered_pictures_of_which_each_draws_itself_again) {
  write_file(bench() / "sweep.json",
             scene(R"([{"time": 0, "azimuth": 0, "isovalue": 60}, {"time": 2, "azimuth": 90, "isovalue": 180}])"));
  const RunResult result = bench().rhoray({"render", "sweep.json", "--frames", "3", "-o", "f_%02d.png", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(result.out);
  ASSERT_EQ(json["frames"].size(), 3U);
  EXPECT_GT(json["frames_per_second"], 0);
  for (int i = 0; i < 3; ++i) {
    const Json& frame = json["frames"][static_cast<std::size_t>(i)];
    EXPECT_EQ(frame["time"], i);
    EXPECT_EQ(frame["isovalue"], 60 + 60 * i);
    EXPECT_EQ(frame["picture"], concat("f_0", i, ".png"));
    EXPECT_EQ(frame["statistics"]["rays"], 48 * 36);
    const std::string picture = read_file(bench() / concat("f_0", i, ".png"));
    const RunResult again = bench().shell(frame["reproduce"].get<std::string>() + " --force");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_TRUE(read_file(bench() / concat("f_0", i, ".png")) == picture) << i;
  }
  const RunResult one =
      bench().rhoray({"render", "sweep.json", "--frames", "3", "--frame", "1", "-o", "f_01.png", "--force", "--stats"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_THAT(one.out, HasSubstr("120"));
  EXPECT_THAT(one.err, HasSubstr("frames per second"));
}

TEST_F(SweepCommand, keeps_one_distance_from_which_every_frame_shows_all) {
  write_file(bench() / "round.json", scene(R"([{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 360}])"));
  render::SceneSpec scene_spec = render::read_scene(bench() / "round.json").scene_spec;
  scene_spec.image.frames = 9;
  render::Sweep sweep(scene_spec);
  render::ResolvedScene plan = resolve_layers(sweep.spec_at(0));
  for (int frame = 0; frame < 9; ++frame) {
    sweep.plan_frame(frame, plan);
    const render::Camera camera = plan.scene.camera;
    static const double distance = (camera.position - camera.target).length();
    const Vec3 back = (camera.position - camera.target) / distance;
    EXPECT_NEAR(back.length(), 1, 1e-12);
    const double azimuth = frame * std::numbers::pi / 4, level = std::cos(20 * std::numbers::pi / 180);
    EXPECT_NEAR(back.x, level * std::sin(azimuth), 1e-9);
    EXPECT_NEAR(back.y, -level * std::cos(azimuth), 1e-9);
    render::ResolvedScene alone = resolve_layers(sweep.spec_at(sweep.time_of(frame)));
    aim_camera(sweep.spec_at(sweep.time_of(frame)), alone);
    EXPECT_LE((alone.scene.camera.position - alone.scene.camera.target).length(), distance * (1 + 1e-12));
  }
}

/// Frames had no room for the numbers of the box, and the colour bar stood over what is shown.
TEST_F(SweepCommand, leaves_the_room_around_what_is_shown_that_a_still_picture_leaves) {
  const auto document = [](const std::string& camera, const std::string& annotations) {
    return concat(R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "mip"}],
      "image": {"size": [48, 36]}, "camera": {"elevation": 20, "azimuth": 0)",
                  camera, R"(}, "annotations": )", annotations, "}");
  };
  const std::string keys = R"(, "keyframes": [{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 70}])";
  for (const std::string annotations :
       {"{}", R"({"box": true})", R"({"colorbar": true})", R"({"box": true, "colorbar": {"position": "left"}})"})
    for (const std::string camera : {"", R"(, "ortho": true)", R"(, "zoom": 1.5)", R"(, "ortho": true, "zoom": 1.5)"}) {
      SCOPED_TRACE(annotations + camera);
      const render::SceneSpec still =
          render::read_scene(document(camera, annotations), "still", bench().path()).scene_spec;
      render::ResolvedScene picture = resolve_layers(still);
      aim_camera(still, picture);
      render::SceneSpec film =
          render::read_scene(document(camera + keys, annotations), "film", bench().path()).scene_spec;
      film.image.frames = 3;
      render::Sweep sweep(film);
      render::ResolvedScene frame = resolve_layers(sweep.spec_at(0));
      sweep.plan_frame(0, frame);
      EXPECT_EQ(frame.notes, picture.notes);
      const render::Camera &of_still = picture.scene.camera, &of_film = frame.scene.camera;
      EXPECT_EQ(of_film.orthographic, of_still.orthographic);
      if (!of_film.orthographic) {
        EXPECT_NEAR(of_film.vertical_fov_deg, of_still.vertical_fov_deg, 1e-12);
      }
      EXPECT_GE(of_film.orthographic_height, of_still.orthographic_height * (1 - 1e-12));
      EXPECT_LT(of_film.orthographic_height, of_still.orthographic_height * 1.3) << "frames of 70 degrees need more";
      // The middle is at the same place of both pictures, less perspective.
      const Vec3 middle = picture.datasets[0].bounds().center();
      const double x_still = tools::Projection(of_still, 480, 360).of(middle).at.x,
                   x_film = tools::Projection(of_film, 480, 360).of(middle).at.x;
      EXPECT_NEAR(x_film, x_still, of_film.orthographic ? 1e-6 : 8) << "of 480";
    }
}

TEST_F(SweepCommand, goes_through_places_exactly) {
  write_file(bench() / "fly.json", scene(R"([{"time": 0, "position": [60, 0, 12], "target": [12, 12, 12]},
    {"time": 1, "position": [12, -40, 30]}, {"time": 2, "position": [-50, 12, 12], "target": [12, 12, 10]}])"));
  render::SceneSpec scene_spec = render::read_scene(bench() / "fly.json").scene_spec;
  scene_spec.image.frames = 5;
  render::Sweep sweep(scene_spec);
  render::ResolvedScene plan = resolve_layers(sweep.spec_at(0));
  const Vec3 positions[] = {{60, 0, 12}, {12, -40, 30}, {-50, 12, 12}};
  for (int key = 0; key < 3; ++key) {
    sweep.plan_frame(2 * key, plan);
    EXPECT_EQ(plan.scene.camera.position, positions[key]);
  }
  EXPECT_EQ(plan.scene.camera.target, Vec3(12, 12, 10));
}

TEST_F(SweepCommand, zooms_an_orthographic_camera) {
  write_file(bench() / "zoom.json",
             scene(R"([{"time": 0, "position": [60, 0, 12], "target": [12, 12, 12], "ortho_height": 40},
    {"time": 2, "position": [12, -40, 30], "target": [12, 12, 12], "ortho_height": 10}])"));
  render::SceneSpec scene_spec = render::read_scene(bench() / "zoom.json").scene_spec;
  scene_spec.image.frames = 3;
  render::Sweep sweep(scene_spec);
  render::ResolvedScene plan = resolve_layers(sweep.spec_at(0));
  const double heights[] = {40, 20, 10};  // the same factor for each unit of time
  for (int frame = 0; frame < 3; ++frame) {
    sweep.plan_frame(frame, plan);
    EXPECT_TRUE(plan.scene.camera.orthographic);
    EXPECT_NEAR(plan.scene.camera.orthographic_height, heights[frame], 1e-12);
  }
}

TEST_F(SweepCommand, puts_all_frames_on_one_sheet) {
  write_file(bench() / "sheet.json", scene(R"([{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 90}])"));
  const RunResult sheet = bench().rhoray({"render", "sheet.json", "--frames", "3", "--sheet", "2", "-o", "sheet.png"});
  ASSERT_EQ(sheet.exit_code, 0) << sheet.err;
  ASSERT_EQ(bench().rhoray({"render", "sheet.json", "--frames", "3", "-o", "part_%d.png"}).exit_code, 0);
  const StoredPicture all = read_picture(bench() / "sheet.png"), last = read_picture(bench() / "part_2.png");
  ASSERT_EQ(all.width, 96);
  ASSERT_EQ(all.height, 72);
  for (int y = 0; y < 36; ++y)
    for (int x = 0; x < 3 * 48; ++x) {
      const auto of_all = static_cast<std::size_t>(3 * 96 * (36 + y) + x),
                 of_last = static_cast<std::size_t>(3 * 48 * y + x);
      ASSERT_EQ(all.numbers[of_all], last.numbers[of_last]);
      ASSERT_EQ(all.numbers[of_all + 3 * 48], 1) << "an empty place is white";
    }
  const std::string bytes = read_file(bench() / "sheet.png");
  ASSERT_EQ(bench().shell(line_after(sheet.err, "reproduce: ") + " --force").exit_code, 0);
  EXPECT_TRUE(read_file(bench() / "sheet.png") == bytes);
}

TEST_F(SweepCommand, prints_its_key_frames_again) {
  write_file(bench() / "sweep.json", scene(R"([{"time": 0, "azimuth": 0}, {"time": 2, "azimuth": 90}])"));
  const RunResult printed = bench().rhoray({"render", "sweep.json", "--print-scene"});
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  const Json json = Json::parse(printed.out);
  EXPECT_EQ(json["camera"], Json::parse(read_file(bench() / "sweep.json"))["camera"]);
  EXPECT_EQ(json["image"]["frames"], 51) << "25 for each unit of time, and the first";
  write_file(bench() / "again.json", printed.out);
  EXPECT_EQ(bench().rhoray({"render", "again.json", "--print-scene"}).out, printed.out);
}

TEST_F(SweepCommand, refuses_what_does_not_move) {
  struct Mistake {
    std::string scene;
    std::vector<std::string> options;
    std::string fact;
    int exit_code = 4;
  };
  const std::string good = R"([{"time": 0, "azimuth": 0}, {"time": 1, "azimuth": 9}])";
  const std::vector<std::string> named{"-o", "x_%d.png"};
  for (const Mistake& mistake : {
           Mistake{scene("[]"), named, "s.json: /camera/keyframes: found 0; expected at least 2 key frames"},
           {scene("7"), named, "s.json: /camera/keyframes: found 7; expected an array of key frames"},
           {scene(R"([{"time": 0}, {"azimuth": 9}])"), named,
            "s.json: /camera/keyframes/1: has no \"time\"; expected a number"},
           {scene(R"([{"time": 1}, {"time": 1}])"), named,
            "s.json: /camera/keyframes/1/time: found 1; expected a time after 1, the time of the previous key"},
           {scene(R"([{"time": 0, "zoom": 2}, {"time": 1, "target": [0, 0, 0]}])"), named,
            "s.json: /camera/keyframes/1: \"target\" and \"zoom\" are both in key frames; expected either angles or "
            "positions"},
           {scene(R"([{"time": 0, "fov": 30}, {"time": 1, "ortho_height": 9}])"), named,
            "s.json: /camera/keyframes/1: \"fov\" and \"ortho_height\" are both in key frames; expected either "
            "perspective or orthographic cameras"},
           {scene(R"([{"time": 0, "elevation": 95}])"), named,
            "s.json: /camera/keyframes/0/elevation: found 95; expected a number from -90 to 90"},
           {scene(R"([{"time": 0, "isovalue": 50}, {"time": 1, "isovalue": 900}])"), named,
            "s.json: /camera/keyframes/1/isovalue: isovalue 900 is outside the range 0 to 237 of field 'ball'"},
           {R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "isosurface", "isovalue": [80, 90]}],
              "camera": {"keyframes": [{"time": 0, "isovalue": 50}, {"time": 1}]}})",
            named, "s.json: /camera/keyframes/0/isovalue: the scene shows 2 isosurfaces; expected exactly one"},
           {scene(R"([{"time": 0}, {"time": 1e9}])"), named, "s.json: /camera/keyframes: need "},
           {scene(good), {"-o", "x.png"}, "-o: found 'x.png'; expected a name with a frame number", 2},
           {scene(good), {"--frames", "3", "--frame", "3", "-o", "x.png"}, "--frame: found 3; expected 0 to 2", 2},
           {scene(good), {"--pick", "1,1", "-o", "x_%d.png"}, "--pick: works on one picture, not on frames", 2},
           {R"({"data": {"data": {"file": "ball.rho"}}, "layers": [{"type": "mip"}]})",
            {"--frames", "3", "-o", "x_%d.png"},
            "several frames need a scene document with \"keyframes\" of the camera"},
       }) {
    write_file(bench() / "s.json", mistake.scene);
    std::vector<std::string> words{"render", "s.json"};
    words.insert(words.end(), mistake.options.begin(), mistake.options.end());
    const RunResult refused = bench().rhoray(words);
    EXPECT_EQ(refused.exit_code, mistake.exit_code) << refused.err;
    EXPECT_THAT(refused.err, HasSubstr(mistake.fact));
  }
  EXPECT_FALSE(std::filesystem::exists(bench() / "x.png") || std::filesystem::exists(bench() / "x_0.png"));
}

}  // namespace
}  // namespace rhoray::tests
