#include "tools/view/drag_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "formats/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/tools/view/viewed.h"
#include "tools/view/server.h"
#include "tools/view/simulated_line.h"

namespace rhoray::tests {
namespace {

using namespace tools;

const DragClient::RequestAt small = [](double) { return std::string(R"("size": [40, 30])"); };

class DragClientTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  Server server_{viewed_box(folder_), {}};
  std::jthread serving_{[this](const std::stop_token& stop) { server_.run(stop); }};
};

TEST_F(DragClientTest, sees_a_picture_for_every_request) {
  DragClient client(server_.url(), server_.port());
  const DragFigures figures = client.drag(0.5, small);
  EXPECT_FALSE(figures.latencies_ms.empty());
  EXPECT_LE(figures.latencies_ms.size(), 32U) << "60 requests a second at most";
  EXPECT_EQ(figures.picture_bytes.size(), figures.spacings.size());
  EXPECT_THAT(figures.picture_bytes, testing::Each(testing::Gt(24)));
  const DragClient::Settled settled = client.settle(small(0));
  EXPECT_GT(settled.whole_ms, 0);
  EXPECT_GT(settled.lossless_ms, settled.whole_ms + 250) << "sent after 300 ms of rest";
}

TEST_F(DragClientTest, waits_for_the_round_trip_of_a_line) {
  const SimulatedLine line(server_.port(), {.round_trip_ms = 30, .megabits_per_s = 20});
  DragClient client(server_.url(), line.port());
  const DragFigures figures = client.drag(0.5, small);
  ASSERT_FALSE(figures.latencies_ms.empty());
  EXPECT_GE(*std::min_element(figures.latencies_ms.begin(), figures.latencies_ms.end()), 29.9);
}

TEST_F(DragClientTest, finds_no_more_than_two_late_pictures_after_a_stall) {
  const SimulatedLine line(server_.port(), {.round_trip_ms = 4, .megabits_per_s = 50});
  DragClient client(server_.url(), line.port());
  const DragFigures figures = client.drag(0.2, small, 1);
  EXPECT_GE(figures.late_pictures, 1U) << "what was under way when the stall began";
  EXPECT_LE(figures.late_pictures, 2U);
}

TEST_F(DragClientTest, is_refused_without_the_token) {
  expect_error(ErrorCode::resource, "no connection to the viewer",
               [&] { DragClient(concat("http://127.0.0.1:", server_.port(), "/#token=0"), server_.port()); });
}

TEST(SimulatedLine, ends_without_a_connection) {
  const SimulatedLine line(1, {});
  EXPECT_GT(line.port(), 0);
}

}  // namespace
}  // namespace rhoray::tests
