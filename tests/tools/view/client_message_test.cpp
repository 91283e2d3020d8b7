#include "tools/view/client_message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "formats/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/tools/view/viewed.h"

namespace rhoray::tests {
namespace {

using namespace tools;

const char* const full =
    R"({"n": 7, "size": [800, 600], "moving": true, "scene": {"layers": {"1": {"isovalue": 500.5}}}, "camera": {"position": [1, 2, 3],)"
    R"( "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30}})";

TEST(ClientMessage, says_what_a_client_wants_to_see) {
  const PictureRequest request = std::get<PictureRequest>(parse_client_message(full));
  EXPECT_EQ(request.number, 7U);
  EXPECT_EQ(request.width, 800);
  EXPECT_EQ(request.height, 600);
  EXPECT_TRUE(request.is_moving);
  EXPECT_EQ(request.patch, R"({"layers":{"1":{"isovalue":500.5}}})");
  ASSERT_TRUE(request.camera);
  EXPECT_EQ(request.camera->position, Vec3(1, 2, 3));
  EXPECT_EQ(request.camera->vertical_fov_deg, 30);
  EXPECT_FALSE(request.camera->orthographic);
  EXPECT_EQ(std::get<Acknowledgement>(parse_client_message(R"({"ack": 12})")).frame, 12U);
  const Probe probe = std::get<Probe>(parse_client_message(R"({"probe": [3, 4], "id": 5})"));
  EXPECT_THAT((std::array{probe.x, probe.y, static_cast<int>(probe.id)}), testing::ElementsAre(3, 4, 5));
  EXPECT_TRUE(std::holds_alternative<KeepRequest>(parse_client_message(R"({"keep": true})")));
  EXPECT_TRUE(std::holds_alternative<FollowRequest>(parse_client_message(R"({"follow": true})")));
  EXPECT_EQ(request.set_number, 0U);
  const auto following = parse_client_message(R"({"n": 8, "size": [1, 1], "set": 3})");
  EXPECT_EQ(std::get<PictureRequest>(following).set_number, 3U);
  const auto orthographic = parse_client_message(
      R"({"n": 0, "size": [1, 1], "camera": {"position": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0],)"
      R"( "ortho_height": 2}})");
  EXPECT_EQ(std::get<PictureRequest>(orthographic).camera->orthographic_height, 2);
}

TEST(ClientMessage, that_lies_is_refused_in_one_sentence) {
  for (
      const char* text :
      {"",
       "7",
       "[]",
       "null",
       "{",
       "{}",
       R"({"n": -1, "size": [1, 1]})",
       R"({"n": 4294967296, "size": [1, 1]})",
       R"({"n": 1})",
       R"({"n": 1, "size": [0, 1]})",
       R"({"n": 1, "size": [4097, 1]})",
       R"({"n": 1, "size": [1.5, 1]})",
       R"({"n": 1, "size": [1]})",
       R"({"n": 1, "size": "1x1"})",
       R"({"n": 1, "size": [1, 1], "moving": 1})",
       R"({"n": 1, "size": [1, 1], "other": 1})",
       R"({"n": 1, "size": [1, 1], "isovalues": [[0, 5]]})",
       R"({"n": 1, "size": [1, 1], "scene": []})",
       R"({"n": 1, "size": [1, 1], "scene": "style"})",
       R"({"n": 1, "size": [1, 1], "camera": 5})",
       R"({"n": 1, "size": [1, 1], "camera": {"position": [0, 0, 1], "target": [0, 0, 0], "fov": 30}})",
       R"({"n": 1, "size": [1, 1], "camera": {"position": [0, 0, 1], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30}})",
       R"({"n": 1, "size": [1, 1], "camera": {"position": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 180}})",
       R"({"n": 1, "size": [1, 1], "camera": {"position": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0]}})",
       R"({"ack": -1})",
       R"({"ack": 1, "n": 1})",
       R"({"probe": [1, 2]})",
       R"({"probe": [1], "id": 1})",
       R"({"probe": [-1, 2], "id": 1})",
       R"({"probe": [4096, 2], "id": 1})",
       R"({"probe": [1.5, 2], "id": 1})",
       R"({"n": 1, "size": [1, 1], "set": -1})",
       R"({"follow": false})",
       R"({"follow": true, "n": 1})",
       R"({"keep": false})",
       R"({"keep": true, "path": "/etc/passwd"})"})
    expect_error(ErrorCode::invalid, "message: ", [&] { parse_client_message(text); });
  const std::string deep = R"({"n": 1, "size": )" + std::string(1000, '[') + std::string(1000, ']') + "}";
  expect_error(ErrorCode::invalid, "levels", [&] { parse_client_message(deep); });
  expect_error(ErrorCode::invalid, "bytes", [&] { parse_client_message(std::string(70000, ' ')); });
}

TEST(ProgramMessage, says_what_views_shall_show) {
  const ViewState state = parse_program_message(
      R"({"set": {"n": 3, "scene": {"style": "fast"}, "camera": {"position": [1, 2, 3], "target": [0, 0, 0],)"
      R"( "up": [0, 0, 1], "ortho_height": 4}}})");
  EXPECT_EQ(state.number, 3U);
  EXPECT_EQ(state.patch, R"({"style":"fast"})");
  ASSERT_TRUE(state.camera);
  EXPECT_EQ(state.camera->orthographic_height, 4);
  EXPECT_FALSE(parse_program_message(R"({"set": {"n": 4}})").camera);
  for (const char* text : {"", "{}", R"({"set": 3})", R"({"set": {}})", R"({"set": {"n": -1}})", full,
                           R"({"set": {"n": 1, "scene": 5}})", R"({"set": {"n": 1, "camera": {}}})",
                           R"({"set": {"n": 1, "size": [1, 1]}})", R"({"set": {"n": 1}, "keep": true})"})
    expect_error(ErrorCode::invalid, "message: ", [&] { parse_program_message(text); });
}

TEST(ClientMessage, of_random_changes_is_read_or_refused) {
  std::mt19937_64 random(20261126);
  int read = 0;
  for (int round = message_count(20000); round > 0; --round) {
    const std::string text = mutated(full, random);
    try {
      parse_client_message(text);
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid) << text;
    }
  }
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace rhoray::tests
