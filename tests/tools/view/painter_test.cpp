#include "tools/view/painter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "formats/base/json.h"
#include "tests/tools/view/viewed.h"
#include "tools/pictures/annotations.h"
#include "tools/pictures/pictures.h"
#include "tools/view/picture_message.h"

namespace rhoray::tests {
namespace {

using namespace tools;
using std::chrono::seconds;

constexpr seconds patience(120);  ///< for one message; sanitizers are slow

/// Collects the messages to a client; a test can wait for them. It must outlive the painter.
class Inbox {
 public:
  ClientSink sink() {
    return {.send_picture =
                [this](std::vector<std::byte> bytes) {
                  const std::lock_guard lock(mutex_);
                  pictures_.push_back(std::move(bytes));
                  changed_.notify_all();
                },
            .send_text =
                [this](std::string text) {
                  const std::lock_guard lock(mutex_);
                  texts_.push_back(std::move(text));
                  changed_.notify_all();
                }};
  }

  /// Waits until so many pictures have come, for as long as the patience lasts.
  std::vector<std::vector<std::byte>> pictures(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return pictures_.size() >= count; });
    return pictures_;
  }
  std::vector<std::string> texts(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [&] { return texts_.size() >= count; });
    return texts_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::vector<std::byte>> pictures_;
  std::vector<std::string> texts_;
};

/// Waits for the message with this key, and with this id if it is given.
Json message(Inbox& inbox, const char* key, std::optional<std::uint32_t> id = {}) {
  for (std::size_t count = 1;; ++count) {
    const auto texts = inbox.texts(count);
    if (texts.size() < count) return {};
    if (Json json = Json::parse(texts[count - 1]); json.contains(key) && (!id || json[key]["id"] == *id))
      return json[key];
  }
}

/// The picture of `render`, as a PNG with its texts.
std::vector<std::byte> rendered(const ViewedScene& viewed, const PictureRequest& request) {
  const render::ResolvedScene plan =
      with_request(viewed, changed_scene(viewed, document_to_change(viewed), request.patch), request);
  render::Framebuffer picture;
  render::FrameOptions frame = plan.frame;
  frame.channels |= channels_of_annotations(plan);
  if (plan.page) frame.channels |= render::channel_of(*plan.page);
  const render::FrameStatistics statistics = render::render(plan.datasets, plan.scene, frame, picture);
  Interval<double> heat;
  if (plan.page) heat = draw_heat_map(*plan.page, picture);
  draw_annotations(plan, heat, picture);
  return encode_picture(picture, viewed.texts_of(plan, statistics.machine), "picture.png");
}

/// Acknowledges pictures up to the lossless one.
void acknowledge_finished_picture(Painter& painter, Painter::ClientId client, Inbox& inbox) {
  for (std::size_t frame = 1;; ++frame) {
    const auto pictures = inbox.pictures(frame);
    ASSERT_GE(pictures.size(), frame) << "nothing more came";
    painter.take(client, Acknowledgement{static_cast<std::uint32_t>(frame)});
    if (read_picture_header(pictures[frame - 1]).codec == Codec::png) return;
  }
}

struct Finish {
  const char* name;
  render::LayerType type;
  const char* patch;

  friend void PrintTo(const Finish& finish, std::ostream* out) { *out << finish.name; }
};

class FinishedPicture : public testing::TestWithParam<Finish> {};

