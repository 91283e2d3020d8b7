#include "tools/rhoray/cli/progress_display.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rhoray::tools {
namespace {

TEST(Progress, tells_rate_and_time_left_of_what_is_counted) {
  const Pace pace = pace_of("writing samples (bytes)", 25 << 20, 100 << 20, 0.5);
  EXPECT_EQ(pace.what, "writing samples");
  EXPECT_EQ(pace.counted, "bytes");
  EXPECT_EQ(pace.share, 0.25);
  EXPECT_EQ(pace.rate_per_s, 50 << 20);
  EXPECT_EQ(pace.seconds_left, 1.5);
  EXPECT_EQ(bar_text(pace), "writing samples [=======                       ] 25%, 50.0 MiB/s, 2 s left");
  EXPECT_EQ(bar_text(pace_of("sorting (cells)", 3'000'000, 4'000'000, 2)),
            "sorting [======================        ] 75%, 1.5 M cells/s, 1 s left");
}

TEST(Progress, promises_no_more_than_is_known) {
  EXPECT_EQ(bar_text(pace_of("reading", 0, 0, 10)), "reading");
  EXPECT_EQ(bar_text(pace_of("writing (bytes)", 0, 100, 10)), "writing");
  EXPECT_EQ(bar_text(pace_of("writing (bytes)", 50, 100, 0.01)), "writing [===============               ] 50%");
  EXPECT_EQ(bar_text(pace_of("sealing", 1, 1, 5)), "sealing [==============================] 100%");
  EXPECT_EQ(pace_of("reading (bytes)", 10, 0, 1).seconds_left, 0);
  EXPECT_EQ(pace_of("writing (bytes)", 200, 100, 1).share, 1);
  EXPECT_EQ(pace_of("(bytes", 1, 2, 1).what, "(bytes");
}

TEST(Progress, counts_long_times_in_minutes_and_hours) {
  EXPECT_THAT(bar_text(pace_of("a (b)", 1, 121, 1)), testing::EndsWith("1 b/s, 2 min 0 s left"));
  EXPECT_THAT(bar_text(pace_of("a (b)", 1, 7301, 1)), testing::EndsWith(", 2 h 1 min left"));
}

}  // namespace
}  // namespace rhoray::tools
