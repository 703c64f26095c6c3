// SPDX-License-Identifier: Apache-2.0
// Message stamps: their order for each writer, and how far ahead they may be.
#include "ros_time.hpp"

#include "drops.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::ros2 {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]

wire::WriterId writer(std::uint8_t number) {
  return {.source = {}, .entity = {number, 0, 0, 3}};
}

TEST(StampOrder, IsKeptForEachWriterOfOneParticipant) {
  StampOrder order(60.0);
  order.note(writer(1), 7 * kSecond);
  EXPECT_THAT(order.problem(writer(1), 6 * kSecond, 5 * kSecond),
              HasSubstr("1 s earlier than the previous one"));
  EXPECT_THAT(order.problem(writer(2), 6 * kSecond, 5 * kSecond), IsEmpty());
  EXPECT_THAT(order.problem(writer(1), 7 * kSecond, 5 * kSecond), IsEmpty());
  EXPECT_THAT(order.problem(writer(1), 0, 5 * kSecond), IsEmpty()) << "no stamp";
}

TEST(StampOrder, RefusesAStampBeyondTheLimitWithBothNumbers) {
  const StampOrder order(60.0);
  EXPECT_THAT(order.problem(writer(1), 70 * kSecond, 10 * kSecond), IsEmpty());
  EXPECT_THAT(order.problem(writer(1), 71 * kSecond, 10 * kSecond),
              HasSubstr("61 s ahead of the time of its bench, more than the stamp_ahead of 60 s"));
  EXPECT_THAT(order.problem(writer(1), 71 * kSecond, std::nullopt), IsEmpty()) << "no bench";
  EXPECT_THAT(StampOrder(0.0).problem(writer(1), 71 * kSecond, 0), IsEmpty()) << "no limit";
}

TEST(StampOrder, BeginsWithAnyStampAfterItWasCleared) {
  StampOrder order(60.0);
  order.note(writer(1), 7 * kSecond);
  order.clear();
  EXPECT_THAT(order.problem(writer(1), 6 * kSecond, 5 * kSecond), IsEmpty());
}

TEST(StampOrder, KeepsABoundedNumberOfWriters) {
  StampOrder order(60.0);
  for (std::size_t i = 0; i <= StampOrder::kMostWriters; ++i) {
    wire::WriterId one = writer(1);
    one.entity[1] = static_cast<std::uint8_t>(i);
    one.entity[2] = static_cast<std::uint8_t>(i >> 8U);
    order.note(one, 7 * kSecond);
  }
  EXPECT_THAT(order.problem(writer(1), 6 * kSecond, 5 * kSecond), IsEmpty()) << "forgotten";
}

TEST(DroppedMessage, HasItsSizeAndTheLimit) {
  EXPECT_EQ(dropped_message("Change payload size of '8800000' bytes is larger than the history "
                            "payload size of '4194307' bytes and cannot be resized."),
            "a message of 8800000 bytes was dropped: at most 4194307 are read");
  EXPECT_EQ(dropped_message("Change payload size of"), "Change payload size of");
  EXPECT_EQ(dropped_message("something else 'a' 'b'"), "something else 'a' 'b'");
}

}  // namespace
}  // namespace vdrive::ros2