TEST_P(FinishedPicture, is_that_of_render_without_loss) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder, GetParam().type);
  Inbox inbox;
  Painter painter(viewed, 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  const PictureRequest request{.number = 3, .patch = GetParam().patch, .width = 90, .height = 70};
  painter.take(client, request);
  std::size_t seen = 0;
  for (;;) {  // acknowledges everything until the lossless one is here
    const auto pictures = inbox.pictures(seen + 1);
    ASSERT_GT(pictures.size(), seen) << "nothing more came";
    const PictureHeader header = read_picture_header(pictures[seen++]);
    EXPECT_EQ(header.request, 3U);
    EXPECT_EQ(header.frame, seen);
    EXPECT_EQ(header.width, 90);
    EXPECT_EQ(header.height, 70);
    painter.take(client, Acknowledgement{header.frame});
    if (header.codec != Codec::png) continue;
    const std::vector<std::byte> png(pictures[seen - 1].begin() + picture_header_bytes, pictures[seen - 1].end());
    EXPECT_EQ(png, rendered(viewed, request));
    break;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Changes, FinishedPicture,
    testing::Values(Finish{"isosurface", render::LayerType::isosurface, R"({"layers": {"0": {"isovalue": 0.6}}})"},
                    Finish{"boundary", render::LayerType::boundary, ""},
                    Finish{"heat_map", render::LayerType::isosurface, R"({"image": {"show": "cost"}})"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Painter, draws_heat_maps_while_moving) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  for (const char* page : {"error", "roots", "cost"}) {
    Inbox inbox;
    Painter painter(viewed, 2);
    painter.take(painter.add(inbox.sink()),
                 PictureRequest{.number = 1,
                                .patch = concat(R"({"layers": {"0": {"accuracy": "certified"}}, "image": {"show": ")",
                                                page, "\"}}"),
                                .width = 60,
                                .height = 50,
                                .is_moving = true});
    EXPECT_EQ(inbox.pictures(1).size(), 1U) << page;
  }
}

TEST(Painter, sends_no_more_than_two_pictures_that_are_not_acknowledged_and_then_the_newest) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  for (std::uint32_t n = 1; n <= 200; ++n) {
    painter.take(client, PictureRequest{.number = n, .width = 60, .height = 50, .is_moving = true});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(inbox.pictures(2).size(), 2U);
  painter.take(client, Acknowledgement{2});
  const auto after = inbox.pictures(3);
  ASSERT_GE(after.size(), 3U);
  EXPECT_EQ(read_picture_header(after[2]).request, 200U);
  // An acknowledgement of what was never sent makes no room for more.
  painter.take(client, Acknowledgement{4000000000U});
  painter.take(client, PictureRequest{.number = 201, .width = 60, .height = 50, .is_moving = true});
  EXPECT_GE(inbox.pictures(4).size(), 4U);
}

TEST(Painter, sends_the_lossless_picture_if_the_client_has_room_for_it_before_its_time) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, PictureRequest{.number = 1, .width = 60, .height = 50, .is_moving = true});
  inbox.pictures(1);
  painter.take(client, PictureRequest{.number = 2, .width = 60, .height = 50});
  inbox.pictures(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the painter waits for room
  painter.take(client, Acknowledgement{2});
  const auto pictures = inbox.pictures(3);
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(read_picture_header(pictures[2]).codec, Codec::png);
}

TEST(Painter, sends_nothing_more_for_a_probe_while_two_pictures_are_not_acknowledged) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, PictureRequest{.number = 1, .width = 60, .height = 50, .is_moving = true});
  inbox.pictures(1);
  painter.take(client, PictureRequest{.number = 2, .width = 60, .height = 50});
  inbox.pictures(2);
  std::this_thread::sleep_for(std::chrono::milliseconds(350));  // now the lossless picture waits for room
  for (std::uint32_t id = 1; id <= 3; ++id) {
    painter.take(client, Probe{.id = id, .x = 30, .y = 25});
    EXPECT_FALSE(message(inbox, "probe", id).is_null());
  }
  painter.take(client, KeepRequest{});
  EXPECT_FALSE(message(inbox, "keep").is_null());
  EXPECT_EQ(inbox.pictures(0).size(), 2U);
}

TEST(Painter, sends_pictures_to_a_client_that_always_requests_another_picture_at_rest) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  // One pass, then edges, which take so long that the next request always ends them.
  PictureRequest request{.patch = R"({"image": {"antialias": 64}})", .width = 440, .height = 440};
  const std::jthread flood([&](const std::stop_token& stop) {
    for (request.number = 1; !stop.stop_requested(); ++request.number) {
      painter.take(client, request);
      painter.take(client, Acknowledgement{request.number});
    }
  });
  EXPECT_GE(inbox.pictures(5).size(), 5U);
}

