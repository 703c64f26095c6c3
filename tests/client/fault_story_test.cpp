// SPDX-License-Identifier: Apache-2.0
// The causes of a fault, told from its window alone.
#include "vdrive/client/fault_story.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace vdrive::client {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr ObjectAddress kBlockedLoad{0x5E01, 0};
constexpr ObjectAddress kControlword{0x6040, 0};
constexpr ObjectAddress kFollowingWindow{0x6065, 0};
constexpr std::uint64_t kFault = 100;
constexpr std::uint32_t kFollowingError = 0x8611;

/// Ticks 0 to 100 of axis 1 of bench 1, with a fault in the last one.
Window window_with_fault() {
  Window window;
  window.kept.causes = {{.kind = WindowCause::Kind::fault,
                         .axis = 1,
                         .code = kFollowingError,
                         .session = 0,
                         .tick = kFault}};
  for (std::uint64_t tick = 0; tick <= kFault; ++tick) {
    Observation& sample = window.samples.emplace_back();
    sample.tick = tick;
    AxisSnapshot& axis = sample.axes.emplace_back();
    axis.id = {1, 1};
    axis.tick = tick;
  }
  return window;
}

AxisWrite write(std::uint64_t tick, ObjectAddress object, std::int64_t value) {
  AxisWrite made;
  made.axis = 1;
  made.tick = tick;
  made.session = 7;
  made.object = object;
  made.value = value;
  return made;
}

FaultStory tell(const Window& window) {
  BenchInfo bench;
  bench.number = 1;
  bench.period = std::chrono::microseconds(1'000);
  return story_of(window, window.kept.causes.front(), bench, [](std::uint64_t session) {
    return "program " + std::to_string(session);
  });
}

TEST(StoryOfAFault, NamesItWithWhatToLookAt) {
  const FaultStory story = tell(window_with_fault());
  EXPECT_EQ(story.title, "axis 1.1: 8611h following error at tick 100");
  EXPECT_THAT(story.remedy, HasSubstr("6065h"));
}

TEST(StoryOfAFault, NamesTheInputOfTheTestBenchThatActedAndWhoSetIt) {
  Window window = window_with_fault();
  window.writes = {write(60, kBlockedLoad, 1)};
  // tick 100 - 60 at 1 ms
  EXPECT_THAT(tell(window).lines, Contains(AllOf(HasSubstr("5E01h"), HasSubstr("40 ms before"),
                                                 HasSubstr("program 7"))));
}

TEST(StoryOfAFault, ForgetsAnInputThatWasSetBackOrUndoneByASnapshot) {
  Window window = window_with_fault();
  window.writes = {write(60, kBlockedLoad, 1), write(70, kBlockedLoad, 0)};
  EXPECT_THAT(tell(window).lines, Not(Contains(HasSubstr("5E01h"))));
  window.writes = {write(60, kBlockedLoad, 1)};
  window.values = {{.tick = 80, .axis = 1, .object = kBlockedLoad, .value = 0}};
  EXPECT_THAT(tell(window).lines, Not(Contains(HasSubstr("5E01h"))));
}

TEST(StoryOfAFault, SaysHowLongTheFollowingErrorWasBeyondItsWindow) {
  Window window = window_with_fault();
  window.values = {{.tick = 0, .axis = 1, .object = kFollowingWindow, .value = 500}};
  for (std::uint64_t tick = 0; tick <= kFault; ++tick) {
    // Above 500 UU once early on, and then from tick 75 on.
    window.samples[tick].axes.front().status.load_position_error_value =
        tick == 20 || tick >= 75 ? -600 : 10;
  }
  EXPECT_THAT(tell(window).lines, Contains(AllOf(HasSubstr("6065h"), HasSubstr("500"),
                                                 HasSubstr("tick 75, 25 ms before"))));
}

TEST(StoryOfAFault, DoesNotNameAControlwordFromBeforeAPowerCycle) {
  Window window = window_with_fault();
  window.writes = {write(10, kControlword, 0x0F), write(20, kControlword, 0)};
  window.writes.back().kind = AxisWrite::Kind::power_cycle;
  EXPECT_THAT(tell(window).lines, Not(Contains(HasSubstr("controlword"))));
}

TEST(StoryOfAFault, BlamesALostMasterOnlyWhereThisAxisHasLostIts) {
  Window window = window_with_fault();
  window.events = {
      {.tick = 90, .kind = EventKind::master_lost, .axis = 0, .session = 9, .code = 0}};
  EXPECT_THAT(tell(window).lines, Not(Contains(HasSubstr("fell silent"))));
  window.writes = {write(90, {}, 0)};
  window.writes.back().kind = AxisWrite::Kind::connection_loss;
  EXPECT_THAT(tell(window).lines,
              Contains(AllOf(HasSubstr("fell silent"), HasSubstr("program 9"))));
}

}  // namespace
}  // namespace vdrive::client
