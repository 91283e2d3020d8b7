#include "tools/view/sent_pictures.h"

#include <gtest/gtest.h>

namespace rhoray::tests {
namespace {

using tools::SentPictures;

SentPictures::Clock::time_point at(int ms) {
  return SentPictures::Clock::time_point(std::chrono::milliseconds(ms));
}

TEST(SentPictures, are_no_more_than_two_under_way) {
  SentPictures pictures;
  EXPECT_EQ(pictures.next_frame(), 1U);
  EXPECT_TRUE(pictures.has_room());
  EXPECT_EQ(pictures.next_frame(), 2U);
  EXPECT_FALSE(pictures.has_room());
  pictures.draw(1, at(0));
  EXPECT_TRUE(pictures.has_room());
  EXPECT_EQ(pictures.next_frame(), 3U);
  EXPECT_FALSE(pictures.has_room());
  pictures.draw(3, at(0));  // drawn before the second, which is then not needed
  EXPECT_EQ(pictures.next_frame(), 4U);
  EXPECT_TRUE(pictures.has_room());
}

TEST(SentPictures, have_room_for_two_whatever_a_client_claims) {
  SentPictures pictures;
  pictures.next_frame(), pictures.next_frame();
  pictures.draw(1000, at(0));  // never sent
  EXPECT_TRUE(pictures.has_room());
  pictures.draw(1, at(0));  // again
  EXPECT_TRUE(pictures.has_room());
  pictures.next_frame();
  EXPECT_TRUE(pictures.has_room());
  pictures.next_frame();
  EXPECT_FALSE(pictures.has_room());
}

TEST(SentPictures, in_motion_have_a_delay_once) {
  SentPictures pictures;
  pictures.send_moving(pictures.next_frame(), at(10), at(13));
  pictures.send_moving(pictures.next_frame(), at(26), at(30));
  const auto first = pictures.draw(1, at(33));
  ASSERT_TRUE(first);
  EXPECT_DOUBLE_EQ(first->whole_ms, 23);
  EXPECT_DOUBLE_EQ(first->client_ms, 20);
  EXPECT_TRUE(first->was_alone);
  EXPECT_FALSE(pictures.draw(1, at(34)));
  const auto second = pictures.draw(2, at(40));
  ASSERT_TRUE(second);
  EXPECT_DOUBLE_EQ(second->whole_ms, 14);
  EXPECT_FALSE(second->was_alone);
}

TEST(SentPictures, that_a_newer_one_replaced_or_at_rest_have_no_delay) {
  SentPictures pictures;
  pictures.send_moving(pictures.next_frame(), at(0), at(1));
  const std::uint32_t at_rest = pictures.next_frame();
  EXPECT_FALSE(pictures.draw(at_rest, at(5)));
  EXPECT_FALSE(pictures.draw(1, at(6)));
}

}  // namespace
}  // namespace rhoray::tests