// Such a change soon after a finished picture was not seen before the new one was finished, too.
TEST(Painter, refines_a_changed_scene_in_passes_also_soon_after_a_finished_picture) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId client = painter.add(inbox.sink());
  const PictureRequest first{.number = 1, .width = 1000, .height = 1000};
  painter.take(client, first);
  acknowledge_finished_picture(painter, client, inbox);
  const std::size_t seen = inbox.pictures(0).size();
  PictureRequest changed = first;
  changed.number = 2, changed.patch = R"({"layers": {"0": {"isovalue": 0.6}}})";
  painter.take(client, changed);
  const auto pictures = inbox.pictures(seen + 1);
  ASSERT_GT(pictures.size(), seen);
  const PictureHeader header = read_picture_header(pictures[seen]);
  EXPECT_EQ(header.request, 2U);
  EXPECT_GT(header.spacing, 1);
}

/// A picture that takes many seconds.
PictureRequest heavy(std::uint32_t number) {
  return {.number = number,
          .patch = R"({"effects": {"ambient_occlusion": {"samples": 64}}, "image": {"antialias": 64}})",
          .width = 4000,
          .height = 4000};
}

TEST(Painter, ends_a_picture_that_takes_too_long_and_says_so) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1, std::chrono::milliseconds(100));
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, heavy(1));
  EXPECT_EQ(message(inbox, "error"), "the picture takes more than 0.1 s; choose fewer samples or a smaller window");
  painter.take(client, PictureRequest{.number = 2, .width = 6, .height = 5, .is_moving = true});
  EXPECT_EQ(read_picture_header(inbox.pictures(1).back()).request, 2U);
}

TEST(Painter, ends_the_first_pass_of_a_client_that_leaves) {
  const TemporaryFolder folder;
  Inbox heavy_inbox, inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId of_heavy = painter.add(heavy_inbox.sink()), client = painter.add(inbox.sink());
  painter.take(of_heavy, heavy(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  painter.remove(of_heavy);
  painter.take(client, PictureRequest{.number = 2, .width = 6, .height = 5, .is_moving = true});
  EXPECT_EQ(inbox.pictures(1).size(), 1U);
  EXPECT_EQ(heavy_inbox.pictures(0).size(), 0U);
}

TEST(Painter, ends_the_work_for_a_client_at_rest_for_the_picture_of_another_and_does_it_later) {
  const TemporaryFolder folder;
  Inbox resting, moving;
  Painter painter(viewed_box(folder), 2, std::chrono::minutes(5));
  const Painter::ClientId of_resting = painter.add(resting.sink()), of_moving = painter.add(moving.sink());
  std::uint32_t number = 0;
  const auto move = [&](int pictures) {
    for (; pictures > 0; --pictures) {
      painter.take(of_moving, PictureRequest{.number = ++number, .width = 60, .height = 50, .is_moving = true});
      ASSERT_GE(moving.pictures(number).size(), number);
      painter.take(of_moving, Acknowledgement{number});
    }
  };
  const auto is_told = [&](const char* key) {
    return testing::Value(resting.texts(0), testing::Contains(testing::HasSubstr(concat("{\"", key, "\""))));
  };
  // This picture takes about a hundred times as long as a picture of the other client.
  painter.take(
      of_resting,
      PictureRequest{
          .number = 1, .patch = R"({"effects": {"ambient_occlusion": {"samples": 16}}})", .width = 500, .height = 500});
  ASSERT_GE(resting.pictures(1).size(), 1U);
  move(10);
  EXPECT_FALSE(is_told("finished"));
  acknowledge_finished_picture(painter, of_resting, resting);
  EXPECT_EQ(message(resting, "finished")["n"], 1);
  for (int pause = 0; pause < 40 && !is_told("effects"); ++pause) {
    move(3);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  EXPECT_TRUE(is_told("check"));
  EXPECT_TRUE(is_told("effects"));
}

TEST(Painter, serves_others_while_one_client_floods_and_another_never_acknowledges) {
  const TemporaryFolder folder;
  Inbox good, silent, flooding;
  Painter painter(viewed_box(folder), 2);
  const Painter::ClientId of_good = painter.add(good.sink()), of_silent = painter.add(silent.sink()),
                          of_flooding = painter.add(flooding.sink());
  const std::jthread flood([&](const std::stop_token& stop) {
    for (std::uint32_t n = 1; !stop.stop_requested(); ++n) {
      painter.take(of_flooding, PictureRequest{.number = n, .width = 300, .height = 300, .is_moving = true});
      painter.take(of_flooding, Acknowledgement{n});
    }
  });
  painter.take(of_silent, PictureRequest{.number = 1, .width = 300, .height = 300});
  for (std::uint32_t n = 1; n <= 10; ++n) {
    painter.take(of_good, PictureRequest{.number = n, .width = 60, .height = 50, .is_moving = true});
    const auto pictures = good.pictures(n);
    ASSERT_GE(pictures.size(), n) << "the good client waits for picture " << n;
    painter.take(of_good, Acknowledgement{read_picture_header(pictures.back()).frame});
  }
  EXPECT_LE(silent.pictures(0).size(), 2U);
  painter.remove(of_silent);
}

TEST(Painter, tells_the_command_and_the_document_of_the_newest_request) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(
      client,
      PictureRequest{.number = 1, .patch = R"({"layers": {"0": {"isovalue": 0.25}}})", .width = 30, .height = 20});
  painter.take(client, KeepRequest{});
  const Json keep = message(inbox, "keep");
  EXPECT_EQ(keep["command"], "iso 0.25");
  EXPECT_EQ(keep["document"]["layers"][0]["isovalue"], 0.25);
  EXPECT_EQ(keep["document"]["image"]["size"], Json({30, 20}));
}

TEST(Painter, says_what_was_resolved_what_it_cost_and_what_exact_arithmetic_finds) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, PictureRequest{.number = 5, .patch = R"({"style": "fast"})", .width = 60, .height = 50});
  const Json resolved = message(inbox, "resolved");
  EXPECT_EQ(resolved["n"], 5);
  EXPECT_EQ(resolved["document"]["layers"][0]["isovalue"], 0.8);
  EXPECT_EQ(resolved["document"]["lights"][0]["type"], "head");
  EXPECT_FALSE(resolved["document"]["data"]["data"].contains("file"));
  EXPECT_EQ(resolved["origins"], Json::array({0}));
  EXPECT_EQ(resolved["fields"][0]["name"], "distance");
  const Json finished = message(inbox, "finished");
  EXPECT_EQ(finished["n"], 5);
  EXPECT_GE(finished["statistics"]["rays"], 60 * 50);
  EXPECT_EQ(finished["statistics"]["shadow_rays"], 0);
  for (std::uint32_t frame = 1; frame <= 2; ++frame) {
    inbox.pictures(frame);
    painter.take(client, Acknowledgement{frame});
  }
  const Json check = message(inbox, "check");
  EXPECT_EQ(check["n"], 5);
  EXPECT_GT(check["pixels"], 500) << "and pixels at edges";
  EXPECT_EQ(check["missed"], 0);
  EXPECT_EQ(check["false_hits"], 0);
  EXPECT_LT(check["kept_by_99"], 1e-3);  // float decides hits in these cells to 1e-6; 1e-3 tells a wrong unit
}

