#include "tools/view/painter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>

#include "render/png.h"
#include "tests/tools/view/viewed.h"
#include "tools/pictures/annotations.h"
#include "tools/view/picture_message.h"

namespace rhoray::tests {
namespace {

using namespace tools;
using std::chrono::seconds;

/// Collects the messages to a client; a test can wait for them.
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

  /// Waits until so many pictures have come; a minute at most.
  std::vector<std::vector<std::byte>> pictures(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, seconds(60), [&] { return pictures_.size() >= count; });
    return pictures_;
  }
  std::vector<std::string> texts(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, seconds(60), [&] { return texts_.size() >= count; });
    return texts_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::vector<std::byte>> pictures_;
  std::vector<std::string> texts_;
};

PictureHeader header_of(const std::vector<std::byte>& message) {
  PictureHeader header;
  const auto read = [&](std::size_t at, auto& out) { std::memcpy(&out, message.data() + at, sizeof out); };
  std::uint16_t width = 0, height = 0;
  read(1, header.codec), read(2, header.spacing), read(4, header.frame), read(8, header.wish);
  read(12, width), read(14, height), read(16, header.trace_ms);
  header.width = width, header.height = height;
  return header;
}

/// The picture of `render`, as a PNG.
std::vector<std::byte> rendered(const ViewedScene& viewed, const Wish& wish) {
  const render::ResolvedScene plan = with_wish(viewed, wish);
  render::Framebuffer picture;
  render::FrameOptions frame = plan.frame;
  frame.channels |= channels_of_annotations(plan);
  render::render(plan.datasets, plan.scene, frame, picture);
  draw_annotations(plan, {}, picture);
  return render::encode_png(picture, {});
}

class FinishedPicture : public testing::TestWithParam<render::LayerType> {};

TEST_P(FinishedPicture, is_that_of_render_without_loss) {
  const TemporaryFolder folder;
  Painter painter(viewed_box(folder, GetParam()), 2);
  Inbox inbox;
  const Painter::ClientId client = painter.add(inbox.sink());
  Wish wish{.number = 3, .width = 90, .height = 70};
  if (GetParam() == render::LayerType::isosurface) wish.isovalues = {{0, 0.6}};
  painter.take(client, wish);
  std::size_t seen = 0;
  for (;;) {  // acknowledges everything until the lossless one is here
    const auto pictures = inbox.pictures(seen + 1);
    ASSERT_GT(pictures.size(), seen) << "nothing more came";
    const PictureHeader header = header_of(pictures[seen++]);
    EXPECT_EQ(header.wish, 3U);
    EXPECT_EQ(header.frame, seen);
    EXPECT_EQ(header.width, 90);
    EXPECT_EQ(header.height, 70);
    painter.take(client, Acknowledgement{header.frame});
    if (header.codec != Codec::png) continue;
    const std::vector<std::byte> png(pictures[seen - 1].begin() + picture_header_bytes, pictures[seen - 1].end());
    EXPECT_EQ(png, rendered(painter.viewed(), wish));
    break;
  }
}

INSTANTIATE_TEST_SUITE_P(Layers, FinishedPicture,
                         testing::Values(render::LayerType::isosurface, render::LayerType::boundary));

TEST(Painter, sends_no_more_than_two_pictures_that_are_not_acknowledged_and_then_the_newest) {
  const TemporaryFolder folder;
  Painter painter(viewed_box(folder), 2);
  Inbox inbox;
  const Painter::ClientId client = painter.add(inbox.sink());
  for (std::uint32_t n = 1; n <= 200; ++n) {
    painter.take(client, Wish{.number = n, .width = 60, .height = 50, .is_moving = true});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(inbox.pictures(2).size(), 2U);
  painter.take(client, Acknowledgement{2});
  const auto after = inbox.pictures(3);
  ASSERT_GE(after.size(), 3U);
  EXPECT_EQ(header_of(after[2]).wish, 200U);
  // An acknowledgement of what was never sent makes no room for more.
  painter.take(client, Acknowledgement{4000000000U});
  painter.take(client, Wish{.number = 201, .width = 60, .height = 50, .is_moving = true});
  EXPECT_GE(inbox.pictures(4).size(), 4U);
}

TEST(Painter, serves_others_while_one_client_floods_and_another_never_acknowledges) {
  const TemporaryFolder folder;
  Painter painter(viewed_box(folder), 2);
  Inbox good, silent, flooding;
  const Painter::ClientId of_good = painter.add(good.sink()), of_silent = painter.add(silent.sink()),
                          of_flooding = painter.add(flooding.sink());
  const std::jthread flood([&](const std::stop_token& stop) {
    for (std::uint32_t n = 1; !stop.stop_requested(); ++n) {
      painter.take(of_flooding, Wish{.number = n, .width = 300, .height = 300, .is_moving = true});
      painter.take(of_flooding, Acknowledgement{n});
    }
  });
  painter.take(of_silent, Wish{.number = 1, .width = 300, .height = 300});
  for (std::uint32_t n = 1; n <= 10; ++n) {
    painter.take(of_good, Wish{.number = n, .width = 60, .height = 50, .is_moving = true});
    const auto pictures = good.pictures(n);
    ASSERT_GE(pictures.size(), n) << "the good client waits for picture " << n;
    painter.take(of_good, Acknowledgement{header_of(pictures.back()).frame});
  }
  EXPECT_LE(silent.pictures(0).size(), 2U);
  painter.remove(of_silent);
}

TEST(Painter, tells_the_command_of_the_newest_wish) {
  const TemporaryFolder folder;
  Painter painter(viewed_box(folder), 1);
  Inbox inbox;
  const Painter::ClientId client = painter.add(inbox.sink());
  painter.take(client, Wish{.number = 1, .isovalues = {{0, 0.25}}, .width = 30, .height = 20});
  painter.take(client, CommandRequest{});
  EXPECT_THAT(inbox.texts(1), testing::ElementsAre(R"({"command":"iso 0.25"})"));
}

TEST(Painter, ends_while_clients_still_wish) {
  const TemporaryFolder folder;
  Inbox inbox;
  Painter painter(viewed_box(folder), 1);
  for (int i = 0; i < 3; ++i) painter.take(painter.add(inbox.sink()), Wish{.number = 1, .width = 2000, .height = 2000});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  painter.stop();
  const std::size_t count = inbox.pictures(0).size();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(inbox.pictures(0).size(), count);
}

}  // namespace
}  // namespace rhoray::tests