TEST(Painter, says_why_a_picture_is_not_compared_with_exact_arithmetic) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId client = painter.add(inbox.sink());
  const std::string slice = R"({"layers": {"1": {"type": "slice", "data": "data", "axis": "z"}}})";
  painter.take(client, PictureRequest{.number = 5, .patch = slice, .width = 30, .height = 20});
  acknowledge_finished_picture(painter, client, inbox);
  const Json check = message(inbox, "check");
  EXPECT_EQ(check["n"], 5);
  EXPECT_EQ(check["why_not"],
            "This picture cannot be compared with exact arithmetic: a layer is a slice; expected isosurfaces or one "
            "projection.");
}

TEST(Painter, times_the_effects_that_the_picture_uses) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {R"({"style": "fast", "image": {"antialias": 1}})", {"specular"}},
      {R"({"style": "fast", "image": {"antialias": 2}, "effects": {"ambient_occlusion": {"samples": 2}}})",
       {"antialiasing", "ambient occlusion", "specular"}}};
  for (const auto& [patch, expected] : cases) {
    Inbox inbox;
    Painter painter(viewed, 1);
    const Painter::ClientId client = painter.add(inbox.sink());
    painter.take(client, PictureRequest{.number = 5, .patch = patch, .width = 30, .height = 20});
    acknowledge_finished_picture(painter, client, inbox);
    const Json effects = message(inbox, "effects");
    EXPECT_EQ(effects["n"], 5);
    std::vector<std::string> names;
    for (const Json& effect : effects["effects"]) {
      names.push_back(effect["effect"]);
      EXPECT_LT(effect["ms"], effects["ms"]);
    }
    EXPECT_EQ(names, expected);
  }
}

TEST(Painter, probes_the_pixel_with_a_proven_error) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId client = painter.add(inbox.sink());
  for (const bool is_orthographic : {false, true}) {
    PictureRequest request{.number = 1, .camera = render::Camera{}, .width = 101, .height = 101, .is_moving = true};
    request.camera->position = {0.5, -3, 0.5}, request.camera->target = {0.5, 0, 0.5};
    request.camera->orthographic = is_orthographic;
    painter.take(client, request);
    painter.take(client, Probe{.id = is_orthographic ? 2U : 1U, .x = 50, .y = 50});
    const Json probe = message(inbox, "probe", is_orthographic ? 2U : 1U);
    // The distance from the corner is linear in each cell: where it is 0.8, so is the exact
    // distance but for what linear interpolation is off in cells of 1/8.
    EXPECT_EQ(probe["pixel"], Json({50, 50}));
    EXPECT_NEAR(probe["position"][0].get<double>(), 0.5, 1e-9);
    EXPECT_NEAR(probe["position"][2].get<double>(), 0.5, 1e-9);
    EXPECT_NEAR(Vec3(0.5, probe["position"][1].get<double>(), 0.5).length(), 0.8, 1.0 / 64);
    EXPECT_EQ(probe["value"], 0.8);
    EXPECT_LT(probe["error"].get<double>(), 1e-6);
  }
  painter.take(client, Probe{.id = 3, .x = 101, .y = 0});
  EXPECT_THAT(message(inbox, "probe", 3)["why_not"].get<std::string>(), testing::HasSubstr("a pixel of the picture"));
}

// A probe waited for the picture, and the page had given up meanwhile.
TEST(Painter, answers_probes_while_a_picture_is_traced) {
  const TemporaryFolder folder;
  Inbox inbox, other;
  Painter painter(viewed_box(folder), 1, std::chrono::minutes(5));
  const Painter::ClientId client = painter.add(inbox.sink()), of_other = painter.add(other.sink());
  painter.take(of_other, PictureRequest{.number = 1, .width = 60, .height = 50});
  ASSERT_GE(other.pictures(1).size(), 1U);
  // Its first pass traces one pixel of 64: a sanitizer has it in seconds.
  painter.take(client, PictureRequest{.number = 1,
                                      .patch = R"({"effects": {"ambient_occlusion": {"samples": 32}}})",
                                      .width = 2000,
                                      .height = 2000});
  ASSERT_GE(inbox.pictures(1).size(), 1U);
  for (std::uint32_t id = 1; id <= 5; ++id) {
    painter.take(client, Probe{.id = id, .x = 1000, .y = 1000});
    EXPECT_TRUE(message(inbox, "probe", id).contains("pixel"));
    painter.take(of_other, Probe{.id = id, .x = 30, .y = 25});
    EXPECT_TRUE(message(other, "probe", id).contains("pixel"));
  }
  EXPECT_THAT(inbox.texts(0), testing::Not(testing::Contains(testing::HasSubstr("finished"))))
      << "the picture no longer takes long: is this case still the hard one?";
}

TEST(Painter, says_why_a_refused_scene_is_not_probed) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, Probe{.id = 1, .x = 5, .y = 5});  // before any request: it waits
  painter.take(client, PictureRequest{.number = 1, .patch = R"({"style": "bright"})", .width = 30, .height = 20});
  EXPECT_EQ(message(inbox, "probe", 1)["why_not"], message(inbox, "error"));
  painter.take(client, PictureRequest{.number = 2, .width = 30, .height = 20});
  painter.take(client, Probe{.id = 2, .x = 15, .y = 10});
  EXPECT_TRUE(message(inbox, "probe", 2).contains("pixel"));
}

TEST(Painter, ends_while_clients_still_ask) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  for (int i = 0; i < 3; ++i)
    painter.take(painter.add(inbox.sink()), PictureRequest{.number = 1, .width = 2000, .height = 2000});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  painter.stop();
  const std::size_t count = inbox.pictures(0).size();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(inbox.pictures(0).size(), count);
}

}  // namespace
}  // namespace rhoray::tests
